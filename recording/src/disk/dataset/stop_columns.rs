//! The columns of the contact whose force exceeded the stop force: of a goal in `truth/goals`, of a whole reach in
//! `meta/episodes`. All are null if there was none; the patch is also null if most of the force fell on a part of the link
//! without skin.

use arrow_array::types::{Float64Type, Int32Type};
use arrow_array::{Array, Float64Array, Int32Array, StringArray};

use crate::disk::DiskError;
use crate::disk::table::{Columns, TableBuilder};

const OBJECT: &str = "stop_object_index";
const KIND: &str = "stop_object_kind";
const LINK: &str = "stop_link";
/// The column of the patch, which may be null.
pub(super) const PATCH: &str = "stop_patch";
const FORCE: &str = "stop_force_n";

/// A contact whose force exceeded the stop force.
#[derive(Clone, Copy)]
pub(super) struct Stop<'a> {
    pub(super) object: u16,
    pub(super) link: &'a str,
    pub(super) patch: Option<&'a str>,
    pub(super) force_n: f64,
}

/// Adds the columns. If `kinds` are given, the kinds of the objects become a further column.
pub(super) fn write<'a>(
    table: TableBuilder,
    stops: impl Iterator<Item = Option<Stop<'a>>> + Clone,
    kinds: Option<StringArray>,
) -> TableBuilder {
    let objects = stops.clone().map(|stop| stop.map(|stop| i32::from(stop.object)));
    let links = stops.clone().map(|stop| stop.map(|stop| stop.link));
    let patches = stops.clone().map(|stop| stop?.patch);
    let forces = stops.map(|stop| stop.map(|stop| stop.force_n));
    let table = table.column(OBJECT, objects.collect::<Int32Array>());
    let table = kinds.into_iter().fold(table, |table, kinds| table.column(KIND, kinds));
    table
        .column(LINK, links.collect::<StringArray>())
        .column(PATCH, patches.collect::<StringArray>())
        .column(FORCE, forces.collect::<Float64Array>())
}

/// Reads the columns, one contact or none for each row.
pub(super) fn read<'a>(columns: &Columns<'a>) -> Result<Vec<Option<Stop<'a>>>, DiskError> {
    let object = columns.numbers_or_null::<Int32Type>(OBJECT)?;
    let link = columns.text_or_null(LINK)?;
    let patch = columns.text_or_null(PATCH)?;
    let force = columns.numbers_or_null::<Float64Type>(FORCE)?;
    let stop = |row: usize| match [object.is_valid(row), link.is_valid(row), force.is_valid(row)] {
        [false, false, false] if !patch.is_valid(row) => Ok(None),
        [true, true, true] => Ok(Some(Stop {
            object: object_index(columns, OBJECT, object.value(row))?,
            link: link.value(row),
            patch: patch.is_valid(row).then(|| patch.value(row)),
            force_n: force.value(row),
        })),
        _ => Err(some_missing(columns)),
    };
    (0..columns.batch.num_rows()).map(stop).collect()
}

/// Reads the column of the objects' kinds, null where `stops` has none.
pub(super) fn read_kinds<'a>(
    columns: &Columns<'a>,
    stops: &[Option<Stop<'a>>],
) -> Result<Vec<Option<&'a str>>, DiskError> {
    let kinds = columns.text_or_null(KIND)?;
    let kind = |(row, stop): (usize, &Option<Stop>)| {
        let kind = kinds.is_valid(row).then(|| kinds.value(row));
        match kind.is_some() == stop.is_some() {
            true => Ok(kind),
            false => Err(some_missing(columns)),
        }
    };
    stops.iter().enumerate().map(kind).collect()
}

fn some_missing(columns: &Columns) -> DiskError {
    columns.error(
        "the columns stop_…",
        "only some of them",
        "all of them (stop_patch may be null), or none",
    )
}

/// The index of an object.
pub(super) fn object_index(columns: &Columns, column: &str, object: i32) -> Result<u16, DiskError> {
    u16::try_from(object).map_err(|_| columns.error(column, object.to_string(), "0 to 32767"))
}
