//! Results of suites as readable text, and as files for other programs.

use std::path::Path;

use underbrush_experiments::files;
use underbrush_experiments::suite::Checked;
use underbrush_experiments::suite::result::{BoundResult, BoundVerdict, SceneResult, SuiteResult};
use underbrush_recording::{Fault, math};

use crate::{Rows, counted, escape, joined};

/// Names of the files that [`write()`] writes.
pub const FILES: [&str; 2] = ["results.json", "junit.xml"];

/// Writes `junit.xml` for CI systems, and `results.json` with the values of all reaches.
///
/// # Errors
/// If a file cannot be written.
pub fn write(folder: &Path, checked: &Checked) -> Result<(), Fault> {
    let [results, junit] = FILES.map(|name| folder.join(name));
    files::write_json(&results, checked)?;
    files::write(&junit, junit_xml(&checked.suites).as_bytes())
}

/// A table for each scene, and each broken bound with the reach to look at.
pub fn of(results: &[SuiteResult]) -> String {
    joined(results.iter().map(of_suite), "\n")
}

fn of_suite(result: &SuiteResult) -> String {
    let mut text = format!("{}: {}\n", result.suite, result.summary);
    for scene in &result.scenes {
        let SceneResult { scene: name, simulated_s, controller, goals, .. } = scene;
        let (reaches, seed) = (counted(scene.reaches, "reach", "reaches"), result.seed);
        text += &format!("\n{name} ({reaches} of seed {seed}, {simulated_s:.0} s simulated, {controller}): {goals}\n");
        text += &Rows::of(&scene.bounds)
            .column("metric", |bound| bound.name.as_str())
            .column("found", |bound| shown(bound.found))
            .column("± SE", |bound| shown(bound.standard_error))
            .column("reaches", |bound| bound.values.len())
            .column("at least", |bound| shown(bound.allowed.at_least))
            .column("at most", |bound| shown(bound.allowed.at_most))
            .column("blessed", |bound| shown(bound.allowed.blessed))
            .column("", |bound| match bound.verdict {
                BoundVerdict::Holds => "holds",
                BoundVerdict::TooSmall => "TOO SMALL",
                BoundVerdict::TooLarge => "TOO LARGE",
                BoundVerdict::NotMeasured => "NOT MEASURED",
                BoundVerdict::NotFinite => "NOT FINITE",
                BoundVerdict::NoBound => "NO BOUND",
            })
            .text();
    }
    let bounds: usize = result.scenes.iter().map(|scene| scene.bounds.len()).sum();
    let (unbounded, broken): (Vec<_>, Vec<_>) =
        result.broken().partition(|(_, bound)| bound.verdict == BoundVerdict::NoBound);
    for (scene, bound) in broken {
        text += &format!("\n{}", why(result, scene, bound));
    }
    if !unbounded.is_empty() {
        text += &format!("\nmetrics without a bound: {}; --bless writes bounds for them\n", unbounded.len());
    }
    let held = bounds - result.broken().count();
    text + &format!("\n{}: {held} of {bounds} bounds hold\n", result.suite)
}

/// Why a bound is broken, and how to look at the reach that contributes most.
fn why(result: &SuiteResult, scene: &SceneResult, bound: &BoundResult) -> String {
    let found = shown(bound.found);
    let what = match bound.verdict {
        BoundVerdict::TooSmall => format!("is {found}, less than at_least = {}", shown(bound.allowed.at_least)),
        BoundVerdict::TooLarge => format!("is {found}, more than at_most = {}", shown(bound.allowed.at_most)),
        BoundVerdict::NotMeasured => "could not be measured in any reach".into(),
        BoundVerdict::NotFinite => format!("is {found}, which is not finite"),
        BoundVerdict::NoBound => format!("is {found} and has no bound yet; write one with --bless"),
        BoundVerdict::Holds => "holds".into(),
    };
    let mut text = format!("{}: {} {what}\n", scene.scene, bound.name);
    if let Some(worst) = bound.look_at {
        let (index, value, file) = (worst.reach_index, number(worst.value), shell_word(&scene.file));
        let (seed, controller) = (result.seed, &scene.controller);
        text += &format!(
            "  look at reach {index}, where it is {value}:\n  underbrush reach {file} --seed {seed} --index {index} --controller \
             {controller} --picture reach.png\n"
        );
    }
    text
}

/// A path as one word of a shell command.
pub fn shell_word(path: &str) -> String {
    let plain = |character: char| character.is_alphanumeric() || "/._-+".contains(character);
    if path.chars().all(plain) { path.to_owned() } else { format!("'{}'", path.replace('\'', "'\\''")) }
}

/// A number that may be missing.
fn shown(value: Option<f64>) -> String {
    value.map_or("-".into(), number)
}

/// A number with four significant digits.
fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let magnitude = math::log10(value.abs()).floor();
    if !(-4.0..6.0).contains(&magnitude) {
        return format!("{value:.3e}");
    }
    let digits = (3.0 - magnitude).max(0.0) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// The results as JUnit XML, which CI systems show test by test: a `testsuite` for each scene and a `testcase` for each of
/// its bounds. There are no times, so that the same results give the same bytes.
fn junit_xml(results: &[SuiteResult]) -> String {
    let scenes = || results.iter().flat_map(|result| result.scenes.iter().map(move |scene| (result, scene)));
    let tests: usize = scenes().map(|(_, scene)| scene.bounds.len()).sum();
    let failures: usize = results.iter().map(|result| result.broken().count()).sum();
    let suites: String = scenes().map(|(result, scene)| junit_suite(result, scene)).collect();
    format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"underbrush check\" tests=\"{tests}\" \
         failures=\"{failures}\">\n{suites}</testsuites>\n"
    )
}

/// The `testsuite` of a scene.
fn junit_suite(result: &SuiteResult, scene: &SceneResult) -> String {
    let class = escape(&format!("{}.{}", result.suite, scene.scene));
    let case = |bound: &BoundResult| {
        let case = format!("    <testcase classname=\"{class}\" name=\"{}\"", escape(&bound.name));
        if bound.verdict == BoundVerdict::Holds {
            return case + "/>\n";
        }
        let why = why(result, scene, bound);
        let message = escape(why.lines().next().unwrap_or_default());
        let lines = joined(why.lines().map(escape), "\n");
        format!("{case}>\n      <failure message=\"{message}\">{lines}</failure>\n    </testcase>\n")
    };
    let cases: String = scene.bounds.iter().map(case).collect();
    let broken = scene.bounds.iter().filter(|bound| bound.verdict != BoundVerdict::Holds).count();
    let tests = scene.bounds.len();
    format!("  <testsuite name=\"{class}\" tests=\"{tests}\" failures=\"{broken}\">\n{cases}  </testsuite>\n")
}
