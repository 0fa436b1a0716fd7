//! The command line of underbrush: one file a subcommand, no physics, no statistics.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};

mod command;
mod failure;
mod input;
mod interrupt;
mod output;
mod progress;
mod trial_arguments;

use failure::Failure;

/// A testbed for incidental contact: a compliant arm with tactile skin reaches through simulated foliage, and hidden
/// Markov models learn from its taxels to tell leaf from trunk.
///
/// Start with `underbrush reproduce --quick`, or look at one reach: `underbrush reach scenes/mixed.toml --picture reach.svg`.
/// Results go to stdout, everything else to stderr.
#[derive(Parser)]
#[command(name = "underbrush", version = underbrush_experiments::dataset::PROGRAM_VERSION, max_term_width = 100)]
struct Cli {
    #[command(flatten)]
    shared: Shared,
    #[command(subcommand)]
    command: Command,
}

/// Options of every subcommand.
#[derive(Args, Clone, Copy)]
struct Shared {
    /// Print the result as one JSON object.
    #[arg(long, global = true)]
    json: bool,
    /// Threads to use, at most 1024; all cores if not given. Results do not depend on it.
    #[arg(long, global = true, value_name = "N", value_parser = jobs)]
    jobs: Option<usize>,
}

/// Most threads. Choice: more than any machine has cores that share memory, about 800 today; each thread keeps the
/// reach that it runs in memory, and more threads than cores only cost time.
const MOST_JOBS: usize = 1024;

fn jobs(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(jobs) if (1..=MOST_JOBS).contains(&jobs) => Ok(jobs),
        _ => Err(format!(
            "must be a number from 1 to {MOST_JOBS}: more threads than cores only cost memory, a reach each"
        )),
    }
}

#[derive(Subcommand)]
enum Command {
    /// Make the paper's data, train its models, print its tables beside the published ones
    Reproduce(command::reproduce::Options),
    /// Run one reach through a scene and print how it went
    Reach(command::reach::Options),
    /// Make a data set of many reaches
    Generate(command::generate::Options),
    /// Train one hidden Markov model per category
    Train(command::train::Options),
    /// Say what each trial touched: leaf, trunk, uncertain or outlier
    Classify(command::classify::Options),
    /// Cross-validate models on trials with ground truth
    Evaluate(command::evaluate::Options),
    /// Write the contact trials of a data set as a table, one row a sample
    Trials(command::trials::Options),
    /// Print the log-likelihood of each trial under each model, as CSV
    Score(command::score::Options),
    /// Run the physics checks and print closed form, simulation, residual and tolerance
    Validate(command::validate::Options),
    /// Say what is in a scene, data set, recording, trials table or model, and check it
    Inspect(command::inspect::Options),
    /// Print the JSON Schema of scene, arm or skin files, for editors
    Schema(command::schema::Options),
}

fn main() -> ExitCode {
    // Bad usage ends here with exit status 2.
    let cli = Cli::parse();
    let last_panic = failure::record_panics();
    interrupt::watch();
    let result = catch_unwind(AssertUnwindSafe(|| run(cli))).unwrap_or_else(|_| Err(Failure::panic(last_panic)));
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) if failure.is_closed_pipe() => ExitCode::SUCCESS,
        Err(failure) => {
            output::error(&failure);
            ExitCode::from(failure.status())
        }
    }
}

fn run(cli: Cli) -> Result<(), Failure> {
    if let Some(jobs) = cli.shared.jobs {
        rayon::ThreadPoolBuilder::new()
            .num_threads(jobs)
            .build_global()
            .map_err(|error| Failure::run(format!("cannot start {jobs} threads: {error}")))?;
    }
    let shared = cli.shared;
    match cli.command {
        Command::Reproduce(options) => command::reproduce::run(options, shared.json),
        Command::Reach(options) => command::reach::run(options, shared.json),
        Command::Generate(options) => command::generate::run(options, shared.json),
        Command::Train(options) => command::train::run(options, shared.json),
        Command::Classify(options) => command::classify::run(options, shared.json),
        Command::Evaluate(options) => command::evaluate::run(options, shared.json),
        Command::Trials(options) => command::trials::run(options, shared.json),
        Command::Score(options) => command::score::run(options, shared.json),
        Command::Validate(options) => command::validate::run(options, shared.json),
        Command::Inspect(options) => command::inspect::run(options, shared.json),
        Command::Schema(options) => command::schema::run(&options),
    }
}
