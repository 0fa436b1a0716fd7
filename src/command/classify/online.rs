//! A verdict for each taxel in contact as frames come in: from standard input, a data set or a recording.

use std::collections::BTreeMap;
use std::io::BufRead;
use std::path::Path;
use std::time::Instant;

use serde::Serialize;
use serde_json::json;
use underbrush_classifier::Model;
use underbrush_classifier::feature::MOTION;
use underbrush_classifier::online::{OnlineClassifier, OnlineOptions};
use underbrush_recording::disk::{Dataset, is_recording, read_recording};
use underbrush_recording::{Frame, InputError, SkinLayout};
use underbrush_sim::arm::{self, Arm};

use super::super::decision_arguments::Scores;
use super::Options;
use super::json::LineError;
use super::latency::Latency;
use super::line::{LineParser, Message};
use super::lines::Lines;
use crate::failure::Failure;
use crate::{input, output};

#[derive(Serialize)]
struct FrameVerdicts<'a> {
    time_s: f64,
    taxels: Vec<TaxelLine<'a>>,
}

#[derive(Serialize)]
struct TaxelLine<'a> {
    taxel: usize,
    samples: usize,
    verdict: &'a str,
    scores: BTreeMap<&'a str, f64>,
}

/// Prints one line of JSON for each frame.
pub fn run(options: &Options, model: Model) -> Result<(), Failure> {
    let mut online = Online::new(options, model)?;
    if options.reads_stdin() {
        let layout = match &options.skin {
            Some(path) => layout_of(path)?,
            None => Arm::cody()?.skin.layout,
        };
        online.stream(std::io::stdin().lock(), &layout, options.strict)?;
    } else if options.input.is_dir() {
        let dataset = Dataset::open(&options.input)?;
        for episode in 0..dataset.episodes().len() {
            let recording = dataset.read_reach(episode)?;
            online.reach(&recording.layout, &recording.frames)?;
        }
    } else {
        let allowed = "with --online, frames: a data set, a recording or `-`";
        input::check_exists(&options.input, allowed)?;
        if options.input.extension().is_some_and(|extension| extension == "csv") {
            let found = "a table of trials";
            return Err(InputError::new(&options.input, "input", found, allowed, "leave --online out").into());
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
    input::check_exists(
        path,
        "a data set (folder), a recording, the file of an arm or a skin file",
    )?;
    let extension = path.extension().unwrap_or_default();
    if path.is_dir() {
        Ok(Dataset::open(path)?.layout().clone())
    } else if extension == "toml" {
        Ok(arm::load_layout(path)?)
    } else if is_recording(path) {
        Ok(read_recording(path)?.layout)
    } else {
        let allowed = "a data set (folder), a recording (.parquet), the file of an arm or a skin file (.toml)";
        Err(InputError::new(path, "--skin", "another kind of file", allowed, "name one of these").into())
    }
}

/// What stays the same from reach to reach.
struct Online {
    model: Model,
    categories: Vec<String>,
    settings: OnlineOptions,
    latency: Latency,
}

impl Online {
    fn new(options: &Options, model: Model) -> Result<Self, Failure> {
        options.cut.refuse_online()?;
        let decision = options.decision.decision(&Scores::of_model(&model))?;
        Ok(Online {
            categories: model.classifier.categories(),
            settings: OnlineOptions {
                patch: options.cut.patch(),
                threshold_n: options.cut.threshold_n(),
                decision,
            },
            model,
            latency: Latency::new(),
        })
    }

    fn start(&self, layout: &SkinLayout) -> Result<OnlineClassifier, Failure> {
        Ok(OnlineClassifier::new(
            self.model.classifier.as_ref(),
            layout,
            &self.settings,
        )?)
    }

    /// Answers the frames of a whole reach.
    fn reach(&mut self, layout: &SkinLayout, frames: &[Frame]) -> Result<(), Failure> {
        let mut classifier = self.start(layout)?;
        frames
            .iter()
            .try_for_each(|frame| self.answer(&mut classifier, frame, Instant::now()))
    }

    /// Answers each line before the next is read. A bad line is answered with its error and otherwise ignored; with
    /// `strict` it ends the stream.
    fn stream(&mut self, reader: impl BufRead, layout: &SkinLayout, strict: bool) -> Result<(), Failure> {
        let mut classifier = self.start(layout)?;
        let patch = layout.chosen_patch(self.settings.patch.as_deref());
        let uses_motion = self.model.classifier.features().contains(&MOTION);
        let mut parser = LineParser::new(layout.clone(), patch.filter(|_| uses_motion));
        let mut lines = Lines::new(reader, parser.max_bytes());
        let mut bad_lines = 0_u64;
        loop {
            let line = lines.next();
            let line = line.map_err(|error| Failure::run(format!("cannot read standard input: {error}")))?;
            let arrived = Instant::now();
            let Some((number, text)) = line else { break };
            match text.and_then(|text| parser.parse(number, text)) {
                Ok(Message::Frame(frame)) => self.answer(&mut classifier, &frame, arrived)?,
                Ok(Message::Reset) => {
                    classifier = self.start(layout)?;
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
            output::remark(format!(
                "warning: {bad_lines} bad lines; their answers say what is wrong"
            ));
        }
        Ok(())
    }

    fn answer(&mut self, classifier: &mut OnlineClassifier, frame: &Frame, since: Instant) -> Result<(), Failure> {
        let categories = &self.categories;
        let taxels = classifier.update(frame)?.map(|taxel| TaxelLine {
            taxel: taxel.taxel,
            samples: taxel.samples,
            verdict: taxel.verdict.name(),
            scores: categories
                .iter()
                .map(String::as_str)
                .zip(taxel.scores.iter().copied())
                .collect(),
        });
        let line = serde_json::to_string(&FrameVerdicts {
            time_s: frame.time_s,
            taxels: taxels.collect(),
        });
        output::lines([line.map_err(|error| Failure::run(error.to_string()))?])?;
        self.latency.add(since);
        Ok(())
    }
}

/// The error that ends a strict stream.
fn refused(number: usize, error: LineError) -> Failure {
    let remedy = "correct the line, or leave --strict out";
    let LineError { field, found, allowed } = error;
    InputError::new("<stdin>", field, found, allowed, remedy)
        .at_line(number)
        .into()
}
