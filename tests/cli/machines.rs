//! The same bytes on machines with another processor and another math library.

use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::Command;

use crate::support::{assert_same_trees, scenes, tree};

/// Makes the GNU C library choose the variants of its functions that it has for processors without FMA and AVX.
const OLD_PROCESSOR: (&str, &str) = ("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX,-AVX512F,-SSE4_1");

/// Makes the same files in a folder with a variable of the environment: a recording, a data set, models of both kinds and
/// their verdicts frame by frame.
fn make(folder: &Path, variable: Option<(&str, &OsStr)>) {
    std::fs::create_dir(folder).unwrap();
    let leaf = scenes::write(folder, "leaf.toml", scenes::LEAVES_AT_FOREARM).into_os_string();
    let trunk = scenes::write(folder, "trunk.toml", scenes::TRUNKS_AT_FOREARM).into_os_string();
    let [reach, set, hmm, touch] =
        ["reach.parquet", "set", "hmm.json", "touch.json"].map(|name| folder.join(name).into_os_string());
    let run = |command: &str, files: &[&OsString], options: &str| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_underbrush"));
        program.arg(command).args(files).args(options.split_whitespace());
        program.env_remove("GLIBC_TUNABLES").envs(variable);
        let output = program.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    };
    let out = OsString::from("--out");
    run("reach", &[&leaf, &out, &reach], "--seed 3");
    run("generate", &[&leaf, &trunk, &out, &set], "--reaches 3 --seed 1");
    run("train", &[&set, &out, &hmm], "--states 3");
    run("train", &[&set, &out, &touch], "--classifier touch");
    for (name, model) in [("verdicts-hmm", &hmm), ("verdicts-touch", &touch)] {
        std::fs::write(folder.join(name), run("classify", &[model, &reach], "--online")).unwrap();
    }
}

/// Tests that reaches, data sets, models and verdicts have the same bytes on a processor without FMA and AVX, and with a
/// math library whose functions return other last digits.
#[test]
fn bytes_do_not_depend_on_the_machine() {
    let folder = tempfile::tempdir().unwrap();
    let library = folder.path().join("other_libm.so");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/other_libm.c");
    let compiled = Command::new("cc")
        .args(["-fno-builtin", "-shared", "-fPIC", "-o"])
        .args([&library, &source])
        .arg("-ldl")
        .status();
    assert!(compiled.unwrap().success());
    let [own, processor, other] = ["own", "processor", "library"].map(|name| folder.path().join(name));
    make(&own, None);
    make(&processor, Some((OLD_PROCESSOR.0, OLD_PROCESSOR.1.as_ref())));
    make(&other, Some(("LD_PRELOAD", library.as_os_str())));
    assert!(tree(&own).len() > 10);
    assert_same_trees(&own, &processor);
    assert_same_trees(&own, &other);
}
