use crate::definition::Experiment;
use crate::run_folder::Plan;

/// Tests that results of another seed or size are refused with the reason; that the same plan continues; and that
/// `--force` removes what a run creates, and nothing else, but not while that run is at work.
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
    let other_size = refused(plan(3, false));
    assert!(other_size.contains("quick was true, now false") && other_size.contains("--force"));
    std::fs::create_dir(out.join("reaches")).unwrap();
    std::fs::write(out.join("reaches/mixed.json"), "{}").unwrap();
    std::fs::write(out.join("notes.txt"), "mine").unwrap();
    let at_work = plan(3, true).settle(out, false).unwrap();
    assert!(plan(4, true).settle(out, true).unwrap_err().to_string().contains("at work in this folder"));
    drop(at_work);
    plan(4, true).settle(out, true).unwrap();
    assert!(!out.join("reaches").exists() && out.join("notes.txt").exists());
    plan(4, true).settle(out, false).unwrap();
    std::fs::remove_file(out.join("plan.json")).unwrap();
    plan(4, true).settle(out, false).unwrap();
}

/// Tests that files under the names of results are refused and kept, even with `--force`, if no plan says that a run
/// made them, and that the message does not advise `--force`.
#[test]
fn files_that_no_run_made_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    let files = ["model.json", "report/notes.md", "dataset/precious"];
    for name in files {
        std::fs::create_dir_all(out.join(name).parent().unwrap()).unwrap();
        std::fs::write(out.join(name), "mine").unwrap();
    }
    let plan = Plan::new(&Experiment::paper().unwrap(), 3, true);
    let refused = |found: &str| {
        for force in [false, true] {
            let error = plan.settle(out, force).unwrap_err().to_string();
            assert!(error.contains(found) && error.contains("--out"), "{error}");
            assert!(!error.contains("--force"), "{error}");
        }
        for name in files {
            assert_eq!(std::fs::read_to_string(out.join(name)).unwrap(), "mine", "{name}");
        }
    };
    refused("no plan.json");
    std::fs::write(out.join("plan.json"), "{\"buy\": \"milk\"}").unwrap();
    refused("a plan.json that is not the plan of a run");
    std::fs::remove_file(out.join("plan.json")).unwrap();
    for folder in ["dataset", "report"] {
        std::fs::remove_dir_all(out.join(folder)).unwrap();
    }
    std::fs::remove_file(out.join("model.json")).unwrap();
    plan.settle(out, true).unwrap();
    assert!(out.join("plan.json").exists());
}
