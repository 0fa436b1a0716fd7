//! A verdict for each taxel in contact as frames come in: from standard input, a data set or a recording.

use std::io::BufRead;
use std::path::Path;
use std::time::Instant;

use serde_json::json;
use underbrush_classifier::online_model::{OnlineJudge, OnlineModel};
use underbrush_exchange::live::{LineError, LineParser, Lines, Message};
use underbrush_recording::disk::{Dataset, is_folder, is_recording, read_recording, read_trials};
use underbrush_recording::{Frame, InputError, SkinLayout};
use underbrush_sim::arm::{self, Arm};

use super::latency::Latency;
use super::{ClassifyOptions, of_contacts, of_frames};
use crate::{Failure, input, output};

/// The rate of a stream is that of its first frames, this many intervals.
const FRAMES_FOR_RATE: usize = 50;

/// Prints one line of JSON for each frame.
pub(super) fn run(options: &ClassifyOptions, model: &OnlineModel) -> Result<(), Failure> {
    let mut online = Online { model, categories: model.categories(), latency: Latency::new() };
    if options.reads_stdin() {
        let layout = match &options.skin {
            Some(path) => layout_of(path)?,
            None => Arm::cody()?.skin.layout,
        };
        online.stream(std::io::stdin().lock(), &layout, options.strict)?;
    } else if is_folder(&options.input)? {
        let dataset = Dataset::open(&options.input)?;
        for episode in 0..dataset.episodes().len() {
            if episode > 0 {
                output::lines([json!({ "reach": episode, "reset": true }).to_string()])?;
            }
            let recording = dataset.read_reach(episode)?;
            online.reach(&recording.layout, &recording.frames)?;
        }
    } else {
        let allowed = "frames: a data set, a recording or `-`";
        input::check_exists(&options.input, allowed)?;
        // A damaged table is left to the reader of recordings, which says what is wrong with the file.
        let is_csv = options.input.extension().is_some_and(|extension| extension == "csv");
        if is_csv || (!is_recording(&options.input)? && read_trials(&options.input).is_ok()) {
            let found = "a table of trials";
            let remedy = if options.online {
                "leave --online out"
            } else {
                "give the data set or recording that the trials were taken from"
            };
            return Err(InputError::new(&options.input, "input", found, allowed, remedy).into());
        }
        let recording = read_recording(&options.input)?;
        online.reach(&recording.layout, &recording.frames)?;
    }
    if let Some(text) = online.latency.text() {
        output::remark(text);
    }
    Ok(())
}

/// The skin, from a data set, a recording, the file of an arm, or a skin file.
fn layout_of(path: &Path) -> Result<SkinLayout, Failure> {
    input::check_exists(path, "a data set (folder), a recording, the file of an arm or a skin file")?;
    let extension = path.extension().unwrap_or_default();
    if is_folder(path)? {
        Ok(Dataset::open(path)?.layout().clone())
    } else if extension == "toml" {
        Ok(arm::load_layout(path)?)
    } else if is_recording(path)? {
        Ok(read_recording(path)?.layout)
    } else {
        let allowed = "a data set (folder), a recording (.parquet), the file of an arm or a skin file (.toml)";
        Err(InputError::new(path, "--skin", "another kind of file", allowed, "name one of these").into())
    }
}

/// What is kept from reach to reach.
struct Online<'a> {
    model: &'a OnlineModel,
    categories: Vec<String>,
    latency: Latency,
}

impl Online<'_> {
    /// Answers the frames of a whole reach.
    fn reach(&mut self, layout: &SkinLayout, frames: &[Frame]) -> Result<(), Failure> {
        let mut judge = self.model.begin(layout)?;
        frames.iter().try_for_each(|frame| self.answer(&mut judge, layout, frame, Instant::now()))
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
                    output::lines([json!({ "line": number, "reset": true }).to_string()])?;
                }
                Err(error) => {
                    output::lines([json!({ "line": number, "error": error }).to_string()])?;
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
            OnlineJudge::OfTrials(classifier) => of_contacts::answer(classifier, &self.categories, frame)?,
            OnlineJudge::Touch(classifier) => of_frames::answer(classifier, layout, frame)?,
        };
        output::lines([line])?;
        self.latency.add(since.elapsed());
        Ok(())
    }
}

/// The error that ends a strict stream.
fn refused(number: usize, error: LineError) -> Failure {
    let remedy = "correct the line, or leave --strict out";
    let LineError { field, found, allowed } = error;
    InputError::new("<stdin>", field, found, allowed, remedy).at_line(number).into()
}
