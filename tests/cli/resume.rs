//! `underbrush generate --resume`.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::{assert_same_trees, scenes, underbrush};

/// Starts a campaign on one thread and kills it when the first reach has been staged.
pub(super) fn interrupted(scene: &Path, out: &Path) {
    let mut child = Command::new(env!("CARGO_BIN_EXE_underbrush"))
        .args(["generate", "--reaches", "8", "--seed", "3", "--jobs", "1", "--out"])
        .args([out, scene])
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let start = Instant::now();
    // The checksum of a staged reach is written after the reach.
    while !staged(out).iter().any(|path| path.extension().is_some_and(|extension| extension == "json")) {
        assert!(start.elapsed() < Duration::from_secs(120), "no reach was staged");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(out.join("incomplete/plan.json").exists(), "the campaign ended before it was killed");
    assert!(!out.join("meta/info.json").exists());
}

/// Staged reaches and their checksums.
fn staged(out: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(out.join("incomplete")) else {
        return Vec::new();
    };
    let paths = entries.map(|entry| entry.unwrap().path());
    let mut staged: Vec<_> =
        paths.filter(|path| path.file_name().unwrap().to_string_lossy().starts_with("reach-")).collect();
    staged.sort();
    staged
}

/// Tests that a killed run leaves a set that is refused as unfinished, can only be continued with --resume, and then
/// has the same bytes as after an uninterrupted run. A truncated staged reach is run again.
#[test]
fn a_killed_run_resumes_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let [unbroken, broken] = ["unbroken", "broken"].map(|name| folder.path().join(name));
    underbrush!["generate", scene, "--reaches", "8", "--seed", "3", "--out", unbroken].success();
    interrupted(&scene, &broken);

    let name = broken.display().to_string();
    underbrush!["inspect", broken].refused(&[&name, "unfinished", "run what began it again, with --resume"]);
    underbrush!["generate", scene, "--reaches", "8", "--seed", "3", "--out", broken].refused(&[&name, "--resume"]);
    let other_seed = underbrush!["generate", scene, "--reaches", "8", "--seed", "9", "--out", broken, "--resume"];
    other_seed.refused(&[&name, "provenance.seed was 3, now 9", "options and version"]);

    let first = staged(&broken).into_iter().find(|path| path.extension().unwrap() == "bin").unwrap();
    let bytes = std::fs::read(&first).unwrap();
    std::fs::write(&first, &bytes[..bytes.len() / 2]).unwrap();
    underbrush!["generate", scene, "--reaches", "8", "--seed", "3", "--out", broken, "--resume"].success();
    assert_same_trees(&unbroken, &broken);
    assert!(!broken.join("incomplete").exists());
}

/// Tests that no run changes a finished data set, that `--resume` with the same plan reports that there is nothing to
/// do, and that with another plan it reports the difference.
#[test]
fn a_finished_set_is_not_written_again() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let out = folder.path().join("set");
    underbrush!["generate", scene, "--reaches", "1", "--out", out].success();
    let before = crate::support::tree(&out);
    underbrush!["generate", scene, "--reaches", "1", "--out", out]
        .refused(&["finished data set", "choose another folder"]);
    let other = underbrush!["generate", scene, "--reaches", "1", "--out", out, "--seed", "5", "--resume"];
    other.refused(&["provenance.seed was 0, now 5"]);
    let same = underbrush!["generate", scene, "--reaches", "1", "--out", out, "--resume", "--json"];
    assert!(same.stderr.contains("nothing to do"), "{}", same.stderr);
    assert_eq!(same.json()["reaches"], 1);
    assert!(before == crate::support::tree(&out));
}
