//! `underbrush benchmark`: evaluates a model or a controller on fixed scenes, for a row of a table that others can check.

use std::path::PathBuf;

use clap::Args;
use underbrush_experiments::benchmark::{EnteredController, Entry};
use underbrush_experiments::verdict_controller::VerdictControl;
use underbrush_report::benchmark_text;
use underbrush_sim::controller::ControllerKind;

use super::overwrite::check_results_folder;
use crate::{Failure, Shown, input, interrupt, options, output};

/// Shown at the end of `underbrush benchmark --help`.
const EXAMPLE: &str = "\
Make the training set, train on it, and run the three tracks:

  S=benchmarks/incidental-contact-1/scenes
  underbrush generate $S/leaf.toml $S/trunk.toml $S/mixed.toml --reaches 25 --seed 900000 --out training
  underbrush train training --classifier touch --out touch.json
  underbrush benchmark verdicts --model touch.json
  underbrush benchmark transfer --model touch.json
  underbrush benchmark reaching --controller cody-2013
  underbrush benchmark reaching --controller cody-2013 --verdicts touch.json

Each track has two halves with the same number of reaches: 200 in verdicts, 140 in transfer, 250 in reaching. The reaches of the \
public half are made once and kept for the next model. The seed of the audit half follows from the model's file. An interrupted \
command continues where it stopped. benchmarks/incidental-contact-2.md has the rules.";

/// Options of `underbrush benchmark`.
#[derive(Args)]
#[command(after_help = EXAMPLE)]
pub struct BenchmarkOptions {
    /// What is measured
    #[arg(value_parser = options::named::<String>(&[
        ("verdicts", "Verdicts on objects, by the time since the first contact; some objects are unknown in training"),
        ("transfer", "Verdicts on objects, with another arm, speed or sensor than in training"),
        ("reaching", "How many goals a controller reaches in clutter, and how hard it presses on trunks and leaves"),
    ]))]
    track: String,
    /// Model to evaluate, of any kind; for verdicts and transfer
    #[arg(long, value_name = "MODEL")]
    model: Option<PathBuf>,
    /// Controller to evaluate; for reaching
    #[arg(long, value_name = "NAME", value_parser = input::controller())]
    controller: Option<ControllerKind>,
    /// Give the controller the verdicts of this touch model; for reaching
    #[arg(long, value_name = "MODEL", requires = "controller")]
    verdicts: Option<PathBuf>,
    /// Folder for the reaches and for the rows, as JSON files with versions, seeds and hashes
    #[arg(long, value_name = "DIR", default_value = "out/benchmark")]
    out: PathBuf,
    /// Run only two reaches of each scene, to try the command. The result is not a row of the table
    #[arg(long)]
    quick: bool,
}

/// Measures, writes the row and prints it.
pub fn run(options: BenchmarkOptions, json: bool) -> Result<(), Failure> {
    check_results_folder(&options.out)?;
    let verdicts = options.verdicts.as_deref().map(VerdictControl::named).transpose()?.flatten();
    let controller = options.controller.map(|kind| EnteredController { kind: Some(kind), own: None, verdicts });
    let entry = Entry::new(&options.track, options.model.as_deref(), controller)?;
    interrupt::kept("finished reaches are", &options.out, "the same command");
    let row = entry.run(&options.out, options.quick, &Shown)?;
    output::result(json, &row, || benchmark_text::of(&row))
}
