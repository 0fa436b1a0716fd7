//! `underbrush merge`, of parts that `generate --shard` made.

use std::path::{Path, PathBuf};

use crate::support::{Answer, assert_same_trees, call, scenes, underbrush};

/// Generates ten reaches of two scenes, or a part of them.
fn generate(folder: &Path, name: &str, shard: Option<&str>, seed: &str) -> PathBuf {
    let leaf = scenes::write(folder, "leaf.toml", scenes::FEW_LEAVES);
    let trunk = scenes::write(folder, "trunk.toml", scenes::FEW_TRUNKS);
    let out = folder.join(name);
    let mut arguments = vec!["generate".into(), leaf.into(), trunk.into(), "--out".into(), out.clone().into()];
    arguments.extend(["--reaches", "5", "--seed", seed].map(Into::into));
    arguments.extend(shard.into_iter().flat_map(|shard| ["--shard".into(), shard.into()]));
    call(arguments, "").success();
    out
}

fn merge(parts: &[PathBuf], out: &Path, further: &[&str]) -> Answer {
    let mut arguments = vec!["merge".into(), "--out".into(), out.into()];
    arguments.extend(further.iter().map(Into::into));
    arguments.extend(parts.iter().map(Into::into));
    call(arguments, "")
}

/// Tests that three and seven parts merge into the files that one process makes, byte for byte, that the result can be
/// used like any other set, and that it can be merged again.
#[test]
fn parts_merge_into_the_bytes_of_one_process() {
    let folder = tempfile::tempdir().unwrap();
    let whole = generate(folder.path(), "whole", None, "4");
    for count in [3, 7] {
        let part = |index| {
            let shard = format!("{index}/{count}");
            generate(folder.path(), &format!("part {index} of {count}"), Some(&shard), "4")
        };
        let parts: Vec<PathBuf> = (1..=count).map(part).collect();
        let merged = folder.path().join(format!("merged-{count}"));
        let summary = merge(&parts, &merged, &["--json"]).json();
        assert_eq!(summary["reaches"], 10);
        assert_same_trees(&whole, &merged);
        assert_eq!(merge(&parts, &merged, &["--resume", "--json"]).json(), summary);
        merge(&parts, &merged, &[]).refused(&["holds a finished data set"]);
        assert!(underbrush!["inspect", merged].success().contains("reaches: 10"));
    }
}

/// Tests that missing, repeated and foreign parts, whole sets and unfinished parts are refused by name, and that
/// nothing is written.
#[test]
fn what_does_not_fit_together_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let part = |index: u32| generate(folder.path(), &format!("part-{index}"), Some(&format!("{index}/3")), "4");
    let parts: Vec<PathBuf> = (1..=3).map(part).collect();
    let whole = generate(folder.path(), "whole", None, "4");
    let other_seed = generate(folder.path(), "other-seed", Some("3/3"), "5");
    let [first, second, third] = [0, 1, 2].map(|index: usize| parts[index].clone());
    let out = folder.path().join("merged");

    merge(&[first.clone(), third.clone()], &out, &[]).refused(&["2 of 3 parts, without 2/3", "--shard"]);
    merge(&[first.clone(), second.clone(), second.clone(), third.clone()], &out, &[]).refused(&[
        "part-2",
        "found 2/3, which",
        "each part once",
    ]);
    merge(&[first.clone(), second.clone(), other_seed], &out, &[]).refused(&[
        "other-seed: provenance.seed: found 5",
        "allowed: 4, as in",
        "part-1",
    ]);
    merge(&[first.clone(), whole], &out, &[]).refused(&["whole: shard", "a whole campaign"]);
    let inner = first.join("inner");
    merge(&parts, &inner, &[]).refused(&["part-1", "an input of this command"]);
    assert!(!inner.exists());
    std::fs::remove_file(third.join("meta/info.json")).unwrap();
    merge(&parts, &out, &[]).refused(&["part-3", "without meta/info.json"]);
    merge(&[folder.path().join("nowhere")], &out, &[]).refused(&["nowhere", "no such folder"]);
    merge(&[], &out, &[]).refused(&["<PART>"]);
    assert!(!out.exists());
}
