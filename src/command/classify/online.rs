//! A verdict for each taxel in contact as frames come in: from standard input, a data set or a recording.

use std::io::BufRead;
use std::path::Path;
use std::time::{Duration, Instant};

use serde_json::json;
use underbrush_classifier::any_model::{OnlineJudge, OnlineModel};
use underbrush_exchange::live::{LineError, LineParser, Lines, Message};
use underbrush_recording::disk::{Dataset, is_folder, is_recording, read_recording, read_trials};
use underbrush_recording::{Frame, InputError, Recording, SkinLayout, math};
use underbrush_sim::arm::{self, Arm};

use super::{ClassifyOptions, answers};
use crate::input::{self, Reaches};
use crate::{Failure, output};

/// The rate of a stream is that of its first frames, this many intervals.
const FRAMES_FOR_RATE: usize = 50;

/// Prints one line of JSON for each frame.
pub(super) fn run(options: &ClassifyOptions, model: &OnlineModel) -> Result<(), Failure> {
    let mut online = Online { model, categories: model.categories(), latency: Latency::new(), has_warned: false };
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
        let allowed = "frames: a data set, a recording, a folder of recordings or `-`";
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
        online.reach(&options.input, &read_recording(&options.input)?)?;
    }
    if let Some(text) = online.latency.text() {
        output::remark(text);
    }
    Ok(())
}

/// The skin, from a data set, a recording, the file of an arm, or a skin file.
fn layout_of(path: &Path) -> Result<SkinLayout, Failure> {
    input::check_exists(path, "a data set (folder), a recording, the file of an arm or a skin file")?;
    if is_folder(path)? {
        Ok(Dataset::open(path)?.plan().layout.clone())
    } else if path.extension().unwrap_or_default() == "toml" {
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

/// Bins of the histogram in each doubling of time: quantiles are accurate to within 9 %.
const STEPS_PER_DOUBLING: f64 = 8.0;
/// Number of doublings, beginning at one microsecond: 2^40 µs are two weeks.
const DOUBLINGS: usize = 40;

/// A histogram of the times from receiving a frame (a line, or a frame of a file) until its answer is written. Its memory
/// does not grow with the stream.
struct Latency {
    /// Number of answers by the logarithm of their time.
    counts: Vec<u64>,
    max_us: f64,
}

impl Latency {
    /// No answer yet.
    fn new() -> Self {
        Latency { counts: vec![0; DOUBLINGS * STEPS_PER_DOUBLING as usize], max_us: 0.0 }
    }

    /// Counts an answer that took this time.
    fn add(&mut self, time: Duration) {
        let time_us = 1e6 * time.as_secs_f64();
        // Less than a microsecond counts as one.
        let step = (STEPS_PER_DOUBLING * math::log2(time_us.max(1.0))) as usize;
        let last = self.counts.len() - 1;
        self.counts[step.min(last)] += 1;
        self.max_us = self.max_us.max(time_us);
    }

    /// Readable text; `None` without answers.
    fn text(&self) -> Option<String> {
        let answers: u64 = self.counts.iter().sum();
        (answers > 0).then(|| {
            let [median_us, most_us] = [0.5, 0.99].map(|share| self.quantile_us(share, answers));
            let (frames, max_us) = (output::counted(answers, "frame", "frames"), self.max_us);
            format!("{frames} answered: median {median_us:.0} µs, 99 % within {most_us:.0} µs, at most {max_us:.0} µs")
        })
    }

    /// The time within which a fraction of the answers was given: the upper end of its bin.
    fn quantile_us(&self, share: f64, answers: u64) -> f64 {
        let mut left = (share * answers as f64).ceil() as u64;
        for (step, count) in self.counts.iter().enumerate() {
            if *count >= left {
                return math::exp2((step as f64 + 1.0) / STEPS_PER_DOUBLING).min(self.max_us);
            }
            left -= count;
        }
        self.max_us
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests the quantiles of known times: never too small, and at most 9 %, the width of a bin, too large.
    #[test]
    fn quantiles_are_near_the_true_ones() {
        let mut latency = Latency::new();
        assert_eq!(latency.text(), None);
        (1..=10_000).for_each(|time| latency.add(Duration::from_micros(time)));
        for (share, expected) in [(0.5, 5000.0), (0.99, 9900.0), (1.0, 10_000.0), (0.0001, 1.0)] {
            let found = latency.quantile_us(share, 10_000);
            assert!((expected..1.0906 * expected).contains(&found), "{share}: {found}");
        }
        for extreme in [Duration::ZERO, Duration::from_secs(1_000_000_000_000), Duration::MAX] {
            latency.add(extreme);
        }
        assert!(latency.text().unwrap().starts_with("10003 frames answered: median 5"));
    }
}
