//! Cuts frames of forces into trials: one for each contact of a taxel, or one for what all taxels feel in a reach.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use underbrush_recording::{Category, InputError, Region, Sample, Trial, limits};

use super::Mapping;
use super::mapping::Cut;

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
    path: &'a Path,
    mapping: &'a Mapping,
    /// The trial of the current contact of each taxel, or of all taxels together; `None` without contact.
    open: Vec<Option<Trial>>,
    /// The force on each taxel in this frame, N.
    forces_n: Vec<f64>,
    /// Whether each taxel is in contact in this frame.
    in_contact: Vec<bool>,
    /// Whether each taxel was without contact in the frame before.
    is_interrupted: Vec<bool>,
    /// With one trial for a reach: number of its samples up to the last contact.
    until_last_contact: usize,
    done: Vec<Trial>,
    reach: Option<u64>,
    /// The current reach and those before it.
    pub(super) begun: BTreeSet<u64>,
    category: Option<String>,
    before_s: f64,
    pub(super) frames: usize,
}

/// The region of some taxels.
fn region(forces_n: &[f64], taxels: &[usize]) -> Region {
    let forces = || taxels.iter().map(|taxel| forces_n[*taxel].max(0.0));
    Region {
        taxels: u32::try_from(taxels.len()).unwrap_or(u32::MAX),
        largest_force_n: forces().fold(0.0, f64::max),
        force_sum_n: forces().sum(),
    }
}

impl<'a> Cutter<'a> {
    /// A cutter for the frames of a file.
    pub(super) fn new(path: &'a Path, mapping: &'a Mapping) -> Self {
        let taxels = mapping.taxels();
        Cutter {
            path,
            mapping,
            open: vec![None; taxels],
            forces_n: vec![0.0; taxels],
            in_contact: vec![false; taxels],
            is_interrupted: vec![false; taxels],
            until_last_contact: 0,
            done: Vec::new(),
            reach: None,
            begun: BTreeSet::new(),
            category: None,
            before_s: f64::NEG_INFINITY,
            frames: 0,
        }
    }

    fn error(&self, line: usize, field: &str, found: String, allowed: impl Into<String>, remedy: &str) -> InputError {
        InputError::new(self.path, field, found, allowed, remedy).at_line(line)
    }

    /// Adds a frame with the reading of each taxel of the mapping, in the file's unit, and the numbers of each channel: one
    /// for each taxel or one for all.
    pub(super) fn push(
        &mut self,
        place: &Place,
        readings: &[f64],
        channels: &[Vec<Option<f64>>],
    ) -> Result<(), InputError> {
        let Place { line, reach, category, time_s } = *place;
        if self.reach != Some(reach) {
            if !self.begun.insert(reach) {
                let found = format!("{reach}, a reach that ended before");
                let allowed = "all rows of a reach one after another";
                return Err(self.error(line, "reach", found, allowed, "sort the rows by reach"));
            }
            self.end_contacts();
            self.reach = Some(reach);
            self.before_s = f64::NEG_INFINITY;
        }
        let category = Some(category).filter(|category| !category.is_empty());
        if self.category.as_deref() != category {
            if let Some((name, allowed)) = category.and_then(|name| Some((name, Category::name_fault(name)?))) {
                let remedy = "give the category another name";
                return Err(self.error(line, "category", format!("{name:?}"), allowed, remedy));
            }
            self.end_contacts();
            self.category = category.map(str::to_owned);
        }
        if !limits::TIME_S.hold(time_s) {
            let remedy = "correct the time, or `time.unit` of the mapping";
            return Err(self.error(line, "time", limits::short(time_s), limits::TIME_S.to_string(), remedy));
        }
        if time_s <= self.before_s {
            let allowed = format!("more than {}, the time before it", limits::short(self.before_s));
            let remedy = "sort the frames by time and delete those that are there twice, or name the column of the reach as `reach_from` \
                          of the mapping";
            return Err(self.error(line, "time", limits::short(time_s), allowed, remedy));
        }
        self.before_s = time_s;
        for (taxel, reading) in readings.iter().enumerate() {
            let force_n = self.mapping.force_n(*reading);
            if !limits::FORCE_N.hold(force_n) {
                let remedy = "correct the reading, or the unit, `scale_n` or `offset_n` of the mapping";
                let field = format!("force of taxel {taxel}");
                return Err(self.error(line, &field, limits::short(force_n), limits::FORCE_N.to_string(), remedy));
            }
            self.forces_n[taxel] = force_n;
            let level_n = if self.in_contact[taxel] { self.mapping.release_n } else { self.mapping.threshold_n };
            self.in_contact[taxel] = force_n > level_n;
        }
        let samples = match self.mapping.file.trial.cut {
            Cut::Contact => self.sample_taxels(time_s, channels),
            Cut::Reach => self.sample_all(time_s, channels),
        };
        let within = limits::TRIAL_SAMPLES.check(self.path, "samples", samples as u64);
        within.map_err(|error| error.at_line(line))?;
        self.frames += 1;
        Ok(())
    }

    /// Adds a sample of each taxel in contact, and returns how many the longest contact has now.
    fn sample_taxels(&mut self, time_s: f64, channels: &[Vec<Option<f64>>]) -> usize {
        let mut regions: Vec<Option<Region>> = vec![None; self.forces_n.len()];
        if let Some(grid) = self.mapping.grid {
            for taxels in grid.regions(|taxel| self.in_contact[taxel]) {
                let region = region(&self.forces_n, &taxels);
                for taxel in taxels {
                    regions[taxel] = Some(region);
                }
            }
        }
        // Room for rounding of differences of times. Times that count from 1970 are rounded by 1e-7 s, and once more if they are
        // in whole nanoseconds.
        let gap_s = self.mapping.gap_s + f64::max(1e-9, 4.0 * f64::EPSILON * time_s.abs());
        let over = |trial: &mut Trial| trial.samples.last().is_some_and(|last| time_s - last.time_s > gap_s);
        let mut longest = 0;
        for (taxel, region) in regions.into_iter().enumerate() {
            let is_in_contact = self.in_contact[taxel];
            // A contact goes on without interruption, however far apart the frames are.
            if !is_in_contact || self.is_interrupted[taxel] {
                let ended = self.open[taxel].take_if(over);
                self.keep(ended);
            }
            self.is_interrupted[taxel] = !is_in_contact;
            if is_in_contact {
                let sample = self.sample(time_s, taxel, region, channels);
                longest = longest.max(self.add(taxel, Some(taxel as u32), sample));
            }
        }
        longest
    }

    /// Adds a sample of all taxels together from the first contact on, and returns how many there are now. Without contact,
    /// its region is the strongest taxel.
    fn sample_all(&mut self, time_s: f64, channels: &[Vec<Option<f64>>]) -> usize {
        let strongest = (0..self.forces_n.len())
            .fold(0, |best, taxel| if self.forces_n[taxel] > self.forces_n[best] { taxel } else { best });
        let mut taxels: Vec<usize> = (0..self.forces_n.len()).filter(|taxel| self.in_contact[*taxel]).collect();
        let is_contact = !taxels.is_empty();
        if !is_contact {
            if self.open[0].is_none() {
                return 0;
            }
            taxels.push(strongest);
        }
        let region = Some(region(&self.forces_n, &taxels));
        let sample = self.sample(time_s, strongest, region, channels);
        let samples = self.add(0, None, sample);
        if is_contact {
            self.until_last_contact = samples;
        }
        samples
    }

    /// What a taxel feels and its channels.
    fn sample(&self, time_s: f64, taxel: usize, region: Option<Region>, channels: &[Vec<Option<f64>>]) -> Sample {
        let numbers = channels.iter().map(|numbers| *numbers.get(taxel).or(numbers.first())?);
        let named = self.mapping.file.channel.iter().zip(numbers);
        let channels = named.filter_map(|(own, number)| Some((Arc::clone(&own.name), number?))).collect();
        Sample { time_s, force_n: self.forces_n[taxel], region, channels, ..Sample::default() }
    }

    /// Adds a sample to an open trial or a new one, and returns how many it has now.
    fn add(&mut self, index: usize, taxel: Option<u32>, sample: Sample) -> usize {
        let trial = self.open[index].get_or_insert_with(|| Trial {
            trial: 0,
            category: self.category.clone(),
            reach: self.reach,
            patch: self.mapping.file.trial.patch.clone(),
            taxel,
            samples: Vec::new(),
        });
        trial.samples.push(sample);
        trial.samples.len()
    }

    fn keep(&mut self, mut trial: Option<Trial>) {
        if let Some(trial) = trial.as_mut().filter(|_| self.mapping.file.trial.cut == Cut::Reach) {
            trial.samples.truncate(self.until_last_contact);
        }
        let long_enough = |trial: &Trial| trial.samples.len() >= self.mapping.min_samples;
        self.done.extend(trial.filter(long_enough));
    }

    fn end_contacts(&mut self) {
        for taxel in 0..self.open.len() {
            let ended = self.open[taxel].take();
            self.keep(ended);
        }
        self.in_contact.fill(false);
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
