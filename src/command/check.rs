//! `underbrush check`: runs regression suites and checks what they find against their bounds.

use std::path::PathBuf;

use clap::Args;
use underbrush_experiments::suite::{Checked, Suite};
use underbrush_report::suite_text;

use super::overwrite::check_results_folder;
use crate::options::whole;
use crate::{Failure, Overwrite, Shown, output};

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
#[command(after_help = EXAMPLE, mut_arg("force", |own| own.requires("out")))]
pub struct CheckOptions {
    /// Suite files, such as suites/leaf.toml
    #[arg(required = true, value_name = "SUITE")]
    suites: Vec<PathBuf>,
    /// Write bounds into the files, from what is found and the margin that the files ask for. Only the bounds change
    #[arg(long, conflicts_with = "seed")]
    bless: bool,
    /// Seed, instead of each file's: other draws of the same scenes
    #[arg(long, value_name = "N", value_parser = whole(0..=u64::MAX))]
    seed: Option<u64>,
    /// Write the results to this folder: junit.xml for CI systems, and results.json with the values of all reaches
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
}

/// Runs the suites and prints what they find.
pub fn run(options: CheckOptions, json: bool) -> Result<(), Failure> {
    options.out.as_deref().map_or(Ok(()), check_results_folder)?;
    let suites = Suite::load_all(&options.suites)?;
    for file in options.out.iter().flat_map(|folder| suite_text::FILES.map(|name| folder.join(name))) {
        options.overwrite.file(&file, &options.suites)?;
    }
    let checked = Checked::of(suites, options.seed, options.bless, &Shown)?;
    if let Some(folder) = &options.out {
        suite_text::write(folder, &checked)?;
    }
    output::result(json, &checked, || suite_text::of(&checked.suites))?;
    if checked.passed {
        return Ok(());
    }
    let broken = checked.suites.iter().flat_map(|suite| suite.broken()).count();
    let broken = output::counted(broken, "bound does", "bounds do");
    Err(Failure::run(format!("{broken} not hold; if the change is wanted, write new bounds with --bless")))
}
