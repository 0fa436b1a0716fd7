//! Frames from an HDF5 file: a dataset has a row for each frame and a column for each taxel.

use std::path::Path;

use hdf5_pure::{AttrValue, Dataset, File, Group};
use underbrush_recording::InputError;
use underbrush_recording::limits::{self, MAX_TAXELS};

use super::cutter::{Cutter, Place};
use super::{Mapping, opened};
use crate::ExchangeError;

/// Numbers that are read together. Choice: some megabytes.
const NUMBERS_PER_READ: u64 = 1 << 20;

/// An error about the file.
fn broken(path: &Path, cause: impl ToString) -> InputError {
    let remedy = "check the file with h5dump, or write it again";
    InputError::new(path, "HDF5", cause.to_string(), "a readable HDF5 file", remedy)
}

/// The paths of the groups that a pattern with `*` matches; the root of the file if there is no `*`. Groups whose names
/// end in a number are sorted by it, so `demo_2` comes before `demo_10`.
fn reaches(path: &Path, mapping: &Mapping, file: &File) -> Result<Vec<String>, InputError> {
    let from = &mapping.force.from;
    let Some((parent, _)) = from.split_once('*') else {
        return Ok(vec![String::new()]);
    };
    let parent = parent.trim_matches('/');
    let group: Group = match parent {
        "" => file.root(),
        name => file.group(name).map_err(|_| {
            let allowed = format!("the path of a dataset of {}", path.display());
            mapping.fault("force.from", format!("{from:?}: there is no group {name:?}"), allowed)
        })?,
    };
    let mut names = group.groups().map_err(|error| broken(path, error))?;
    let number = |name: &str| {
        let digits = name.len() - name.bytes().rev().take_while(u8::is_ascii_digit).count();
        name[digits..].parse::<u64>().ok()
    };
    names.sort_by(|a, b| number(a).cmp(&number(b)).then_with(|| a.cmp(b)));
    Ok(names.into_iter().map(|name| format!("{parent}/{name}")).collect())
}

/// A dataset that the mapping names.
struct Numbers<'a> {
    /// The key of the mapping.
    field: &'a str,
    /// The path in the file.
    name: String,
    data: Dataset,
}

impl<'a> Numbers<'a> {
    /// The dataset at a path of the mapping, for the reach in a group.
    fn open(
        path: &Path,
        mapping: &Mapping,
        file: &File,
        field: &'a str,
        from: &str,
        group: &str,
    ) -> Result<Self, InputError> {
        let name = match from.split_once('*') {
            Some((_, rest)) => format!("{group}{rest}"),
            None => from.to_owned(),
        };
        match file.dataset(name.trim_matches('/')) {
            Ok(data) => Ok(Numbers { field, name, data }),
            Err(_) => {
                let allowed = format!("the path of a dataset of {}", path.display());
                Err(mapping.fault(field, format!("{name:?}, which is no dataset"), allowed))
            }
        }
    }

    /// Checks what the dataset declares to hold against the length of the file: its numbers and one chunk of them.
    fn check_size(&self, path: &Path, file_bytes: u64) -> Result<(), InputError> {
        let shape = self.data.shape().map_err(|error| broken(path, error))?;
        let chunk = self.data.chunk_shape().map_err(|error| broken(path, error))?;
        for shape in [Some(shape), chunk].into_iter().flatten() {
            let bytes = shape.into_iter().fold(8, u64::saturating_mul);
            limits::check_expansion(path, &self.name, bytes, file_bytes)?;
        }
        Ok(())
    }

    /// The numbers of `count` rows from row `first`, `width` in each row.
    fn rows(
        &self,
        path: &Path,
        mapping: &Mapping,
        first: u64,
        count: u64,
        width: usize,
    ) -> Result<Vec<f64>, InputError> {
        let numbers = self.data.read_f64_rows(first, count).map_err(|error| broken(path, error))?;
        // The reader gives no numbers, and no error, for types that it cannot convert, such as float16.
        if numbers.len() as u64 != count * width as u64 {
            let found = format!("{:?}, which has numbers of an unsupported type", self.name);
            return Err(mapping.fault(self.field, found, "integers, float32 or float64"));
        }
        Ok(numbers)
    }
}

/// The category of the reach in a group.
fn category(path: &Path, mapping: &Mapping, file: &File, group: &str) -> Result<String, InputError> {
    let Some(name) = &mapping.trial.category_from else {
        return Ok(mapping.trial.category.clone().unwrap_or_default());
    };
    let holder = match group.trim_matches('/') {
        "" => file.root(),
        group => file.group(group).map_err(|error| broken(path, error))?,
    };
    let attributes = holder.attrs().map_err(|error| broken(path, error))?;
    let text = attributes.get(name).and_then(AttrValue::as_str);
    text.map(str::to_owned).ok_or_else(|| {
        let mut names: Vec<&str> = attributes.keys().map(String::as_str).collect();
        names.sort_unstable();
        let allowed = format!("a text attribute of the group {group:?}: {}", names.join(", "));
        mapping.fault("trial.category_from", format!("{name:?}"), allowed)
    })
}

/// The error about a row, with the group of its reach: rows are counted in each reach.
fn of_reach(group: &str, mut error: InputError) -> InputError {
    if !group.is_empty() {
        error.field = format!("{}, {}", group.trim_matches('/'), error.field);
    }
    error
}

/// Hands all rows of all reaches to the cutter.
pub(super) fn read(path: &Path, mapping: &Mapping, cutter: &mut Cutter) -> Result<(), ExchangeError> {
    mapping.refuse("force.topic", mapping.force.topic.is_some(), "HDF5")?;
    mapping.refuse("force.taxels", mapping.force.taxels.is_some(), "HDF5")?;
    mapping.refuse("trial.reach_from", mapping.trial.reach_from.is_some(), "HDF5")?;
    if mapping.time.from.is_none() && mapping.time.rate_hz.is_none() {
        return Err(mapping.fault("time.from", "nothing".into(), "the dataset of the times, or `rate_hz`").into());
    }
    let length = opened(path)?.metadata().map_err(|error| broken(path, error))?.len();
    let file = File::open_streaming(path).map_err(|error| broken(path, error))?;
    for (reach, group) in (0..).zip(reaches(path, mapping, &file)?) {
        let from = &mapping.force.from;
        let forces = Numbers::open(path, mapping, &file, "force.from", from, &group)?;
        let shape = forces.data.shape().map_err(|error| broken(path, error))?;
        let (frames, taxels) = match shape[..] {
            [frames] => (frames, 1),
            [frames, taxels] if (1..=MAX_TAXELS as u64).contains(&taxels) => (frames, taxels as usize),
            _ => {
                let found = format!("{:?}, whose shape is {shape:?}", forces.name);
                return Err(mapping
                    .fault(
                        "force.from",
                        found,
                        format!("shape [frames] or [frames, taxels] with 1 to {MAX_TAXELS} taxels"),
                    )
                    .into());
            }
        };
        forces.check_size(path, length)?;
        let times = match &mapping.time.from {
            Some(from) => Some(Numbers::open(path, mapping, &file, "time.from", from, &group)?),
            None => None,
        };
        if let Some(times) = &times {
            times.check_size(path, length)?;
            let shape = times.data.shape().map_err(|error| broken(path, error))?;
            if shape != [frames] {
                let found = format!("{:?}, whose shape is {shape:?}", times.name);
                return Err(mapping.fault("time.from", found, format!("[{frames}], one time for each frame")).into());
            }
        }
        let category = category(path, mapping, &file, &group)?;
        let mut first = 0;
        while first < frames {
            let count = (NUMBERS_PER_READ / taxels as u64).clamp(1, frames - first);
            let readings = forces.rows(path, mapping, first, count, taxels)?;
            let times_s = match &times {
                Some(times) => times.rows(path, mapping, first, count, 1)?,
                None => Vec::new(),
            };
            for (row, readings) in readings.chunks_exact(taxels).enumerate() {
                let index = first + row as u64;
                let time_s = match times_s.get(row) {
                    Some(time) => mapping.time_s(*time),
                    None => index as f64 / mapping.time.rate_hz.unwrap_or(1.0),
                };
                let place = Place { line: index as usize + 1, reach, category: &category, time_s };
                cutter.push(&place, readings).map_err(|error| of_reach(&group, error))?;
            }
            first += count;
        }
    }
    Ok(())
}
