//! A verdict for each taxel in contact as frames come in: from standard input, a data set or a recording.

use std::io::BufRead;
use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::json;
use underbrush_classifier::any_model::{OnlineJudge, OnlineModel};
use underbrush_exchange::live::{LineError, LineParser, Lines, Message};
use underbrush_recording::disk::{Dataset, is_folder, read_recording};
use underbrush_recording::{Frame, InputError, Recording, SkinLayout};
use underbrush_sim::arm::{self, Arm};

use super::{ClassifyOptions, answers};
use crate::input::{self, Reaches};
use crate::{Failure, output};

/// The rate of a stream is that of its first frames, this many intervals.
const FRAMES_FOR_RATE: usize = 50;

/// Prints one line of JSON for each frame.
pub(super) fn run(options: &ClassifyOptions, model: &OnlineModel) -> Result<(), Failure> {
    let mut online = Online { model, categories: model.categories(), latency: Latency::default(), has_warned: false };
    if options.input == Path::new("-") {
        let layout = match &options.skin {
            Some(path) => layout_of(path)?,
            None => Arm::cody()?.skin.layout,
        };
        online.stream(std::io::stdin().lock(), &layout, options.strict)?;
    } else if is_folder(&options.input)? {
        for (reach, recording) in Reaches::open(std::slice::from_ref(&options.input))?.recordings().enumerate() {
            if reach > 0 {
                output::line(&json!({ "reach": reach, "reset": true }).to_string())?;
            }
            online.reach(&options.input, &recording?)?;
        }
    } else {
        input::check_exists(&options.input, "frames: a data set, a recording, a folder of recordings or `-`")?;
        online.reach(&options.input, &read_recording(&options.input)?)?;
    }
    if let Some(text) = online.latency.text() {
        output::remark(text);
    }
    Ok(())
}

/// The skin, from a data set, a recording, the file of an arm, or a skin file.
fn layout_of(path: &Path) -> Result<SkinLayout, Failure> {
    if is_folder(path)? {
        Ok(Dataset::open(path)?.plan().layout.clone())
    } else if path.extension().unwrap_or_default() == "toml" {
        Ok(arm::load_layout(path)?)
    } else {
        Ok(read_recording(path)?.layout)
    }
}

/// What is kept from reach to reach.
struct Online<'a> {
    model: &'a OnlineModel,
    categories: Vec<String>,
    latency: Latency,
    /// Whether another rate has been warned of.
    has_warned: bool,
}

impl Online<'_> {
    /// Answers the frames of a whole reach, which was read from this path.
    fn reach(&mut self, path: &Path, recording: &Recording) -> Result<(), Failure> {
        let warns = || self.model.provenance().warn_of_rate(path.display(), Some(recording.rate_hz));
        self.has_warned = self.has_warned || warns();
        let layout = &recording.layout;
        let mut judge = self.model.begin(layout).map_err(|error| Failure::from(error).about(path))?;
        recording.frames.iter().try_for_each(|frame| self.answer(&mut judge, layout, frame, Instant::now()))
    }

    /// Answers each line before the next is read. A bad line is answered with its error and otherwise ignored; with
    /// `strict` it ends the stream.
    fn stream(&mut self, reader: impl BufRead, layout: &SkinLayout, strict: bool) -> Result<(), Failure> {
        let mut judge = self.model.begin(layout)?;
        let mut parser = LineParser::new(layout.clone(), self.model.needs_poses_of(layout));
        let mut lines = Lines::new(reader, parser.max_bytes());
        let mut bad_lines = 0_usize;
        let (mut frames, mut start_s) = (0_usize, 0.0);
        loop {
            let line = lines.next_line();
            let line = line.map_err(|error| Failure::run(format!("cannot read standard input: {error}")))?;
            let arrived = Instant::now();
            let Some((number, text)) = line else { break };
            match text.and_then(|text| parser.parse(number, text)) {
                Ok(Message::Frame(frame)) => {
                    self.answer(&mut judge, layout, &frame, arrived)?;
                    start_s = if frames == 0 { frame.time_s } else { start_s };
                    if frames == FRAMES_FOR_RATE {
                        let rate_hz = FRAMES_FOR_RATE as f64 / (frame.time_s - start_s);
                        self.model.provenance().warn_of_rate("standard input", Some(rate_hz));
                    }
                    frames += 1;
                }
                Ok(Message::Reset) => {
                    frames = if frames > FRAMES_FOR_RATE { frames } else { 0 };
                    judge = self.model.begin(layout)?;
                    output::line(&json!({ "line": number, "reset": true }).to_string())?;
                }
                Err(error) => {
                    output::line(&json!({ "line": number, "error": error }).to_string())?;
                    if strict {
                        return Err(refused(number, error));
                    }
                    bad_lines += 1;
                }
            }
        }
        if bad_lines > 0 {
            let bad_lines = output::counted(bad_lines, "bad line", "bad lines");
            output::remark(format!("warning: {bad_lines}; the answers say what is wrong"));
        }
        Ok(())
    }

    /// Answers a frame with one line of JSON.
    fn answer(
        &mut self,
        judge: &mut OnlineJudge,
        layout: &SkinLayout,
        frame: &Frame,
        since: Instant,
    ) -> Result<(), Failure> {
        let line = match judge {
            OnlineJudge::OfTrials(classifier) => answers::of_contacts(classifier, &self.categories, frame)?,
            OnlineJudge::Touch(classifier) => answers::of_touch(classifier, layout, frame)?,
        };
        output::line(&line)?;
        self.latency.add(since.elapsed());
        Ok(())
    }
}

/// The error that ends a strict stream.
fn refused(number: usize, error: LineError) -> Failure {
    let LineError { field, found, allowed } = error;
    InputError::new("<stdin>", field, found, allowed, "correct the line, or leave --strict out").at_line(number).into()
}

/// The times from receiving a frame (a line, or a frame of a file) until its answer is written.
#[derive(Default)]
struct Latency {
    answers: u64,
    sum_us: f64,
    max_us: f64,
}

impl Latency {
    /// Counts an answer that took this time.
    fn add(&mut self, time: Duration) {
        let time_us = 1e6 * time.as_secs_f64();
        self.answers += 1;
        self.sum_us += time_us;
        self.max_us = self.max_us.max(time_us);
    }

    /// Readable text; `None` without answers.
    fn text(&self) -> Option<String> {
        let Latency { answers, sum_us, max_us } = *self;
        let (frames, mean_us) = (output::counted(answers, "frame", "frames"), sum_us / answers as f64);
        (answers > 0).then(|| format!("{frames} answered: {mean_us:.0} µs on average, at most {max_us:.0} µs"))
    }
}
