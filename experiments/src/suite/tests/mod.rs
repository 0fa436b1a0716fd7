mod metrics;

use std::path::PathBuf;

use super::checked::blessed_text;
use super::result::{BoundVerdict, ReachValue, SceneResult, SuiteResult};
use super::*;
use crate::progress::Silent;

/// A suite with comments, bounds in several forms, and one bound without numbers.
const SUITE: &str = r#"# What we keep an eye on.
summary = "Leaves and a trunk"
seed = 7

[bless]
false_alarm = 0.04 # one in 25

[[scenes]]
scene = "plants.toml"   # both kinds
reaches = 4
[scenes.bounds]
peak_force_n.trunk = {}             # not known yet
goals_reached = { at_least = 0.25 } # the arm still arrives
audit = { at_most = 1.0 }
[scenes.bounds.mean_force_n]
leaf = { at_least = 0.5, at_most = 0.7, blessed = 0.6 } # both sides
trunk = { at_most = 9 }
"#;

const PLANTS: &str = "summary = \"Plants\"\n[[objects.foam_block]]\ncount = 1\n[[objects.leaf]]\ncount = 1\n\
                      [[objects.trunk]]\ncount = 1\n";

/// A suite file and its scene in a folder.
fn written(text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("suite.toml");
    std::fs::write(folder.path().join("plants.toml"), PLANTS).unwrap();
    std::fs::write(&file, text).unwrap();
    (folder, file)
}

/// The result of a suite with one scene, from the values of each bound.
fn result(suite: &Suite, values: &[&[f64]]) -> SuiteResult {
    let scene = &suite.scenes[0];
    let of_bound = |(own, values): (&SceneBound, &&[f64])| {
        let values = values.iter().zip(0..).map(|(value, reach_index)| ReachValue { reach_index, value: *value });
        result::held(own, values.collect())
    };
    let bounds = scene.bounds.iter().zip(values).map(of_bound).collect();
    let mut result = SuiteResult {
        suite: suite.name.clone(),
        summary: suite.file.summary.clone(),
        program_version: String::new(),
        seed: suite.file.seed,
        passed: false,
        scenes: vec![SceneResult {
            scene: "plants".into(),
            file: "plants.toml".into(),
            controller: "cody-2013".into(),
            reaches: scene.reaches,
            goals: Default::default(),
            simulated_s: 0.0,
            bounds,
        }],
    };
    result.passed = result.broken().count() == 0;
    result
}

/// Tests that a suite takes the name of a scene that ships, by which its results name it, too, and that a wrong name is refused
/// with those that there are.
#[test]
fn scenes_that_ship_have_names() {
    let (_folder, file) = written(&SUITE.replace("plants.toml", "mixed"));
    let suite = Suite::load(&file).unwrap();
    let scene = &suite.scenes[0];
    assert_eq!((scene.plan.scene.name.as_str(), scene.name_or_path.as_str()), ("mixed", "mixed"));
    let (_folder, file) = written(&SUITE.replace("plants.toml", "mixt"));
    let error = Suite::load(&file).unwrap_err().to_string();
    assert!(error.contains("found mixt; allowed: leaf, trunk, mixed") && error.contains("names this file"), "{error}");
}

/// Tests that bounds are read in the order of the file, whichever way TOML writes their tables.
#[test]
fn bounds_keep_the_order_of_the_file() {
    let (_folder, file) = written(SUITE);
    let suite = Suite::load(&file).unwrap();
    let names: Vec<String> = suite.scenes[0].bounds.iter().map(SceneBound::name).collect();
    let expected = ["peak_force_n.trunk", "goals_reached", "audit", "mean_force_n.leaf", "mean_force_n.trunk"];
    assert_eq!(names, expected);
    let leaf = suite.scenes[0].bounds[3].bound;
    assert_eq!((leaf.at_least, leaf.at_most, leaf.blessed), (Some(0.5), Some(0.7), Some(0.6)));
    assert_eq!((suite.name.as_str(), suite.file.seed, suite.scenes[0].reaches), ("suite", 7, 4));
}

/// Tests every verdict on a bound, the standard error of a mean, and which reach is to be looked at: the smallest value
/// if the mean is too small, the largest if it is too large.
#[test]
fn values_are_held_against_bounds() {
    let (_folder, file) = written(SUITE);
    let suite = Suite::load(&file).unwrap();
    let found = result(&suite, &[&[5.0, 6.0], &[0.0, 0.25], &[0.5, 1.25], &[0.5, 1.0], &[]]);
    let found = &found.scenes[0].bounds;
    let verdicts: Vec<BoundVerdict> = found.iter().map(|own| own.verdict).collect();
    use BoundVerdict::{NoBound, NotMeasured, TooLarge, TooSmall};
    assert_eq!(verdicts, [NoBound, TooSmall, TooLarge, TooLarge, NotMeasured]);
    // The mean of two values; of the audit the largest.
    assert_eq!(found[1].found, Some(0.125));
    assert_eq!(found[1].standard_error, Some(0.125));
    assert_eq!((found[2].found, found[2].standard_error), (Some(1.25), None));
    let worst = |place: usize| found[place].look_at.map(|own| own.reach_index);
    assert_eq!([worst(1), worst(2), worst(3), worst(4)], [Some(0), Some(1), Some(1), None]);
    let holding = result(&suite, &[&[5.0, 6.0], &[1.0, 1.0], &[0.5, 0.75], &[0.5, 0.75], &[8.0, 9.0]]);
    let verdicts = holding.scenes[0].bounds.iter().map(|own| own.verdict);
    assert_eq!(verdicts.filter(|own| *own == BoundVerdict::Holds).count(), 4);
}

/// Tests that a bound does not hold if the value of a reach is not finite, also of the audit, whose number is the largest of all
/// reaches, and that this reach is to be looked at.
#[test]
fn values_that_are_not_finite_do_not_hold() {
    let (_folder, file) = written(SUITE);
    let suite = Suite::load(&file).unwrap();
    let found = result(&suite, &[&[5.0, 6.0], &[1.0, f64::INFINITY], &[0.5, f64::NAN], &[0.5, f64::NAN], &[8.0, 9.0]]);
    let bounds = &found.scenes[0].bounds;
    let named = |place: usize| (bounds[place].verdict, bounds[place].look_at.map(|own| own.reach_index));
    assert_eq!([1, 2, 3].map(named), [(BoundVerdict::NotFinite, Some(1)); 3]);
    assert!(!found.passed && bounds[2].found.unwrap().is_nan());
}

/// Tests that blessing changes the bounds and nothing else in the file, keeps the sides that a bound has, gives the
/// default sides to a bound without any, and writes bounds that hold, with the margin that the file asks for.
#[test]
fn blessing_changes_the_bounds_alone() {
    let (_folder, file) = written(SUITE);
    let suite = Suite::load(&file).unwrap();
    let values: [&[f64]; 5] = [
        &[5.0, 6.0, 5.0, 6.0],
        &[0.5, 1.0, 0.5, 1.0],
        &[0.25, 0.125, 0.25, 0.125],
        &[1.0, 3.0, 1.0, 3.0],
        &[2.0, 2.0, 2.0, 2.0],
    ];
    let found = result(&suite, &values);
    let text = blessed_text(&suite, &found).unwrap();
    // Means and shares have six sides, of which the new bound on the trunk's peak force has two.
    let margin = statistics::margin(values[3], 0.04 / 6.0).unwrap();
    let before: Vec<&str> = SUITE.lines().collect();
    let after: Vec<&str> = text.lines().collect();
    assert_eq!(before.len(), after.len());
    for (before, after) in before.iter().zip(&after) {
        let comment = |line: &str| line.split_once('#').map(|(_, comment)| comment.to_owned());
        assert_eq!(comment(before), comment(after), "{after}");
        if !before.contains('{') {
            assert_eq!(before, after);
        }
    }
    assert!(text.contains("audit = { at_most = 1, blessed = 0.25 }"), "{text}");
    assert!(text.contains("trunk = { at_most = 2.02, blessed = 2 }"), "{text}");
    std::fs::write(&file, &text).unwrap();
    let blessed = Suite::load(&file).unwrap();
    let bounds: Vec<Bound> = blessed.scenes[0].bounds.iter().map(|own| own.bound).collect();
    assert!(bounds[0].at_least.is_some() && bounds[0].at_most.is_some());
    assert!(bounds[1].at_least.is_some() && bounds[1].at_most.is_none());
    let leaf = bounds[3];
    // Rounded to four digits, away from what was found.
    let high = leaf.at_most.unwrap();
    assert!((0.0..1e-3 * high).contains(&(high - (2.0 + margin))), "{leaf:?}, margin {margin}");
    let again = blessed.hold(found);
    assert!(again.passed, "{again:?}");
    // The same run gives the same text again.
    assert_eq!(blessed_text(&blessed, &again).unwrap(), text);
}

/// Tests that a bound as a dotted key or under a table header is checked as any other but not blessed: the error names
/// its line before anything is run, and the file stays as it is.
#[test]
fn bounds_without_braces_are_not_blessed() {
    let in_braces = "goals_reached = { at_least = 0.25 }";
    for (text, line, name) in [
        (SUITE.replace(in_braces, "goals_reached.at_least = 0.25"), 13, "bounds.goals_reached"),
        (SUITE.replace("trunk = { at_most = 9 }", "trunk.at_most = 9"), 17, "bounds.mean_force_n.trunk"),
        (format!("{SUITE}[scenes.bounds.largest_force_n.leaf]\nat_most = 3\n"), 18, "bounds.largest_force_n.leaf"),
    ] {
        assert_ne!(text, SUITE);
        let (_folder, file) = written(&text);
        let suites = Suite::load_all(std::slice::from_ref(&file)).unwrap();
        let Err(Fault::Input(error)) = Checked::of(suites, None, true, &Silent) else {
            panic!("{name} is not refused");
        };
        assert_eq!((error.line, error.field.as_str()), (Some(line), name), "{error}");
        assert!(error.allowed.contains("in braces"), "{error}");
        assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
    }
}

/// Tests that a file is not replaced by a text that is no suite. Here the text of the bounds moved after it was read.
#[test]
fn a_file_is_not_replaced_by_one_that_cannot_be_read() {
    let (_folder, file) = written(SUITE);
    let mut suite = Suite::load(&file).unwrap();
    let mut found = result(&suite, &[&[5.0, 6.0], &[0.5, 1.0], &[0.25, 0.125], &[1.0, 3.0], &[2.0, 3.0]]);
    suite.scenes[0].bounds[1].span.end -= 3;
    let error = checked::blessed(&suite, &mut found, &file, &Silent).unwrap_err().to_string();
    assert!(error.contains("nothing was written"), "{error}");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), SUITE);
}

/// Tests that a file that was edited while its suite ran is not overwritten.
#[test]
fn an_edited_file_is_not_overwritten() {
    let (_folder, file) = written(SUITE);
    let suite = Suite::load(&file).unwrap();
    let edited = SUITE.replace("seed = 7", "seed = 8");
    std::fs::write(&file, &edited).unwrap();
    let error = checked::write(&[(&suite, &file, SUITE.to_owned())]).unwrap_err().to_string();
    assert!(error.contains("suite.toml") && error.contains("nothing was written"), "{error}");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), edited);
}

/// Tests that a bound from values that differ too much is recognized as allowing everything, and that other bounds are
/// not.
#[test]
fn bounds_that_allow_everything_are_noticed() {
    let (_folder, file) = written(SUITE);
    let suite = Suite::load(&file).unwrap();
    let found = result(&suite, &[&[1.0, 9.0], &[0.0, 1.0, 0.0, 1.0], &[0.25, 0.125], &[1.0, 1.0], &[2.0, 3.0]]);
    std::fs::write(&file, blessed_text(&suite, &found).unwrap()).unwrap();
    let blessed = Suite::load(&file).unwrap().hold(found);
    let bounds = blessed.scenes[0].bounds.iter();
    let everything: Vec<&str> =
        bounds.filter(|bound| bound.allows_everything()).map(|bound| bound.name.as_str()).collect();
    // The lower bounds on the trunk's peak force and on the goals are both 0, but only the force has an upper bound.
    assert_eq!(everything, ["goals_reached"]);
}

/// Tests that a metric that was measured in only one reach is not blessed.
#[test]
fn one_value_is_not_blessed() {
    let (_folder, file) = written(SUITE);
    let suite = Suite::load(&file).unwrap();
    let found = result(&suite, &[&[5.0], &[0.5, 1.0], &[0.25, 0.125], &[1.0, 3.0], &[2.0, 2.0]]);
    let error = blessed_text(&suite, &found).unwrap_err().to_string();
    assert!(error.contains("peak_force_n.trunk was measured in 1 of 4 reaches"), "{error}");
}
