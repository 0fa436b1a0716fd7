//! `--limit-wrong` with the classifier `touch`.

use super::{TRAINED, read};
use crate::support::fixture::fixture;
use crate::support::underbrush;

/// Tests that limits of risk choose the decision that is stored, that a limit is refused if it is no share or too small for the
/// number of reaches, and that limits are refused where they would be ignored or contradict another option.
#[test]
fn limits_of_risk_choose_the_decision() {
    let folder = tempfile::tempdir().unwrap();
    let model = folder.path().join("touch.json");
    let data = fixture().dataset();
    let train =
        |limit: &str| underbrush!["train", data, "--classifier", "touch", "--limit-wrong", limit, "--out", model];
    train("1").refused(&["--limit-wrong", "must be a share above 0 and below 1"]);
    train("0.05").refused(&["6 reaches cannot show that at most 0.05", "19 reaches or more"]);
    assert!(!model.exists());
    // Three of the six reaches are in each fold.
    let folds = underbrush!["evaluate", data, "--classifier", "touch", "--limit-wrong", "0.2"];
    folds.refused(&[
        "3 reaches cannot show that at most 0.2",
        "4 reaches or more to fit to (cross-validation leaves a fold out)",
    ]);
    train("0.2").success();
    let decision = &read(&model)["decision"];
    let usual = &read(&TRAINED.0)["decision"];
    assert_ne!(decision["cost_of_uncertain"], usual["cost_of_uncertain"]);
    assert_eq!(decision["unknown_share"], usual["unknown_share"]);
    let refused = [
        underbrush!["train", data, "--limit-wrong", "0.2", "--out", model, "--force"],
        underbrush!["evaluate", data, "--limit-wrong", "0.2"],
        underbrush!["evaluate", data, "--model", model, "--limit-wrong", "0.2"],
        underbrush!["evaluate", data, "--classifier", "touch", "--limit-wrong", "0.2", "--cost-of-uncertain", "0.1"],
    ];
    for call in refused {
        call.refused(&["--limit-", "leave"]);
    }
}
