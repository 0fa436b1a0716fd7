//! The rows of a table of trials: converts what the cells of a file hold to the types that columns need, and collects
//! rows into trials.

use std::collections::BTreeMap;
use std::path::Path;

use super::COLUMNS;
use crate::limits::{self, Limits, short};
use crate::{Category, Channels, InputError, PLAIN, Region, Sample, Trial, is_plain};

/// A double holds every whole number up to this one.
const LARGEST_EXACT: f64 = 9_007_199_254_740_992.0;

/// The whole number that a text holds. `3.0` is allowed, because pandas converts integer columns with gaps to floating point.
pub fn whole_number(text: &str) -> Option<i128> {
    let text = text.trim();
    text.parse().ok().or_else(|| text.parse().ok().and_then(whole))
}

fn whole(number: f64) -> Option<i128> {
    (number.abs() <= LARGEST_EXACT && number.fract() == 0.0).then_some(number as i128)
}

/// The content of a cell.
#[derive(Clone, Copy, Debug)]
pub(super) enum Cell<'a> {
    Missing,
    Whole(i128),
    Number(f64),
    Flag(bool),
    Text(&'a str),
}

/// The cells of one row, in the order of [`COLUMNS`], with their place in the file.
pub(super) struct Cells<'a> {
    /// The file.
    pub(super) path: &'a Path,
    /// Line of a CSV file, row of a Parquet file, from 1.
    pub(super) line: usize,
    /// The cells.
    pub(super) cells: [Cell<'a>; COLUMNS.len()],
    /// What the other columns hold.
    pub(super) channels: Channels,
}

impl Cell<'_> {
    fn number(self) -> Option<f64> {
        match self {
            Cell::Missing | Cell::Flag(_) => None,
            Cell::Whole(number) => Some(number as f64),
            Cell::Number(number) => Some(number),
            Cell::Text(text) => text.trim().parse().ok(),
        }
    }

    /// The number of a channel; `None` for anything else, as other columns may hold what they like.
    pub(super) fn channel(self) -> Option<f64> {
        self.number().filter(|number| number.is_finite())
    }
}

impl<'a> Cells<'a> {
    fn error(&self, column: usize, allowed: &str) -> InputError {
        let found = match self.cells[column] {
            Cell::Missing => "nothing".to_string(),
            Cell::Whole(number) => number.to_string(),
            Cell::Number(number) => short(number),
            Cell::Flag(flag) => flag.to_string(),
            Cell::Text(text) => format!("{text:?}"),
        };
        let remedy = "correct the cell, or delete the row";
        InputError::new(self.path, COLUMNS[column], found, allowed, remedy).at_line(self.line)
    }

    /// What a cell holds, if anything. It is an error if `found` is `None` and the cell is not empty.
    fn present<T>(&self, column: usize, found: Option<T>, allowed: impl ToString) -> Result<Option<T>, InputError> {
        match (found, self.cells[column]) {
            (None, Cell::Missing) => Ok(None),
            (None, _) => Err(self.error(column, &allowed.to_string())),
            (found, _) => Ok(found),
        }
    }

    /// A number within these limits.
    fn number(&self, column: usize, limits: Limits) -> Result<Option<f64>, InputError> {
        let number = self.cells[column].number().filter(|number| limits.hold(*number));
        self.present(column, number, format_args!("a number from {limits}"))
    }

    /// A whole number of a type without sign; see [`whole_number`].
    fn whole<T: TryFrom<i128>>(&self, column: usize) -> Result<Option<T>, InputError> {
        let number = match self.cells[column] {
            Cell::Whole(number) => Some(number),
            Cell::Number(number) => whole(number),
            Cell::Missing | Cell::Flag(_) => None,
            Cell::Text(text) => whole_number(text),
        };
        let most = u64::MAX >> (u64::BITS as usize - 8 * size_of::<T>());
        let number = number.and_then(|number| T::try_from(number).ok());
        self.present(column, number, format_args!("a whole number from 0 to {most}"))
    }

    fn text(&self, column: usize) -> Result<Option<String>, InputError> {
        match self.cells[column] {
            Cell::Missing => Ok(None),
            Cell::Whole(number) => Ok(Some(number.to_string())),
            Cell::Number(_) | Cell::Flag(_) => Err(self.error(column, "a name")),
            Cell::Text(text) if is_plain(text) => {
                let length = limits::NAME_BYTES.check(self.path, COLUMNS[column], text.len() as u64);
                length.map_err(|error| error.at_line(self.line))?;
                Ok(Some(text.to_string()))
            }
            Cell::Text(_) => Err(self.error(column, PLAIN)),
        }
    }

    /// The category, which no verdict can be mistaken for.
    fn category(&self) -> Result<Option<String>, InputError> {
        let category = self.text(1)?;
        match category.as_deref().and_then(Category::name_fault) {
            Some(allowed) => Err(self.error(1, allowed)),
            None => Ok(category),
        }
    }

    /// A truth value. 1 and 0 are allowed, because pandas converts truth values with gaps to floating point.
    fn flag(&self, column: usize) -> Result<Option<bool>, InputError> {
        let flag = match self.cells[column] {
            Cell::Flag(flag) => Some(flag),
            Cell::Text(text) if text.trim().eq_ignore_ascii_case("true") => Some(true),
            Cell::Text(text) if text.trim().eq_ignore_ascii_case("false") => Some(false),
            _ => self.whole::<u8>(column).ok().flatten().filter(|flag| *flag <= 1).map(|flag| flag == 1),
        };
        self.present(column, flag, "true or false")
    }

    /// The row with its types: a trial that is still without samples, and the sample.
    fn row(&mut self) -> Result<(Trial, Sample), InputError> {
        let time_s = self.number(5, limits::TIME_S)?;
        let force_n = self.number(6, limits::FORCE_N)?;
        let sample = Sample {
            time_s: time_s.ok_or_else(|| self.error(5, "a time in seconds"))?,
            force_n: force_n.ok_or_else(|| self.error(6, "a force in newtons"))?,
            motion_m: self.number(7, limits::MOTION_M)?,
            region: self.region()?,
            touched: self.flag(11)?,
            channels: std::mem::take(&mut self.channels),
        };
        let trial = Trial {
            trial: self.whole(0)?.ok_or_else(|| self.error(0, "the number of the trial"))?,
            category: self.category()?,
            reach: self.whole(2)?,
            patch: self.text(3)?,
            taxel: self.whole(4)?,
            samples: Vec::new(),
        };
        Ok((trial, sample))
    }

    /// An error unless a fact about a trial is the same as in its earlier rows.
    fn require_same<T: PartialEq + ToString>(
        &self,
        trial: u64,
        column: &str,
        own: &Option<T>,
        before: &Option<T>,
    ) -> Result<(), InputError> {
        if own == before {
            return Ok(());
        }
        let [found, before] = [own, before].map(|value| value.as_ref().map_or("nothing".to_string(), T::to_string));
        let allowed = format!("{before}, as in earlier rows of trial {trial}");
        let remedy = "give all rows of a trial the same value, or give each value its own trial number";
        Err(InputError::new(self.path, column, found, allowed, remedy).at_line(self.line))
    }

    /// The region, if the row has one.
    fn region(&self) -> Result<Option<Region>, InputError> {
        let taxels = self.whole::<u32>(8)?;
        let largest = self.number(9, limits::REGION_LARGEST_FORCE_N)?;
        let sum = self.number(10, limits::REGION_FORCE_SUM_N)?;
        if taxels.is_none() && largest.is_none() && sum.is_none() {
            return Ok(None);
        }
        let missing = |column: usize| self.error(column, "a number, because other columns of the region have one");
        let region = Region {
            taxels: taxels.ok_or_else(|| missing(8))?,
            largest_force_n: largest.ok_or_else(|| missing(9))?,
            force_sum_n: sum.ok_or_else(|| missing(10))?,
        };
        match region.fault() {
            Some((column, allowed)) => {
                let column = COLUMNS.iter().position(|name| *name == column).unwrap_or(10);
                Err(self.error(column, &allowed))
            }
            None => Ok(Some(region)),
        }
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
    pub(super) fn push(&mut self, mut cells: Cells) -> Result<(), InputError> {
        let (own, sample) = cells.row()?;
        let (path, number) = (cells.path, own.trial);
        self.rows += 1;
        limits::TABLE_ROWS.check(path, "rows", self.rows)?;
        let Some(&place) = self.places.get(&number) else {
            self.places.insert(number, self.trials.len());
            self.trials.push(Trial { samples: vec![sample], ..own });
            return Ok(());
        };
        let trial = &mut self.trials[place];
        cells.require_same(number, "category", &own.category, &trial.category)?;
        cells.require_same(number, "reach", &own.reach, &trial.reach)?;
        cells.require_same(number, "patch", &own.patch, &trial.patch)?;
        cells.require_same(number, "taxel", &own.taxel, &trial.taxel)?;
        let (time_s, before) = (sample.time_s, trial.samples.last().map_or(f64::NEG_INFINITY, |last| last.time_s));
        if time_s <= before {
            let allowed = format!("more than {before}, the previous time in trial {number}");
            let remedy = "sort the rows of each trial by time and delete duplicates";
            return Err(InputError::new(path, "time_s", time_s.to_string(), allowed, remedy).at_line(cells.line));
        }
        trial.samples.push(sample);
        let samples = limits::TRIAL_SAMPLES.check(path, "samples", trial.samples.len() as u64);
        samples.map_err(|error| error.at_line(cells.line))
    }
}
