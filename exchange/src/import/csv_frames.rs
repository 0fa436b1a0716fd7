//! Frames from a CSV file: a row is a frame, and each taxel has a column.

use std::collections::BTreeSet;
use std::path::Path;

use underbrush_recording::disk::whole_number;
use underbrush_recording::fault::line_of_row;
use underbrush_recording::limits::{CSV_BYTES, short};
use underbrush_recording::{InputError, read_bytes};

use super::Mapping;
use super::cutter::{Cutter, Place};
use super::mapping::{Channel, MappingFile, TAXEL};
use super::recorder::Recorder;

/// The indices of the columns.
struct Columns {
    time: Option<usize>,
    forces: Vec<usize>,
    category: Option<usize>,
    reach: Option<usize>,
    /// For each channel, the columns of the taxels, or one for all.
    channels: Vec<Vec<usize>>,
    /// Place and orientation of the skin: seven columns.
    pose: Option<Vec<usize>>,
}

impl Columns {
    /// Finds the columns of the mapping among the names in the header.
    fn find(path: &Path, mapping: &Mapping, names: &csv::StringRecord) -> Result<Self, InputError> {
        let MappingFile { time, force, trial, .. } = &mapping.file;
        let place = |field: &str, name: &str| -> Result<usize, InputError> {
            // `InputError` shortens the list if it is long.
            let allowed = || format!("a column of {}: {}", path.display(), names.iter().collect::<Vec<_>>().join(", "));
            let mut found = names.iter().enumerate().filter(|(_, column)| *column == name);
            match (found.next(), found.next()) {
                (Some((place, _)), None) => Ok(place),
                (None, _) => Err(mapping.fault(field, format!("{name:?}, which is no column"), allowed())),
                (Some(_), Some(_)) => Err(mapping.fault(field, format!("{name:?}, which two columns have"), allowed())),
            }
        };
        let optional = |field: &str, name: &Option<String>| name.as_deref().map(|name| place(field, name)).transpose();
        let from = &force.from;
        match (force.taxels, from.contains(TAXEL)) {
            (None, true) => {
                let allowed = format!("`taxels = N`, because `from` has {TAXEL}");
                return Err(mapping.fault("force.taxels", "nothing".into(), allowed));
            }
            (Some(2..), false) => {
                let allowed = format!("a name with {TAXEL} in place of the number of the taxel, or 1 taxel");
                return Err(mapping.fault("force.from", format!("{from:?}"), allowed));
            }
            _ => {}
        }
        // The columns of all taxels, or the only one.
        let places = |field: &str, from: &str| -> Result<Vec<usize>, InputError> {
            let columns = if from.contains(TAXEL) { mapping.taxels() } else { 1 };
            (0..columns).map(|taxel| place(field, &from.replace(TAXEL, &taxel.to_string()))).collect()
        };
        let channel = |(number, own): (usize, &Channel)| places(&format!("channel[{number}].from"), &own.from);
        let forces = places("force.from", from)?;
        let channels = mapping.file.channel.iter().enumerate().map(channel).collect::<Result<_, _>>()?;
        let pose_from = mapping.file.skin.as_ref().and_then(|skin| skin.pose_from.as_ref());
        let pose =
            pose_from.map(|names| names.iter().map(|name| place("skin.pose_from", name)).collect()).transpose()?;
        Ok(Columns {
            pose,
            channels,
            time: optional("time.from", &time.from)?,
            forces,
            category: optional("trial.category_from", &trial.category_from)?,
            reach: optional("trial.reach_from", &trial.reach_from)?,
        })
    }
}

/// Hands all rows of the file to the cutter and, if there is one, to the recorder. Returns a warning for everything that is
/// suspicious about the file.
pub(super) fn read(
    path: &Path,
    mapping: &Mapping,
    cutter: &mut Cutter,
    mut recorder: Option<&mut Recorder>,
) -> Result<Vec<String>, InputError> {
    if mapping.file.time.from.is_none() && mapping.file.time.rate_hz.is_none() {
        return Err(mapping.fault("time.from", "nothing".into(), "the column of the times, or `rate_hz`"));
    }
    let text = read_bytes(path, &CSV_BYTES, "a readable file", "check the path")?;
    let mut parser = csv::ReaderBuilder::new();
    parser.trim(csv::Trim::All);
    // The name of the first column may begin with `#`, too.
    let is_header = |names: &csv::StringRecord| Columns::find(path, mapping, names).is_ok();
    if !parser.from_reader(&text[..]).headers().is_ok_and(is_header) {
        parser.comment(Some(b'#'));
    }
    let remedy = "repair the file, or write it again as UTF-8 with one row per line";
    let unreadable = |error: csv::Error| InputError::of_csv(path, "CSV", &text, error, remedy);
    let mut reader = parser.from_reader(&text[..]);
    let names = reader.headers().map_err(unreadable)?.clone();
    let line_of = |row: &csv::StringRecord| row.position().map_or(1, |position| line_of_row(&text, position));
    let columns = Columns::find(path, mapping, &names)?;
    let mut row = csv::StringRecord::new();
    let mut readings = vec![0.0; columns.forces.len()];
    let mut channels: Vec<Vec<Option<f64>>> = vec![Vec::new(); columns.channels.len()];
    let mut used_labels = BTreeSet::new();
    // Frames of the reach so far, for times that follow from the rate.
    let (mut reach_before, mut number) = (None, 0u64);
    while reader.read_record(&mut row).map_err(unreadable)? {
        let line = line_of(&row);
        let cell = |column: usize| row.get(column).unwrap_or_default();
        let wrong = |column: usize, allowed: &str| {
            let (name, found) = (names.get(column).unwrap_or_default(), cell(column));
            let found = if found.is_empty() { "nothing".into() } else { format!("{found:?}") };
            InputError::new(path, name, found, allowed, "correct the cell, or delete the row").at_line(line)
        };
        let wrong_number = |column: usize| wrong(column, "a number, with a point before its decimals");
        let parsed = |column: usize| cell(column).parse::<f64>().map_err(|_| wrong_number(column));
        for (reading, column) in readings.iter_mut().zip(&columns.forces) {
            *reading = parsed(*column)?;
        }
        let whole = |column: usize| {
            let number = whole_number(cell(column)).and_then(|number| u64::try_from(number).ok());
            number.ok_or_else(|| wrong(column, "a whole number, 0 or more"))
        };
        let reach = columns.reach.map_or(Ok(0), whole)?;
        number = if reach_before.replace(reach) == Some(reach) { number + 1 } else { 0 };
        let time_s = match columns.time {
            Some(column) => mapping.time_s(parsed(column)?),
            None => number as f64 / mapping.file.time.rate_hz.unwrap_or(1.0),
        };
        let category = match columns.category {
            Some(column) => cell(column),
            None => {
                let [own, general] = mapping.labels(reach, time_s);
                used_labels.extend([own, general].into_iter().flatten());
                mapping.category(own.or(general))
            }
        };
        let measured = |column: &usize| cell(*column).parse().ok().filter(|number: &f64| number.is_finite());
        for (numbers, columns) in channels.iter_mut().zip(&columns.channels) {
            numbers.clear();
            numbers.extend(columns.iter().map(measured));
        }
        let place = Place { line, reach, category, time_s };
        if let Some(recorder) = recorder.as_deref_mut() {
            let mut pose = None;
            if let Some(columns) = &columns.pose {
                let numbers = pose.insert([0.0; 7]);
                for (number, column) in numbers.iter_mut().zip(columns) {
                    let cell = Some(parsed(*column)?).filter(|cell| cell.abs() <= 1e3);
                    *number = cell.ok_or_else(|| wrong(*column, "a number up to 1000"))?;
                }
                let length = numbers[3..].iter().map(|number| number * number).sum::<f64>().sqrt();
                if (length - 1.0).abs() > 0.01 {
                    let allowed = format!("a quaternion of length 1, to 1 %; this one has {}", short(length));
                    return Err(wrong(columns[6], &allowed));
                }
            }
            recorder.push(&place, &readings, pose)?;
        }
        cutter.push(&place, &readings, &channels)?;
    }
    let (from, taxels) = (&mapping.file.force.from, mapping.taxels());
    let next = from.replace(TAXEL, &taxels.to_string());
    let is_left_out = from.contains(TAXEL) && names.iter().any(|column| column == next);
    let left_out = is_left_out.then(|| format!("the column {next:?} is left out: `taxels` of the mapping is {taxels}"));
    Ok(left_out.into_iter().chain(mapping.unused_labels(&used_labels)).collect())
}
