//! Trials as CSV (RFC 4180, UTF-8, with a header line).

use std::path::Path;
use std::sync::Arc;

use super::rows::{Cell, Cells, Collector};
use super::{COLUMNS, channel_columns, columns_of, place_columns};
use crate::disk::files::{self, TemporaryFile};
use crate::fault::line_of_row;
use crate::limits::CSV_BYTES;
use crate::{DiskError, InputError, Result, Trial, read_bytes};

/// Reads a table.
pub(super) fn read(path: &Path) -> Result<Vec<Trial>> {
    let text = read_bytes(path, &CSV_BYTES, "a readable file", "check the path")?;
    let remedy = "correct the line, or save the table again as CSV in UTF-8";
    let refused = |error: csv::Error| InputError::of_csv(path, "row", &text, error, remedy);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_slice());
    let header = reader.headers().map_err(refused)?;
    let names: Vec<String> = header.iter().map(str::to_owned).collect();
    let places = place_columns(path, &names)?;
    let others = channel_columns(&names);
    let mut collector = Collector::default();
    let mut record = csv::StringRecord::new();
    while reader.read_record(&mut record).map_err(refused)? {
        let cell = |place: Option<usize>| match place.and_then(|place| record.get(place)) {
            None | Some("") => Cell::Missing,
            Some(text) => Cell::Text(text),
        };
        let line = record.position().map_or(0, |position| line_of_row(&text, position));
        let channels =
            others.iter().filter_map(|(name, place)| Some((Arc::clone(name), cell(Some(*place)).channel()?)));
        collector.push(Cells { path, line, channels: channels.collect(), cells: places.map(cell) })?;
    }
    Ok(collector.trials)
}

/// Writes a table. Numbers are the shortest text that gives the same double when read.
pub(super) fn write(path: &Path, channels: &[Arc<str>], trials: &[Trial]) -> Result<()> {
    // Not `DiskError::io` for each row: it copies the path.
    let failed = |error: csv::Error| DiskError::io(path, "write")(error);
    let TemporaryFile { file, registered } = files::begin(path)?;
    let mut writer = csv::Writer::from_writer(file);
    let names: Vec<&str> = COLUMNS.into_iter().chain(channels.iter().map(|name| &**name)).collect();
    writer.write_record(names).map_err(failed)?;
    for trial in trials {
        let columns = columns_of(std::slice::from_ref(trial), channels);
        for row in 0..trial.samples.len() {
            writer.write_record(columns.iter().map(|column| column.shown(row))).map_err(failed)?;
        }
    }
    let file = writer.into_inner().map_err(|error| DiskError::io(path, "write")(error.into_error()))?;
    files::commit(TemporaryFile { file, registered }, path)
}
