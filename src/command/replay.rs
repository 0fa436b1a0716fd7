//! `underbrush replay`: shows reaches in the browser, or draws them; and a reach that is shown while it is simulated.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::thread::JoinHandle;

use clap::Args;
use serde_json::json;
use underbrush_classifier::Scores;
use underbrush_recording::disk::with_recordings;
use underbrush_recording::{Fault, Recording};
use underbrush_replay::{Judging, JudgingModel, Live, PartialReach, Server, Source, VerdictLog, single_file, unjudged};
use underbrush_report::replayed::{MAX_PAGE_BYTES, known};
use underbrush_sim::reach::{Observed, ReachPlan, ReachSoFar};

use super::touch::TouchDecisionArguments;
use super::{DecisionArguments, Overwrite, PictureArguments};
use crate::{Failure, input, options, output};

/// Shown at the end of `underbrush replay --help`.
const EXAMPLES: &str = "\
Examples:
  underbrush replay my-set --model model.json     Serve the page until Ctrl-C
  underbrush replay before.parquet after.parquet  Two recordings, which the page can show side by side
  underbrush replay trials.csv --model model.json What a robot felt, as `underbrush import` has written it
  underbrush replay reach.parquet --out reach.html
                                                  One file to send; it opens from disk without a network
  underbrush replay reach.parquet --still reach.png
                                                  A picture of the moment when most of the skin is pressed
  underbrush replay my-set --reaches 3 --video reach.gif --speed 2
                                                  Reach 3 as a film, twice as fast as it was

The server listens on 127.0.0.1 only, cannot change anything, and gives out nothing but the page and these reaches. It \
answers only under the whole address that is printed, which has a random key: do not show it to people who may not see \
the reaches. While a browser is being opened, other users of the machine can see the address; --no-open avoids that.";

/// Options of `underbrush replay`.
#[derive(Args)]
#[command(after_help = EXAMPLES, mut_arg("force", |own| own.requires("file")))]
pub struct ReplayOptions {
    /// Data sets and folders of recordings, recordings and tables of contact trials (.csv or .parquet)
    #[arg(required = true)]
    inputs: Vec<PathBuf>,
    /// Write the page and the reaches to this file (HTML) instead of serving them
    #[arg(long, value_name = "FILE", group = "file", conflicts_with_all = ["port", "no_open"])]
    out: Option<PathBuf>,
    #[command(flatten)]
    overwrite: Overwrite,
    /// With a file to write: the reaches, by their numbers in the list from 0, such as 0,3,7 [default: all]
    #[arg(
        long,
        value_name = "N,…",
        value_delimiter = ',',
        requires = "file",
        conflicts_with_all = ["port", "no_open"],
        value_parser = options::number(|_: &usize| true, "must be whole numbers, 0 or more, with commas between them")
    )]
    reaches: Vec<usize>,
    #[command(flatten, next_help_heading = "Pictures and films")]
    picture: PictureArguments,
    /// Model file of a classifier of trials or a touch model: the page also shows its verdicts
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// With --model: patch of skin that is classified [default: the first; a touch model knows its patch]
    #[arg(long, value_name = "NAME", requires = "model")]
    patch: Option<String>,
    #[command(flatten)]
    server: ServerArguments,
    #[command(flatten)]
    decision: DecisionArguments,
    #[command(flatten, next_help_heading = "Verdicts of touch models")]
    touch: TouchDecisionArguments,
}

/// Where the page is served, and whether a browser is opened.
#[derive(Args)]
pub struct ServerArguments {
    /// Port to listen on; 0 takes a free one
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = options::whole(0..=u16::MAX))]
    pub port: u16,
    /// Do not open the page in a browser
    #[arg(long)]
    no_open: bool,
}

/// Serves the page or writes it.
pub fn run(options: ReplayOptions, json: bool) -> Result<(), Failure> {
    if let Some(out) = &options.out {
        options.overwrite.file(out, options.inputs.iter().chain(&options.model))?;
    }
    for path in &options.inputs {
        input::check_exists(path, "a data set or a folder of recordings, a recording or a table of contact trials")?;
    }
    options.picture.check(options.overwrite, &options.inputs)?;
    let judging = judging(&options)?;
    let source = Source::open(&with_recordings(&options.inputs)?, known(None), judging)?;
    let chosen = source.chosen(&options.reaches);
    if options.picture.run(&source, &chosen, json)? {
        return Ok(());
    }
    match &options.out {
        Some(path) => write(&source, &chosen, path, json),
        None => serve(source, &options.server, json),
    }
}

fn judging(options: &ReplayOptions) -> Result<Option<Judging>, Failure> {
    let Some(path) = &options.model else {
        let given = options::given(&options.decision).into_iter().chain(options::given(&options.touch));
        return options::refuse(given, "is about the verdicts of a --model").map(|()| None);
    };
    let mut judging = Judging::load(path, options.patch.as_deref())?;
    match &mut judging.by {
        JudgingModel::OfTrials(model, own) => {
            options.touch.refuse_for_trials()?;
            own.decision = options.decision.decision(&Scores::of_model(model))?;
        }
        JudgingModel::Touch(model) => {
            options.decision.refuse_for_touch_model(None)?;
            let model = Arc::make_mut(model);
            model.decision = options.touch.over(model.decision);
        }
    }
    Ok(Some(judging))
}

fn write(source: &Source, chosen: &[usize], path: &Path, json: bool) -> Result<(), Failure> {
    let page = single_file(source, chosen, MAX_PAGE_BYTES)?;
    output::write_file(path, page.as_bytes())?;
    let (reaches, bytes, path) = (chosen.len(), page.len(), path.display().to_string());
    output::result(json, &json!({ "file": path, "reaches": reaches, "bytes": bytes }), || {
        let megabytes = bytes as f64 / 1e6;
        format!("{path}: {} in {megabytes:.1} MB", output::counted(reaches, "reach", "reaches"))
    })
}

fn serve(source: Source, arguments: &ServerArguments, json: bool) -> Result<(), Failure> {
    let served = source.reaches.len();
    let server = Server::start(source, arguments.port)?;
    let address = server.address.clone();
    output::result(json, &json!({ "address": address, "reaches": served }), || {
        format!("{} at {address} until Ctrl-C", output::counted(served, "reach", "reaches"))
    })?;
    arguments.show(&address);
    server.run();
    Ok(())
}

impl ServerArguments {
    /// Opens an address in the browser, unless told not to, if standard output is a terminal, and so not in a script or a test.
    ///
    /// Other users can see the address with its key among the arguments of the browser. Machines that many people share
    /// rarely have a display, and without one no browser is started.
    pub fn show(&self, address: &str) {
        let displays = ["DISPLAY", "WAYLAND_DISPLAY"];
        let display = !cfg!(target_os = "linux") || displays.iter().any(|name| std::env::var_os(name).is_some());
        if self.no_open || !display || !std::io::stdout().is_terminal() {
            return;
        }
        let program = match std::env::consts::OS {
            "macos" => "open",
            "windows" => "explorer",
            _ => "xdg-open",
        };
        let quiet =
            Command::new(program).arg(address).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        // If there is no browser, no error is shown, because the address was printed.
        if let Ok(mut child) = quiet {
            let _ = std::thread::Builder::new().spawn(move || child.wait());
        }
    }
}

/// What messages call the reach.
const REACH: &str = "this reach";

/// A reach that is shown in the browser while it is simulated, and the server that shows it.
pub struct Watched<'a> {
    so_far: ReachSoFar<'a>,
    verdicts: Option<VerdictLog>,
    /// Why there are no more verdicts.
    fault: Option<Fault>,
    live: Arc<Live>,
    server: JoinHandle<()>,
}

impl<'a> Watched<'a> {
    /// Starts the server and says where the page is. With a model the page shows its verdicts.
    pub fn begin(
        plan: &'a ReachPlan,
        index: u64,
        judging: Option<&Judging>,
        arguments: &ServerArguments,
    ) -> Result<Self, Failure> {
        let verdicts = judging.map(|judging| judging.begin(&plan.arm.skin.layout)).transpose();
        let verdicts = verdicts.map_err(unjudged(REACH))?;
        let live = Arc::new(Live::default());
        let limit_n = plan.controller.preset().map(|preset| preset.force_limit_n);
        let server = Server::watch(Arc::clone(&live), known(limit_n), arguments.port)?;
        let address = server.address.clone();
        output::remark(format!("the reach begins when {address} is opened in a browser"));
        arguments.show(&address);
        let server = std::thread::Builder::new().spawn(move || server.run());
        let server = server.map_err(|error| Failure::run(format!("cannot start threads: {error}")))?;
        Ok(Watched { so_far: ReachSoFar::new(plan, index), verdicts, fault: None, live, server })
    }

    /// Shows one more frame. Waits while the reach is paused.
    pub fn frame(&mut self, observed: Observed) {
        self.so_far.observe(observed);
        if let Some(Err(source)) = self.verdicts.as_mut().map(|verdicts| verdicts.update(observed.frame)) {
            self.verdicts = None;
            self.fault = Some(unjudged(REACH)(source));
        }
        self.live.frame(|| self.so_far.recording().map(|recording| self.with_verdicts(recording)));
    }

    fn with_verdicts(&self, recording: Recording) -> PartialReach {
        PartialReach { recording, verdicts: self.verdicts.as_ref().map(|log| log.verdicts.clone()) }
    }

    /// Shows the whole reach until the program is ended.
    pub fn end(self, recording: Recording) -> Result<(), Failure> {
        self.live.end(self.with_verdicts(recording));
        if let Some(fault) = self.fault {
            return Err(fault.into());
        }
        output::remark("the page can be used until Ctrl-C");
        self.server.join().map_err(|_| Failure::run("the server of the page has failed; please report this"))
    }
}
