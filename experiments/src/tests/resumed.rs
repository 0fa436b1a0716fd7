use crate::definition::Experiment;
use crate::plan::Plan;

/// Pins that results of another seed or size, and those without a known plan, are refused with the reason; that the
/// same plan continues; and that `--fresh` removes what a run creates, and nothing else.
#[test]
fn only_the_same_plan_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    let experiment = Experiment::paper().unwrap();
    let plan = |seed, quick| Plan::new(&experiment, seed, quick);
    let refused = |plan: Plan| plan.settle(out, false).unwrap_err().to_string();
    plan(3, true).settle(out, false).unwrap();
    plan(3, true).settle(out, false).unwrap();
    assert!(refused(plan(4, true)).contains("seed was 3, now 4"));
    assert!(refused(plan(3, false)).contains("quick was true, now false"));
    std::fs::create_dir(out.join("reaches")).unwrap();
    std::fs::write(out.join("reaches/mixed.json"), "{}").unwrap();
    std::fs::write(out.join("notes.txt"), "mine").unwrap();
    plan(4, true).settle(out, true).unwrap();
    assert!(!out.join("reaches").exists() && out.join("notes.txt").exists());
    plan(4, true).settle(out, false).unwrap();
    std::fs::remove_file(out.join("plan.json")).unwrap();
    plan(4, true).settle(out, false).unwrap();
    std::fs::remove_file(out.join("plan.json")).unwrap();
    std::fs::create_dir(out.join("dataset")).unwrap();
    assert!(refused(plan(4, true)).contains("--fresh"));
}
