//! What fuzz targets do about panics.

/// Makes panics silent: decoders of Parquet, HDF5 and MCAP panic on some damaged files, which the readers turn into
/// errors. libFuzzer's hook would end the program there. A panic that is not caught still ends it, because
/// `fuzz_target!` catches and reports it.
pub fn expect_panics() {
    std::panic::set_hook(Box::new(|panic| {
        if std::env::var_os("UNDERBRUSH_FUZZ_PANICS").is_some() {
            eprintln!("{panic}");
        }
    }));
}
