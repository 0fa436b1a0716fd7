//! `underbrush check`: runs regression suites and holds what they find against their bounds.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use underbrush_experiments::suite::result::SuiteResult;
use underbrush_experiments::suite::{Suite, bless};
use underbrush_report::junit;

use crate::failure::Failure;
use crate::output;
use crate::progress::Shown;

mod text;

/// Shown at the end of `underbrush check --help`.
const EXAMPLE: &str = "\
A suite is a TOML file. This one runs 24 reaches and bounds two numbers; `{}` is a bound that --bless fills in:

  summary = \"The arm still gets past a leaf, and presses on it as hard as it did\"
  seed = 1
  [[scenes]]
  scene = \"one-leaf.toml\"
  reaches = 24
  [scenes.bounds]
  goals_reached = { at_least = 0.8 }
  mean_force_n.leaf = {}

  underbrush check leaf.toml --bless      Run it and write the bounds
  underbrush check leaf.toml              Run it again: exit status 0 if all bounds hold, 1 if one is broken
  underbrush check leaf.toml --seed 2     Run other draws of the same scenes against the same bounds

docs/suites.md lists keys and metrics and explains the margin. Suites that ship are in suites/.";

/// Options of `underbrush check`.
#[derive(Args)]
#[command(after_help = EXAMPLE)]
pub struct Options {
    /// Suite files, such as suites/leaf.toml
    #[arg(required = true, value_name = "SUITE")]
    suites: Vec<PathBuf>,
    /// Write bounds into the files, from what is found and the margin that the files ask for. Only the bounds change
    #[arg(long, conflicts_with = "seed")]
    bless: bool,
    /// Seed, instead of each file's: other draws of the same scenes
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Write the results to this folder: junit.xml for CI systems, and results.json with the values of all reaches
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// The results of all suites.
#[derive(Serialize)]
struct Report {
    /// Whether all bounds hold.
    passed: bool,
    suites: Vec<SuiteResult>,
}

/// Runs the suites and prints what they find.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    // All files are read before anything is run, so that a mistake in the last one costs no time.
    let suites = options.suites.iter().map(|path| Ok(Suite::load(path)?));
    let mut suites = suites.collect::<Result<Vec<_>, Failure>>()?;
    if let Some(seed) = options.seed {
        suites = suites.into_iter().map(|suite| suite.with_seed(seed)).collect();
    }
    let mut results = Vec::new();
    for (suite, path) in suites.iter().zip(&options.suites) {
        let mut result = suite.run(&Shown)?;
        if options.bless {
            result = blessed(suite, result, path)?;
        }
        results.push(result);
    }
    let report = Report {
        passed: results.iter().all(|result| result.passed),
        suites: results,
    };
    if let Some(folder) = &options.out {
        write(folder, &report)?;
    }
    output::result(json, &report, || text::of(&report.suites))?;
    if report.passed {
        return Ok(());
    }
    let broken: usize = report.suites.iter().map(|result| result.broken().count()).sum();
    let bounds = if broken == 1 { "bound does" } else { "bounds do" };
    Err(Failure::run(format!(
        "{broken} {bounds} not hold; if the change is wanted, write new bounds with --bless"
    )))
}

/// Writes new bounds into the file, and gives the result as held against them.
fn blessed(suite: &Suite, result: SuiteResult, path: &Path) -> Result<SuiteResult, Failure> {
    output::write_file(path, bless::text(suite, &result)?.as_bytes())?;
    let result = Suite::load(path)?.hold(result);
    for scene in &result.scenes {
        for bound in scene.bounds.iter().filter(|bound| bound.allows_everything()) {
            output::remark(format!(
                "warning: {}: {} differs so much between reaches that its bound allows everything; run more reaches, let the \
                 scene vary less, or remove it",
                scene.scene, bound.name
            ));
        }
    }
    Ok(result)
}

fn write(folder: &Path, report: &Report) -> Result<(), Failure> {
    let json = serde_json::to_string_pretty(report).map_err(|error| Failure::run(error.to_string()))?;
    output::write_file(&folder.join("results.json"), json.as_bytes())?;
    let xml = junit::document(&report.suites, text::why);
    output::write_file(&folder.join("junit.xml"), xml.as_bytes())
}
