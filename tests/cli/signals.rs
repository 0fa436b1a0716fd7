//! SIGINT, SIGTERM, SIGHUP and SIGKILL.

use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

use crate::support::fixture::fixture;
use crate::support::{assert_same_trees, scenes, tree, underbrush};

/// Starts the program, sends `signal` as soon as `ready` holds, and waits for its end. `None` if it ended before.
fn interrupted(arguments: &[PathBuf], signal: &str, ready: impl Fn() -> bool) -> Option<Output> {
    // The test runner may ignore SIGHUP, as nohup does, and the program would inherit that.
    let mut program = match cfg!(target_os = "linux") {
        true => Command::new("env"),
        false => Command::new(env!("CARGO_BIN_EXE_underbrush")),
    };
    if cfg!(target_os = "linux") {
        program.args(["--default-signal=HUP", env!("CARGO_BIN_EXE_underbrush")]);
    }
    let mut program =
        program.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    while !ready() {
        if program.try_wait().unwrap().is_some() {
            return None;
        }
        std::thread::sleep(Duration::from_micros(200));
    }
    Command::new("kill").arg(format!("-{signal}")).arg(program.id().to_string()).status().unwrap();
    Some(program.wait_with_output().unwrap())
}

/// The temporary files below a folder.
fn unfinished(folder: &Path) -> Vec<PathBuf> {
    let is_unfinished = |path: &PathBuf| path.to_string_lossy().contains(".underbrush-unfinished-");
    tree(folder).into_keys().filter(is_unfinished).collect()
}

/// Tests that an interrupted `generate` ends by the signal that it received (130, 143 and 129 for a shell), prints how
/// to continue, keeps staged reaches and leaves no temporary file, and that it can be continued to the same bytes.
#[test]
fn generate_can_be_interrupted_and_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let generate = |set: &Path, reaches: &str| -> Vec<PathBuf> {
        let options = ["--reaches", reaches, "--jobs", "1", "--out"].map(PathBuf::from);
        [&["generate".into(), scene.clone()], &options[..], &[set.to_path_buf()]].concat()
    };
    for (name, number) in [("INT", 2), ("TERM", 15), ("HUP", 1)] {
        let set = folder.path().join(name);
        let first = set.join("incomplete/reach-000000.json");
        // Far more reaches than can be finished before the signal arrives.
        let output = interrupted(&generate(&set, "200"), name, || first.exists()).unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.signal(), Some(number), "{stderr}");
        assert!(output.stdout.is_empty());
        assert!(stderr.contains("--resume") && stderr.contains(&set.display().to_string()), "{stderr}");
        assert!(first.exists() && set.join("incomplete/reach-000000.bin").exists());
        assert_eq!(unfinished(&set), Vec::<PathBuf>::new());
    }
    // `--resume` with `--force` would be refused.
    let set = folder.path().join("forced");
    let first = set.join("incomplete/reach-000000.json");
    let forced = [generate(&set, "200"), vec!["--force".into()]].concat();
    let output = interrupted(&forced, "INT", || first.exists()).unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(stderr.contains("the same command with --resume in place of --force"), "{stderr}");
    // Again with few reaches, and resumed until the set is complete.
    let [whole, resumed] = ["whole", "resumed"].map(|name| folder.path().join(name));
    let first = resumed.join("incomplete/reach-000000.json");
    if let Some(output) = interrupted(&generate(&resumed, "4"), "TERM", || first.exists()) {
        assert_eq!(output.status.signal(), Some(15));
    }
    underbrush!["generate", scene, "--reaches", "4", "--out", resumed, "--resume"].success();
    underbrush!["generate", scene, "--reaches", "4", "--out", whole].success();
    assert_same_trees(&whole, &resumed);
}

/// Tests that `generate` under nohup outlives its terminal: it goes on after SIGHUP and completes the set.
#[cfg(target_os = "linux")]
#[test]
fn nohup_is_respected() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let set = folder.path().join("set");
    let script = "trap '' HUP; \"$1\" generate \"$2\" --reaches 4 --out \"$3\" --jobs 1 & \
                  until [ -e \"$3/incomplete/plan.json\" ]; do sleep 0.01; done; kill -HUP $!; wait $!";
    let status = Command::new("sh")
        .args(["-c", script, "sh", env!("CARGO_BIN_EXE_underbrush")])
        .args([&scene, &set])
        .status()
        .unwrap();
    assert_eq!(status.code(), Some(0));
    underbrush!["inspect", set].success();
}

/// A table so long that the test can see it being written.
fn long_table(folder: &Path) -> PathBuf {
    let path = folder.join("long.csv");
    let rows = (0..400_000).map(|row| format!("{},{},0.25\n", row / 100, f64::from(row) / 100.0));
    std::fs::write(&path, "trial,time_s,force_n\n".to_owned() + &rows.collect::<String>()).unwrap();
    path
}

/// Tests that `trials` leaves no temporary file when SIGINT or SIGTERM ends it, that SIGKILL leaves one, and that the
/// next run with the same output removes it.
#[test]
fn trials_leave_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let outputs = tempfile::tempdir().unwrap();
    let (table, out) = (long_table(folder.path()), outputs.path().join("out.csv"));
    let trials: [PathBuf; 4] = ["trials".into(), table, "--out".into(), out.clone()];
    // The program first makes and removes an empty file to see whether it can write there, so an empty one is no sign.
    let at_work = || {
        let mut files = std::fs::read_dir(outputs.path()).unwrap().map(Result::unwrap);
        files.any(|file| file.metadata().is_ok_and(|metadata| metadata.len() > 0))
    };
    // Writing takes a good part of a second. If the test was too slow to see it or to send the signal, it tries again.
    let interrupt = |signal: &str, number: i32| {
        (0..20).any(|_| {
            let _ = std::fs::remove_file(&out);
            interrupted(&trials, signal, at_work).is_some_and(|output| output.status.signal() == Some(number))
        })
    };
    for (name, number) in [("INT", 2), ("TERM", 15)] {
        assert!(interrupt(name, number), "SIG{name}");
        assert_eq!(unfinished(outputs.path()), Vec::<PathBuf>::new(), "after SIG{name}");
    }
    assert!(interrupt("KILL", 9));
    assert_eq!(unfinished(outputs.path()).len(), 1, "SIGKILL cannot be answered");
    let small = fixture().table_csv();
    underbrush!["trials", small, "--out", out].success();
    assert_eq!(tree(outputs.path()).into_keys().collect::<Vec<_>>(), [PathBuf::from("out.csv")]);
}

/// Tests that `train` leaves none of the reaches that it simulates when a signal ends it.
#[test]
fn train_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let outputs = tempfile::tempdir().unwrap();
    let options = ["--classifier", "touch", "--reaches", "200", "--jobs", "1", "--out"].map(PathBuf::from);
    let train = [&["train".into(), scene], &options[..], &[outputs.path().join("model.json")]].concat();
    let is_staged = || {
        let mut made = std::fs::read_dir(outputs.path()).unwrap();
        made.any(|folder| folder.unwrap().path().join("known/incomplete/reach-000000.json").exists())
    };
    assert_eq!(interrupted(&train, "INT", is_staged).unwrap().status.signal(), Some(2));
    assert_eq!(std::fs::read_dir(outputs.path()).unwrap().count(), 0);
}

/// Tests that a shell sees exit status 130.
#[test]
fn a_shell_sees_the_signal() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let set = folder.path().join("set");
    let script = "\"$1\" generate \"$2\" --reaches 200 --out \"$3\" --jobs 1 2>/dev/null & \
                  until [ -e \"$3/incomplete/plan.json\" ]; do sleep 0.01; done; kill -INT $!; wait $!; echo $?";
    let output = Command::new("sh")
        .args(["-c", script, "sh", env!("CARGO_BIN_EXE_underbrush")])
        .args([&scene, &set])
        .output()
        .unwrap();
    assert_eq!(String::from_utf8(output.stdout).unwrap().trim(), "130");
}
