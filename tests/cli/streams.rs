//! Standard output and standard error that cannot be written to.

use std::fs::OpenOptions;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use crate::support::fixture::fixture;
use crate::support::{assert_same_trees, scenes};

/// A stream whose reader has gone away, as with `| head -1`.
fn closed() -> Stdio {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    writer.into()
}

/// A stream to a full disk.
fn full() -> Stdio {
    OpenOptions::new().write(true).open("/dev/full").unwrap().into()
}

fn program(arguments: &[PathBuf]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_underbrush"));
    command.args(arguments).stdin(Stdio::null());
    command
}

fn call(arguments: &[PathBuf], stderr: Stdio) -> Output {
    program(arguments).stderr(stderr).output().unwrap()
}

/// Tests that errors keep their exit status if stderr is full or its reader is gone.
#[test]
fn an_error_that_cannot_be_shown_keeps_its_status() {
    let arguments = ["inspect".into(), "no-such-scene.toml".into()];
    assert_eq!(call(&arguments, Stdio::piped()).status.code(), Some(2));
    for stderr in [closed(), full()] {
        assert_eq!(call(&arguments, stderr).status.code(), Some(2));
    }
    // Errors of the option parser are printed by other code.
    for stderr in [closed(), full()] {
        assert_eq!(call(&["reach".into(), "--seed".into(), "x".into()], stderr).status.code(), Some(2));
    }
}

/// Tests that remarks and warnings that cannot be printed change neither the exit status nor the result: an online
/// classification, which prints its latency on stderr, prints the same, and a data set has the same bytes.
#[test]
fn the_loss_of_stderr_changes_no_result() {
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("reach.parquet");
    let reach = ["reach".into(), fixture().trunk_scene(), "--out".into(), recording.clone()];
    assert_eq!(call(&reach, full()).status.code(), Some(0));
    let classify = ["classify".into(), fixture().model(), recording, "--online".into()];
    let sound = call(&classify, Stdio::piped());
    assert!(!sound.stderr.is_empty() && !sound.stdout.is_empty());
    for stderr in [closed(), full()] {
        let deaf = call(&classify, stderr);
        assert_eq!(deaf.status.code(), Some(0));
        assert!(deaf.stdout == sound.stdout);
    }
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let sets = [("sound", Stdio::piped()), ("closed", closed()), ("full", full())].map(|(name, stderr)| {
        let set = folder.path().join(name);
        let options = ["--reaches", "2", "--out"].map(PathBuf::from);
        let arguments = [&["generate".into(), scene.clone()], &options[..], std::slice::from_ref(&set)].concat();
        assert_eq!(call(&arguments, stderr).status.code(), Some(0));
        set
    });
    assert_same_trees(&sets[0], &sets[1]);
    assert_same_trees(&sets[0], &sets[2]);
}

/// Tests that the program ends quietly if the reader of stdout goes away, and that a full disk is reported as an
/// error.
#[test]
fn stdout_that_cannot_be_written() {
    let arguments = ["score".into(), fixture().model(), fixture().table_csv()];
    let gone = program(&arguments).stdout(closed()).stderr(Stdio::piped()).output().unwrap();
    assert_eq!((gone.status.code(), &gone.stderr[..]), (Some(0), &b""[..]));
    let no_room = program(&arguments).stdout(full()).stderr(Stdio::piped()).output().unwrap();
    let stderr = String::from_utf8(no_room.stderr).unwrap();
    assert_eq!(no_room.status.code(), Some(1));
    assert!(stderr.contains("cannot write to standard output"), "{stderr}");
    let help = program(&["--help".into()]).stdout(full()).stderr(Stdio::null()).status().unwrap();
    assert_eq!(help.code(), Some(1));
    // Both at once.
    let mute = program(&arguments).stdout(full()).stderr(full()).status().unwrap();
    assert_eq!(mute.code(), Some(1));
}
