//! Frames from a CSV file: a row is a frame, and each taxel has a column.

use std::collections::BTreeSet;
use std::path::Path;

use underbrush_recording::fault::line_of_row;
use underbrush_recording::limits::{CSV_BYTES, short};
use underbrush_recording::{InputError, read_bytes};

use super::Mapping;
use super::cutter::{Cutter, Place};
use super::mapping::{Channel, TAXEL};
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
    fn find(path: &Path, mapping: &Mapping, names: &csv::StringRecord) -> Result<Self, InputError> {
        let place = |field: &str, name: &str| -> Result<usize, InputError> {
            // `InputError` shortens the list if it is long.
            let listed = || names.iter().collect::<Vec<_>>().join(", ");
            let allowed = || format!("a column of {}: {}", path.display(), listed());
            let mut found = names.iter().enumerate().filter(|(_, column)| column.trim() == name);
            match (found.next(), found.next()) {
                (Some((place, _)), None) => Ok(place),
                (None, _) if names.len() < 2 && names.iter().all(|name| name.contains([';', '\t'])) => {
                    let found = names.get(0).map_or("an empty file".into(), |name| format!("one column, {name:?}"));
                    let allowed = "columns with commas between them, and their names in the first line";
                    Err(InputError::new(path, "CSV", found, allowed, "write the file with commas").at_line(1))
                }
                (None, _) => Err(mapping.fault(field, format!("{name:?}, which is no column"), allowed())),
                (Some(_), Some(_)) => Err(mapping.fault(field, format!("{name:?}, which two columns have"), allowed())),
            }
        };
        let optional = |field: &str, name: &Option<String>| name.as_deref().map(|name| place(field, name)).transpose();
        let from = &mapping.file.force.from;
        match (mapping.file.force.taxels, from.contains(TAXEL)) {
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
            time: optional("time.from", &mapping.file.time.from)?,
            forces,
            category: optional("trial.category_from", &mapping.file.trial.category_from)?,
            reach: optional("trial.reach_from", &mapping.file.trial.reach_from)?,
        })
    }
}

/// Hands all rows of the file to the cutter and, if the skin is known, to the recorder. Returns the numbers of the labels that
/// cover a frame.
pub(super) fn read(
    path: &Path,
    mapping: &Mapping,
    cutter: &mut Cutter,
    mut recorder: Option<&mut Recorder>,
) -> Result<BTreeSet<usize>, InputError> {
    if mapping.file.time.from.is_none() && mapping.file.time.rate_hz.is_none() {
        return Err(mapping.fault("time.from", "nothing".into(), "the column of the times, or `rate_hz`"));
    }
    let text = read_bytes(path, &CSV_BYTES, "a readable file", "check the path")?;
    let unreadable = |error: csv::Error| {
        let line = error.position().map_or(1, |position| line_of_row(&text, position));
        let remedy = "repair the file, or write it again as UTF-8 with one row per line";
        InputError::new(path, "CSV", error.to_string(), "rows with as many cells as the header", remedy).at_line(line)
    };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(&text[..]);
    let names = reader.headers().map_err(unreadable)?.clone();
    let columns = Columns::find(path, mapping, &names)?;
    let mut row = csv::StringRecord::new();
    let mut readings = vec![0.0; columns.forces.len()];
    let mut channels: Vec<Vec<Option<f64>>> = vec![Vec::new(); columns.channels.len()];
    let mut used_labels = BTreeSet::new();
    // Frames of the reach so far, for times that follow from the rate.
    let (mut reach_before, mut number) = (None, 0u64);
    while reader.read_record(&mut row).map_err(unreadable)? {
        let line = row.position().map_or(0, |position| line_of_row(&text, position));
        let cell = |column: usize| row.get(column).unwrap_or_default();
        let wrong = |column: usize, allowed: &str| {
            let (name, found) = (names.get(column).unwrap_or_default(), cell(column));
            let found = if found.is_empty() { "nothing".into() } else { format!("{found:?}") };
            InputError::new(path, name, found, allowed, "correct the cell, or delete the row").at_line(line)
        };
        let parsed = |column: usize| cell(column).parse::<f64>().map_err(|_| wrong(column, "a number"));
        for (reading, column) in readings.iter_mut().zip(&columns.forces) {
            *reading = parsed(*column)?;
        }
        let reach = match columns.reach {
            Some(column) => cell(column).parse().map_err(|_| wrong(column, "a whole number, 0 or more"))?,
            None => 0,
        };
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
    Ok(used_labels)
}
