//! `underbrush replay`: what can be tested without a browser.

use super::touch;
use crate::support::fixture::fixture;
use crate::support::underbrush;

/// Tests that the chosen reaches of a data set are written with verdicts to one file, and that the size of this file is
/// reported.
#[test]
fn reaches_are_written_as_one_file() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    let written = underbrush![
        "replay",
        fixture().dataset(),
        "--model",
        fixture().model(),
        "--reaches",
        "0,4",
        "--out",
        page,
        "--json"
    ]
    .json();
    let text = std::fs::read_to_string(&page).unwrap();
    assert_eq!(written["reaches"], 2);
    assert_eq!(written["bytes"], text.len());
    for (id, count) in [("underbrush-reach-0\"", 1), ("underbrush-reach-1\"", 1), ("underbrush-reach-2\"", 0)] {
        assert_eq!(text.matches(&format!("id=\"{id}>")).count(), count, "{id}");
    }
}

/// Tests that options that do not fit together, missing files, files of another kind and numbers outside the list are
/// refused with the reason, and that nothing is written.
#[test]
fn bad_usage_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.html");
    let set = fixture().dataset();
    underbrush!["replay", "no-such-set", "--out", page].refused(&["no-such-set", "check the path"]);
    underbrush!["replay", fixture().trunk_scene(), "--out", page].refused(&["Parquet"]);
    underbrush!["replay", set, "--reaches", "17", "--out", page].refused(&["no reach 17", "below 6"]);
    underbrush!["replay", set, "--margin", "3", "--out", page].refused(&["--margin", "--model"]);
    underbrush!["replay", set, "--model", fixture().model(), "--patch", "hand", "--out", page]
        .refused(&["hand", "forearm"]);
    underbrush!["replay", set, "--reaches", "0"].refused(&["--out"]);
    underbrush!["replay", set, "--reaches", "0", "--no-open"].refused(&["--reaches", "--no-open"]);
    underbrush!["replay", set, "--reaches", "0", "--port", "0"].refused(&["--reaches", "--port"]);
    assert!(!page.exists());
}

/// Tests that a touch model's verdicts are written into the page, that its own options change them, and that options
/// which one of the two kinds of model would ignore are refused.
#[test]
fn touch_models_judge_too() {
    let folder = tempfile::tempdir().unwrap();
    let set = fixture().dataset();
    let page = |name: &str| folder.path().join(name);
    let (first, second, refused) = (page("first.html"), page("second.html"), page("refused.html"));
    let touch = touch::model();
    underbrush!["replay", set, "--reaches", "0", "--model", touch, "--out", first].success();
    underbrush!["replay", set, "--reaches", "0", "--model", touch, "--unknown-share", "1", "--out", second].success();
    let [first, second] = [first, second].map(|page| std::fs::read_to_string(page).unwrap());
    assert!(first != second, "the option changed no verdict");
    for (model, option, value, said) in [
        (touch.clone(), "--margin", "3", "--margin"),
        (touch.clone(), "--patch", "flipper", "patch flipper"),
        (fixture().model(), "--nothing-above", "0.5", "--nothing-above"),
    ] {
        underbrush!["replay", set, "--model", model, option, value, "--out", refused].refused(&[said]);
    }
    underbrush!["replay", set, "--unknown-share", "0.5", "--out", refused].refused(&["--unknown-share", "--model"]);
    assert!(!refused.exists());
}
