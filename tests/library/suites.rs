//! The suites that ship, and the page that describes suite files.

use std::path::{Path, PathBuf};

use underbrush_experiments::suite::Suite;
use underbrush_experiments::suite::metric::{METRICS, Sides};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_path_buf()
}

/// Tests that every suite that ships can be read and has no bound without numbers. `.ci/run` runs them.
#[test]
fn shipped_suites_are_blessed() {
    for name in ["leaf", "trunk", "outlier"] {
        let suite = Suite::load(&root().join(format!("suites/{name}.toml"))).unwrap();
        let bounds: Vec<_> = suite.scenes.iter().flat_map(|scene| &scene.bounds).collect();
        assert!(bounds.len() >= 5, "{name}");
        for bound in bounds {
            let numbers = bound.bound;
            assert!(numbers.at_least.is_some() || numbers.at_most.is_some(), "{name}: {}", bound.name());
        }
    }
}

/// Tests that docs/suites.md lists every metric with the sentence of the program, and no other.
#[test]
fn the_page_lists_every_metric() {
    let page = std::fs::read_to_string(root().join("docs/suites.md")).unwrap();
    let rows = page.lines().filter(|line| line.starts_with("| `") && line.matches('|').count() == 6);
    let listed: Vec<String> = rows.map(String::from).collect();
    let expected = METRICS.map(|metric| {
        let name = if metric.by_category { format!("{}.CATEGORY", metric.name) } else { metric.name.into() };
        let statistic = format!("{:?}", metric.statistic).to_lowercase();
        let sides = match metric.sides {
            Sides::Both => "both",
            Sides::AtLeast => "`at_least`",
            Sides::AtMost => "`at_most`",
        };
        let model = if metric.needs_model { "yes" } else { "" };
        format!("| `{name}` | {statistic} | {sides} | {model} | {} |", metric.summary)
    });
    assert_eq!(listed, expected);
}
