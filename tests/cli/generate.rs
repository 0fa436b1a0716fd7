//! `underbrush generate`.

use crate::support::{assert_same_trees, scenes, underbrush};

/// Tests that the same scenes and seed give the same files with one thread and with two, and that another seed does
/// not.
#[test]
fn threads_do_not_change_a_byte() {
    let folder = tempfile::tempdir().unwrap();
    let leaf = scenes::write(folder.path(), "leaf.toml", scenes::FEW_LEAVES);
    let trunk = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let [one, two, other] = ["one", "two", "other"].map(|name| folder.path().join(name));
    for (out, jobs, seed) in [(&one, "1", "1"), (&two, "2", "1"), (&other, "2", "2")] {
        let call = underbrush![
            "generate",
            leaf,
            trunk,
            "--reaches",
            "2",
            "--seed",
            seed,
            "--jobs",
            jobs,
            "--out",
            out,
            "--json"
        ];
        assert_eq!(call.json()["reaches"], 4);
    }
    assert_same_trees(&one, &two);
    let data = "data/chunk-000/file-000.parquet";
    assert_ne!(std::fs::read(one.join(data)).unwrap(), std::fs::read(other.join(data)).unwrap());
}

/// Tests that the largest difference between taxel forces and solver forces in the summary is rounding error, that
/// results go to stdout, and that nothing goes to stderr unless it is a terminal.
#[test]
fn taxel_forces_add_up_to_contact_forces() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::TRUNKS_AT_FOREARM);
    let call = underbrush!["generate", scene, "--reaches", "1", "--out", folder.path().join("set"), "--json"];
    assert_eq!(call.stderr, "");
    let summary = call.json();
    assert!(summary["audit"]["largest_force_residual"]["value"].as_f64().unwrap() < 1e-9, "{summary}");
    assert_eq!(summary["touched_reaches"]["forearm"], 1, "{summary}");
}
