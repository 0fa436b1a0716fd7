//! The tables of a data set or a recording: their columns, how a recording gives their rows and takes them, and descriptions
//! of them for the Parquet files, the card of a data set and the documents.

pub(super) mod dictionary;
pub(super) mod episode;
pub(super) mod frames;
pub(super) mod shared_tables;
pub(super) mod truth_bodies;
pub(super) mod truth_columns;
pub(super) mod truth_tables;

use std::collections::BTreeMap;

use serde::Serialize;

use self::dictionary::{
    FRAMES, MAP, OfReach, TAXELS, TRUTH_BODIES, TRUTH_CONTACT_POINTS, TRUTH_CONTACTS, TRUTH_GOALS, TRUTH_OBJECTS,
    TRUTH_PATCHES, TRUTH_POSES, TRUTH_TAXELS, Table,
};
use self::truth_bodies::body_rows;
use self::truth_tables::{
    contact_point_rows, contact_rows, goal_rows, map_rows, object_rows, patch_rows, pose_rows, taxel_rows,
};
use super::table::{COLUMNS_KEY, Column, Described, Row, Type};
use crate::{Category, Recording};

/// Makes the columns of a table for an episode.
type Columns = fn(usize, &Recording) -> Vec<Column>;

/// The columns of the rows of an episode, which its index precedes.
fn columns<R: Row>(episode: usize, rows: &[R]) -> Vec<Column> {
    let index = OfReach { episode_index: episode as i64 };
    let mut columns = OfReach::write(&vec![index; rows.len()]);
    columns.extend(R::write(rows));
    columns
}

/// The tables with rows for every reach beside the frames: ground truth, and what the controller believed.
pub(super) const FURTHER: [(&Table, Columns); 9] = [
    (&TRUTH_TAXELS, |episode, recording| columns(episode, &taxel_rows(recording))),
    (&TRUTH_PATCHES, |episode, recording| columns(episode, &patch_rows(recording))),
    (&TRUTH_OBJECTS, |episode, recording| columns(episode, &object_rows(recording))),
    (&TRUTH_CONTACTS, |episode, recording| columns(episode, &contact_rows(recording))),
    (&TRUTH_CONTACT_POINTS, |episode, recording| columns(episode, &contact_point_rows(recording))),
    (&TRUTH_GOALS, |episode, recording| columns(episode, &goal_rows(recording))),
    (&TRUTH_BODIES, |episode, recording| columns(episode, &body_rows(recording))),
    (&TRUTH_POSES, |episode, recording| columns(episode, &pose_rows(recording))),
    (&MAP, |episode, recording| columns(episode, &map_rows(recording))),
];

/// The tables with rows for every reach, first the frames.
pub(super) fn tables_of_reaches() -> impl Iterator<Item = &'static Table> {
    [&FRAMES].into_iter().chain(FURTHER.map(|(table, _)| table))
}

/// All tables that are described here. LeRobot's own tables in `meta/` are not among them.
pub(super) fn all_tables() -> impl Iterator<Item = &'static Table> {
    tables_of_reaches().chain([&TAXELS])
}

/// The codes of the built-in categories and of `further` ones with their names; −1 is none.
fn category_codes(further: &[Category]) -> BTreeMap<i8, String> {
    let categories = Category::BUILT_IN.iter().chain(further);
    let codes = categories.map(|category| (category.code(), category.name().to_owned()));
    codes.chain([(-1, "none".to_owned())]).collect()
}

/// What the metadata of a file say about a column.
#[derive(Serialize)]
struct About {
    description: &'static str,
    #[serde(skip_serializing_if = "str::is_empty")]
    unit: &'static str,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    codes: BTreeMap<i8, String>,
}

/// The columns of a file with their descriptions, units and codes, as a JSON object; `further` are categories that are
/// not built in.
pub(crate) fn about(tables: &[&Table], columns: &[Column], further: &[Category]) -> String {
    let described: Vec<Described> = tables.iter().flat_map(|table| (table.columns)()).collect();
    let all = columns.iter().filter_map(|column| {
        let found = described.iter().find(|described| described.covers(&column.name))?;
        let codes = if found.value == Type::Int8 { category_codes(further) } else { BTreeMap::new() };
        Some((&column.name, About { description: found.what, unit: found.unit, codes }))
    });
    serde_json::to_string(&all.collect::<BTreeMap<_, _>>()).unwrap_or_default()
}

/// As [`about`], as an entry of the metadata of a file.
pub(crate) fn about_entry(tables: &[&Table], columns: &[Column], further: &[Category]) -> (&'static str, String) {
    (COLUMNS_KEY, about(tables, columns, further))
}

/// Tables, columns, units and codes in Markdown; `further` are categories that are not built in.
pub(crate) fn describe_tables<'a>(tables: impl IntoIterator<Item = &'a Table>, further: &[Category]) -> String {
    let codes: Vec<_> = category_codes(further).iter().map(|(code, name)| format!("{code} {name}")).collect();
    let codes = codes.join(", ").replace('-', "−");
    let mut text = format!("Category codes: {codes}. The metadata of the Parquet files have units and codes, too.\n");
    for Table { name, path, row, columns } in tables {
        text += &format!("\n## {name} (`{path}`)\n\nOne row is {row}.\n\n");
        text += "| column | type | unit | what |\n|---|---|---|---|\n";
        for column in columns() {
            text += &format!("| `{}` | {} | {} | {} |\n", column.name, column.kind(), column.unit, column.what);
        }
    }
    text
}
