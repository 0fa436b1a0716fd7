//! `underbrush generate --shared`: parts of a campaign in one folder.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use underbrush_recording::disk::Dataset;

use crate::support::{assert_same_trees, call, scenes, tree, underbrush};

/// The arguments for part `shard` of ten reaches.
fn arguments(scene: &Path, out: &Path, shard: &str) -> Vec<PathBuf> {
    let options = ["--reaches", "10", "--seed", "4", "--jobs", "1", "--shared", "--shard", shard].map(PathBuf::from);
    let places = [PathBuf::from("--out"), out.into()];
    [&["generate".into(), scene.into()], &options[..], &places].concat()
}

/// Starts a part without waiting for it.
fn start(scene: &Path, out: &Path, shard: &str) -> Child {
    Command::new(env!("CARGO_BIN_EXE_underbrush"))
        .args(arguments(scene, out, shard))
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// Tests that parts that run at the same time, one of them twice and one killed and run again, make the set of one
/// process, byte for byte, and that every part then has nothing to do.
#[test]
fn processes_make_one_set_together() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let [whole, shared] = ["whole", "shared"].map(|name| folder.path().join(name));
    underbrush!["generate", scene, "--reaches", "10", "--seed", "4", "--out", whole].success();
    let mut killed = start(&scene, &shared, "3/3");
    while !shared.join("incomplete/plan.json").exists() {
        assert!(killed.try_wait().unwrap().is_none(), "the part ended before it was killed");
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    let parts = ["1/3", "2/3", "2/3"].map(|shard| start(&scene, &shared, shard));
    for mut part in parts {
        assert!(part.wait().unwrap().success());
    }
    underbrush!["inspect", shared].refused(&["unfinished"]);
    let last = underbrush![
        "generate",
        scene,
        "--reaches",
        "10",
        "--seed",
        "4",
        "--shared",
        "--shard",
        "3/3",
        "--out",
        shared,
        "--json"
    ];
    assert_eq!(last.json()["reaches"], 10);
    assert_same_trees(&whole, &shared);
    let before = tree(&shared);
    let again =
        underbrush!["generate", scene, "--reaches", "10", "--seed", "4", "--shared", "--shard", "2/3", "--out", shared];
    assert!(again.stderr.contains("there is nothing to do"), "{}", again.stderr);
    assert_eq!(again.status, 0);
    assert!(before == tree(&shared));
}

/// Tests what a part says when others are still to come, and that parts of another campaign, folders with other files,
/// parts without reaches and options that do not apply are refused.
#[test]
fn what_does_not_belong_into_the_folder_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let shared = folder.path().join("shared");
    let part = |reaches: &str, seed: &str, shard: &str, further: &str, out: &Path| {
        underbrush![
            "generate",
            scene,
            "--reaches",
            reaches,
            "--seed",
            seed,
            "--shard",
            shard,
            further,
            "--out",
            out,
            "--json"
        ]
    };
    let first = part("2", "4", "1/2", "--shared", &shared).json();
    assert_eq!(first["part"], "1/2");
    assert_eq!(first["finished"], false);
    part("2", "5", "2/2", "--shared", &shared).refused(&["another plan", "provenance.seed was 4, now 5"]);
    part("3", "4", "2/2", "--shared", &shared).refused(&["another plan", "reaches was 2, now 3"]);
    // Without --shared, the folder is taken for the folder of one process or of one part.
    part("2", "4", "2/2", "--resume", &shared).refused(&["another plan", "shard"]);
    part("2", "4", "3/3", "--shared", &shared).refused(&["part 3/3 has no reach"]);
    part("2", "4", "1/2", "--shared", folder.path()).refused(&["is not empty and holds no data set"]);
    underbrush!["generate", scene, "--reaches", "2", "--shared", "--out", shared].refused(&["--shard"]);
    underbrush!["generate", scene, "--reaches", "2", "--shard", "1/2", "--shared", "--resume", "--out", shared]
        .refused(&["--shared", "--resume"]);
}

/// Tests that the part that finishes last says what to run if a reach of another part is damaged, and that this helps.
#[test]
fn a_damaged_reach_of_another_part_is_run_again() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let out = folder.path().join("shared");
    let run = |shard: &str| start(&scene, &out, shard).wait().unwrap();
    assert!(run("1/2").success());
    std::fs::write(out.join("incomplete/reach-000002.bin"), "cut").unwrap();
    call(arguments(&scene, &out, "2/2").into_iter().map(Into::into).collect(), "")
        .refused(&["missing or damaged: 1, the first at position 2; run the part that holds it again"]);
    assert!(run("1/2").success());
    assert_eq!(Dataset::open(&out).unwrap().episodes().len(), 10);
}
