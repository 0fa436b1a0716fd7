//! The command line of underbrush, as a library: the program and the Python package run it. Each subcommand is one file;
//! physics and statistics are in the libraries.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

use std::error::Error as _;
use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind};

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

mod command;
mod failure;
mod input;
mod interrupt;
mod options;
mod output;
mod progress;

use command::Overwrite;
use failure::Failure;
use progress::Shown;

/// Shown after the list of commands: what to try first, and what a script has to know.
const FIRST_STEPS: &str = "\
First steps:
  underbrush reach mixed --picture reach.png                Simulate one reach and draw it
  underbrush reproduce --quick                              The paper's experiments, small

From data to a classifier:
  underbrush generate leaf trunk --reaches 10 --out my-set
  underbrush evaluate my-set                                Cross-validated accuracy
  underbrush train my-set --out model.json
  underbrush reach mixed --out reach.parquet
  underbrush classify model.json reach.parquet --online     Verdicts after every frame

`underbrush COMMAND --help` explains a command. Results go to standard output, progress and errors to standard error. \
With --json a command that fails prints {\"error\": {\"kind\", \"file\", \"line\", \"field\", \"found\", \"allowed\", \"remedy\", \
\"message\"}} to standard output, too. Exit status: 0 success, 1 the run failed or \
a result says that something is wrong, 2 bad usage or input.";

/// Simulates a compliant robot arm with tactile skin that reaches through foliage, and trains classifiers that tell
/// from the skin's forces what each taxel touches: leaf or trunk.
#[derive(Parser)]
#[command(
    name = "underbrush",
    version = underbrush_experiments::dataset::PROGRAM_VERSION,
    max_term_width = 100,
    after_help = FIRST_STEPS
)]
struct Cli {
    /// Print the result as one JSON object
    #[arg(long, global = true)]
    json: bool,
    /// Number of threads, at most 1024 [default: all cores]. Results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = options::number(|jobs: &usize| (1..=1024).contains(jobs), JOBS))]
    jobs: Option<usize>,
    #[command(subcommand)]
    command: Command,
}

/// The numbers of threads that are allowed. Choice: more than any machine has cores, about 800 today. Threads beyond the number of
/// cores do not help, and each holds a reach in memory.
const JOBS: &str = "must be a number from 1 to 1024; more threads than cores do not help, and each takes memory";

/// Makes the enum of the commands, each with its help, the module that runs it, and its options.
macro_rules! commands {
    ($($(#[$help:meta])* $name:ident($module:ident::$options:ident),)*) => {
        #[derive(Subcommand)]
        enum Command {
            $($(#[$help])* $name(command::$module::$options),)*
        }

        impl Command {
            fn run(self, json: bool) -> Result<(), Failure> {
                match self {
                    $(Command::$name(options) => command::$module::run(options, json),)*
                }
            }
        }
    };
}
commands! {
    /// Repeat the paper's experiments, and write a report that shows the results beside the published ones
    Reproduce(reproduce::ReproduceOptions),
    /// Simulate one reach through a scene
    Reach(reach::ReachOptions),
    /// Write the files of your own arm from its URDF, and cover its links with taxels
    Arm(arm::ArmOptions),
    /// Write one random draw of a scene as a scene file that lists every object, so that you can edit it
    Arrange(arrange::ArrangeOptions),
    /// Simulate many reaches and write them as a data set
    Generate(generate::GenerateOptions),
    /// Join the parts that `generate --shard` made on several machines into one data set
    Merge(merge::MergeOptions),
    /// Fit a classifier to trials, or to whole frames, and save it as a model file
    Train(train::TrainOptions),
    /// Classify contact trials, or the contacts in every frame, with a model
    Classify(classify::ClassifyOptions),
    /// Cross-validate classifiers, or evaluate a model, on data with ground truth
    Evaluate(evaluate::EvaluateOptions),
    /// Write the contact trials of a data set as a table with one row per sample
    Trials(trials::TrialsOptions),
    /// Print the log-likelihood of each trial under each model, as CSV
    Score(score::ScoreOptions),
    /// Check the simulated physics against closed-form solutions
    Validate(validate::ValidateOptions),
    /// Run regression suites: check the results of scenes, controller and model against the bounds in a file
    Check(check::CheckOptions),
    /// Evaluate a model or a controller on fixed scenes and seeds, so that others can check the result
    Benchmark(benchmark::BenchmarkOptions),
    /// Check a scene, data set, recording, table of trials or model, and show what is in it
    Inspect(inspect::InspectOptions),
    /// Show reaches in the browser: the arm in 3-D, its skin, plots and verdicts over time. Or draw pictures and films
    Replay(replay::ReplayOptions),
    /// Write reaches for other tools (MCAP, ROS 2, HDF5). Without the Python package, print the Python command that
    /// does so
    Export(export::ExportOptions),
    /// Cut contact trials from a CSV file of a real robot, or make recordings of its reaches
    Import(import::ImportOptions),
    /// Fit stiffness, hardening and loss of a skin to a press test
    FitSkin(fit_skin::FitSkinOptions),
    /// Print the JSON Schema of scene, arm, skin, experiment, suite, mapping or model files, for use in an editor
    Schema(schema::SchemaOptions),
    /// Print a shell's completion script, or write manual pages
    Completions(completions::CompletionsOptions),
}

/// Runs the command line with these arguments, the first of which is the program's name. Returns the exit status: 0
/// success, 1 the run failed, 2 bad usage or input.
///
/// ```
/// assert_eq!(underbrush::run_command_line(["underbrush", "inspect", "mixed"].map(Into::into)), 0);
/// ```
pub fn run_command_line(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let matches = taking_negative_numbers(Cli::command()).try_get_matches_from(&arguments);
    let cli = match matches.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => cli,
        Err(answer) => return output::usage(&answer, &arguments),
    };
    let json = cli.json;
    underbrush_experiments::show_warnings(output::remark);
    let last_panic = failure::record_panics();
    interrupt::watch();
    let result = catch_unwind(AssertUnwindSafe(|| run(cli))).unwrap_or_else(|_| Err(Failure::panic(last_panic)));
    output::status(result, json)
}

/// A command whose options take negative numbers, so that the error is about the number and not about an unexpected argument.
fn taking_negative_numbers(command: clap::Command) -> clap::Command {
    let taking = |arg: clap::Arg| match arg.get_action().takes_values() {
        true => arg.allow_negative_numbers(true),
        false => arg,
    };
    command.mut_args(taking).mut_subcommands(taking_negative_numbers)
}

fn run(cli: Cli) -> Result<(), Failure> {
    // Rayon would start the threads when they are first needed, and panic if it cannot.
    let started = rayon::ThreadPoolBuilder::new().num_threads(cli.jobs.unwrap_or(0)).build_global();
    // Without --jobs, the threads of an earlier command of the process do as well. That error has no source.
    if let Err(error) = started
        && (cli.jobs.is_some() || error.source().is_some())
    {
        return Err(Failure::run(format!("cannot start threads: {error}")));
    }
    cli.command.run(cli.json)
}
