use crate::plan;

#[test]
fn only_the_same_plan_goes_on() {
    // Pins: results of another seed, of another size and of no known plan are refused by name; the same plan goes on;
    // --fresh removes what reproduce makes, and nothing else.
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    let refused = |plan: plan::Plan| plan.settle(out, false).unwrap_err().to_string();
    plan::Plan::new(3, true).settle(out, false).unwrap();
    plan::Plan::new(3, true).settle(out, false).unwrap();
    assert!(refused(plan::Plan::new(4, true)).contains("seed was 3, now 4"));
    assert!(refused(plan::Plan::new(3, false)).contains("quick was true, now false"));
    std::fs::create_dir(out.join("reaches")).unwrap();
    std::fs::write(out.join("reaches/mixed.json"), "{}").unwrap();
    std::fs::write(out.join("notes.txt"), "mine").unwrap();
    plan::Plan::new(4, true).settle(out, true).unwrap();
    assert!(!out.join("reaches").exists() && out.join("notes.txt").exists());
    plan::Plan::new(4, true).settle(out, false).unwrap();
    std::fs::remove_file(out.join("plan.json")).unwrap();
    plan::Plan::new(4, true).settle(out, false).unwrap();
    std::fs::remove_file(out.join("plan.json")).unwrap();
    std::fs::create_dir(out.join("dataset")).unwrap();
    assert!(refused(plan::Plan::new(4, true)).contains("--fresh"));
}
