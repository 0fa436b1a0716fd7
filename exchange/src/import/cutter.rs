//! Cuts frames of forces into trials: one for each period during which the force of a taxel stays above the threshold.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use underbrush_recording::{Category, InputError, Sample, Trial, limits};

use super::Mapping;

/// The facts about a frame that decide which trial its forces belong to.
pub(super) struct Place<'a> {
    /// Line of a CSV file, row of a table or number of a message, from 1.
    pub(super) line: usize,
    /// The reach. Its frames must be adjacent.
    pub(super) reach: u64,
    /// The category; empty if it is unknown.
    pub(super) category: &'a str,
    /// Time of the frame, s.
    pub(super) time_s: f64,
}

/// Takes frames one after another and cuts them into trials.
pub(super) struct Cutter<'a> {
    path: PathBuf,
    mapping: &'a Mapping,
    /// The trial of the current contact of each taxel; `None` without contact.
    open: Vec<Option<Trial>>,
    done: Vec<Trial>,
    reach: Option<u64>,
    /// The current reach and those before it.
    begun: BTreeSet<u64>,
    /// Number of readings in each frame of the reach; `None` before its first frame.
    taxels: Option<usize>,
    category: Option<String>,
    before_s: f64,
    pub(super) frames: usize,
    pub(super) reaches: usize,
}

impl<'a> Cutter<'a> {
    /// A cutter for the frames of a file.
    pub(super) fn new(path: &Path, mapping: &'a Mapping) -> Self {
        Cutter {
            path: path.to_path_buf(),
            mapping,
            open: Vec::new(),
            done: Vec::new(),
            reach: None,
            begun: BTreeSet::new(),
            taxels: None,
            category: None,
            before_s: f64::NEG_INFINITY,
            frames: 0,
            reaches: 0,
        }
    }

    fn error(&self, line: usize, field: &str, found: f64, allowed: String, remedy: &str) -> InputError {
        InputError::new(&self.path, field, limits::short(found), allowed, remedy).at_line(line)
    }

    /// Adds a frame with the reading of each taxel, in the file's unit.
    pub(super) fn push(&mut self, place: &Place, readings: &[f64]) -> Result<(), InputError> {
        if self.reach != Some(place.reach) {
            if !self.begun.insert(place.reach) {
                let found = format!("{}, a reach that ended before", place.reach);
                let allowed = "all rows of a reach one after another";
                let error = InputError::new(&self.path, "reach", found, allowed, "sort the rows by reach");
                return Err(error.at_line(place.line));
            }
            self.end_contacts();
            self.reach = Some(place.reach);
            self.reaches += 1;
            self.taxels = None;
            self.before_s = f64::NEG_INFINITY;
        }
        let category = Some(place.category).filter(|category| !category.is_empty());
        if self.category.as_deref() != category {
            if let Some((name, allowed)) = category.and_then(|name| Some((name, Category::name_fault(name)?))) {
                let found = format!("{name:?}");
                let error = InputError::new(&self.path, "category", found, allowed, "give the category another name");
                return Err(error.at_line(place.line));
            }
            self.end_contacts();
            self.category = category.map(str::to_owned);
        }
        let Place { line, time_s, .. } = *place;
        if !limits::TIME_S.hold(time_s) {
            let remedy = "correct the time, or `time.unit` of the mapping";
            return Err(self.error(line, "time", time_s, limits::TIME_S.to_string(), remedy));
        }
        if time_s <= self.before_s {
            let allowed = format!("more than {}, the time before it", limits::short(self.before_s));
            let remedy = "sort the frames by time, or name the column of the reach as `reach_from` of the mapping";
            return Err(self.error(line, "time", time_s, allowed, remedy));
        }
        self.before_s = time_s;
        if readings.len() > limits::MAX_TAXELS {
            let allowed = format!("at most {}", limits::MAX_TAXELS);
            let remedy = "name one patch of skin in `from` of the mapping";
            return Err(self.error(line, "number of taxels", readings.len() as f64, allowed, remedy));
        }
        let taxels = *self.taxels.get_or_insert(readings.len());
        if readings.len() != taxels {
            let allowed = format!("{taxels}, as in the first frame of the reach");
            let remedy = "record all taxels in each frame, or choose another `from` in the mapping";
            return Err(self.error(line, "number of taxels", readings.len() as f64, allowed, remedy));
        }
        self.open.resize(readings.len().max(self.open.len()), None);
        for (taxel, reading) in readings.iter().enumerate() {
            let force_n = self.mapping.force_n(*reading);
            if !limits::FORCE_N.hold(force_n) {
                let remedy = "correct the reading, or the unit, `scale_n` or `offset_n` of the mapping";
                let field = format!("force of taxel {taxel}");
                return Err(self.error(line, &field, force_n, limits::FORCE_N.to_string(), remedy));
            }
            let samples = self.sample(taxel, time_s, force_n);
            let within = limits::TRIAL_SAMPLES.check(&self.path, "samples", samples as u64);
            within.map_err(|error| error.at_line(line))?;
        }
        self.frames += 1;
        Ok(())
    }

    /// Adds a sample of a taxel, and returns how many its contact has now.
    fn sample(&mut self, taxel: usize, time_s: f64, force_n: f64) -> usize {
        if force_n <= self.mapping.threshold_n {
            let ended = self.open[taxel].take();
            self.keep(ended);
            return 0;
        }
        let trial = self.open[taxel].get_or_insert_with(|| Trial {
            trial: 0,
            category: self.category.clone(),
            reach: self.reach,
            patch: self.mapping.trial.patch.clone(),
            taxel: Some(taxel as u32),
            samples: Vec::new(),
        });
        trial.samples.push(Sample { time_s, force_n, motion_m: None, region: None, touched: None });
        trial.samples.len()
    }

    fn keep(&mut self, trial: Option<Trial>) {
        let long_enough = |trial: &Trial| trial.samples.len() >= self.mapping.min_samples;
        self.done.extend(trial.filter(long_enough));
    }

    fn end_contacts(&mut self) {
        for taxel in 0..self.open.len() {
            let ended = self.open[taxel].take();
            self.keep(ended);
        }
    }

    /// The trials by reach, first sample and taxel, numbered in this order.
    pub(super) fn finish(&mut self) -> Vec<Trial> {
        self.end_contacts();
        let mut trials = std::mem::take(&mut self.done);
        let first_s = |trial: &Trial| trial.samples.first().map_or(0.0, |sample| sample.time_s);
        trials.sort_by(|a, b| {
            let by_time = first_s(a).total_cmp(&first_s(b));
            a.reach.cmp(&b.reach).then(by_time).then(a.taxel.cmp(&b.taxel))
        });
        (0..).zip(&mut trials).for_each(|(number, trial)| trial.trial = number);
        trials
    }
}
