//! What fuzz targets do about panics.

/// Makes panics silent. The decoder of Parquet panics on some damaged files, and the readers turn these
/// panics into errors. libFuzzer's hook would end the program at once. A panic that the readers do not catch still ends
/// the program, because `fuzz_target!` reports it.
pub fn expect_panics() {
    std::panic::set_hook(Box::new(|panic| {
        if std::env::var_os("UNDERBRUSH_FUZZ_PANICS").is_some() {
            eprintln!("{panic}");
        }
    }));
}
