//! Results of regression suites as JUnit XML, which CI systems show test by test.

use std::fmt::Write as _;

use underbrush_experiments::suite::result::{BoundResult, BoundVerdict, SceneResult, SuiteResult};

use crate::drawing::escape;

/// The results as one document: a `testsuite` for each scene and a `testcase` for each of its bounds. `failure` is the
/// text of a broken bound. There are no times, so that the same results give the same bytes.
pub fn document(
    results: &[SuiteResult],
    failure: impl Fn(&SuiteResult, &SceneResult, &BoundResult) -> String,
) -> String {
    let scenes = results.iter().flat_map(|result| &result.scenes);
    let tests: usize = scenes.map(|scene| scene.bounds.len()).sum();
    let failures: usize = results.iter().map(|result| result.broken().count()).sum();
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let _ = writeln!(text, "<testsuites name=\"underbrush check\" tests=\"{tests}\" failures=\"{failures}\">");
    for result in results {
        for scene in &result.scenes {
            let class = escape(&format!("{}.{}", result.suite, scene.scene));
            let broken = scene.bounds.iter().filter(|bound| bound.verdict != BoundVerdict::Holds).count();
            let tests = scene.bounds.len();
            let _ = writeln!(text, "  <testsuite name=\"{class}\" tests=\"{tests}\" failures=\"{broken}\">");
            for bound in &scene.bounds {
                let name = escape(&bound.name);
                if bound.verdict == BoundVerdict::Holds {
                    let _ = writeln!(text, "    <testcase classname=\"{class}\" name=\"{name}\"/>");
                    continue;
                }
                let why = failure(result, scene, bound);
                let message = escape(why.lines().next().unwrap_or_default());
                let _ = writeln!(text, "    <testcase classname=\"{class}\" name=\"{name}\">");
                let _ = writeln!(text, "      <failure message=\"{message}\">{}</failure>", lines(&why));
                text.push_str("    </testcase>\n");
            }
            text.push_str("  </testsuite>\n");
        }
    }
    text.push_str("</testsuites>\n");
    text
}

/// Escaped text with its line breaks.
fn lines(text: &str) -> String {
    text.lines().map(escape).collect::<Vec<_>>().join("\n")
}
