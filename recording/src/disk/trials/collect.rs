//! Collects rows into trials.

use std::collections::BTreeMap;
use std::path::Path;

use crate::{InputError, Sample, Trial, limits};

/// A row: one sample with the facts about its trial.
pub(super) struct Row {
    /// Line of a CSV file, row of a Parquet file, from 1.
    pub(super) line: usize,
    /// The trial, still without samples.
    pub(super) trial: Trial,
    pub(super) sample: Sample,
}

impl Row {
    fn require_same<T: PartialEq + ToString>(
        &self,
        path: &Path,
        column: &str,
        own: &Option<T>,
        before: &Option<T>,
    ) -> Result<(), InputError> {
        if own == before {
            return Ok(());
        }
        let [found, before] = [own, before].map(|value| value.as_ref().map_or("nothing".to_string(), T::to_string));
        let allowed = format!("{before}, as in earlier rows of trial {}", self.trial.trial);
        let remedy = "give all rows of a trial the same value, or give each value its own trial number";
        Err(InputError::new(path, column, found, allowed, remedy).at_line(self.line))
    }
}

/// Trials in the order of their first rows.
#[derive(Default)]
pub(super) struct Collector {
    pub(super) trials: Vec<Trial>,
    places: BTreeMap<u64, usize>,
    rows: u64,
}

impl Collector {
    /// Adds a row to its trial.
    pub(super) fn push(&mut self, path: &Path, row: Row) -> Result<(), InputError> {
        self.rows += 1;
        limits::TABLE_ROWS.check(path, "rows", self.rows)?;
        let Some(&place) = self.places.get(&row.trial.trial) else {
            self.places.insert(row.trial.trial, self.trials.len());
            self.trials.push(Trial { samples: vec![row.sample], ..row.trial });
            return Ok(());
        };
        let trial = &mut self.trials[place];
        row.require_same(path, "category", &row.trial.category, &trial.category)?;
        row.require_same(path, "reach", &row.trial.reach, &trial.reach)?;
        row.require_same(path, "patch", &row.trial.patch, &trial.patch)?;
        row.require_same(path, "taxel", &row.trial.taxel, &trial.taxel)?;
        let (time_s, before) = (row.sample.time_s, trial.samples.last().map_or(f64::NEG_INFINITY, |last| last.time_s));
        if time_s <= before {
            let allowed = format!("more than {before}, the previous time in trial {}", row.trial.trial);
            let remedy = "sort the rows of each trial by time and delete duplicates";
            return Err(InputError::new(path, "time_s", time_s.to_string(), allowed, remedy).at_line(row.line));
        }
        trial.samples.push(row.sample);
        let samples = limits::TRIAL_SAMPLES.check(path, "samples", trial.samples.len() as u64);
        samples.map_err(|error| error.at_line(row.line))
    }
}
