//! The same bytes on processors of another kind.
//!
//! The C library picks variants of its functions by processor, and `GLIBC_TUNABLES` makes it pick those of one without FMA
//! and AVX2. If the program took a function from it, the last digits of that function's values would differ here.

use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;

use crate::support::{assert_same_trees, scenes};

const OLD_PROCESSOR: &str = "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX,-AVX512F,-SSE4_1";

/// Makes the same files in a folder with or without these tunables: a recording, a data set, trials, models of both kinds
/// and their verdicts frame by frame.
fn make(folder: &Path, tunables: Option<&str>) {
    std::fs::create_dir(folder).unwrap();
    let leaf = scenes::write(folder, "leaf.toml", scenes::LEAVES_AT_FOREARM);
    let trunk = scenes::write(folder, "trunk.toml", scenes::TRUNKS_AT_FOREARM);
    let [reach, set, hmm, touch] =
        ["reach.parquet", "set", "hmm.json", "touch.json"].map(|name| folder.join(name).into_os_string());
    let [leaf, trunk] = [leaf, trunk].map(|path| path.into_os_string());
    let run = |name: &str, arguments: &[&OsStr]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_underbrush"));
        command.args(arguments).env_remove("GLIBC_TUNABLES");
        if let Some(tunables) = tunables {
            command.env("GLIBC_TUNABLES", tunables);
        }
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        // What commands print names the folder.
        if name.starts_with("verdicts") {
            std::fs::write(folder.join(name), output.stdout).unwrap();
        }
    };
    let text = OsStr::new;
    run(
        "",
        &[text("reach"), &leaf, text("--seed"), text("3"), text("--out"), &reach],
    );
    run(
        "",
        &[
            text("generate"),
            &leaf,
            &trunk,
            text("--reaches"),
            text("2"),
            text("--seed"),
            text("1"),
            text("--out"),
            &set,
        ],
    );
    run(
        "",
        &[text("train"), &set, text("--states"), text("3"), text("--out"), &hmm],
    );
    run(
        "",
        &[
            text("train"),
            &set,
            text("--classifier"),
            text("touch"),
            text("--out"),
            &touch,
        ],
    );
    for (name, model) in [("verdicts-hmm", &hmm), ("verdicts-touch", &touch)] {
        run(name, &[text("classify"), model, &reach, text("--online")]);
    }
}

/// Tests that reaches, data sets, models and verdicts have the same bytes on a processor without FMA and AVX.
#[test]
fn bytes_do_not_depend_on_the_processor() {
    let folder = tempfile::tempdir().unwrap();
    let [own, old] = ["own", "old"].map(|name| folder.path().join(name));
    make(&own, None);
    make(&old, Some(OLD_PROCESSOR));
    assert!(std::fs::metadata(own.join("verdicts-touch")).unwrap().len() > 10_000);
    assert_same_trees(&own, &old);
}
