//! Descriptions of tables: for the Parquet files, the card of a data set and the documents.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::Category;
use crate::disk::table::{COLUMNS_KEY, Column, Described, Type};
use crate::disk::tables::dictionary::Table;

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
    for Table { name, path, row, columns, .. } in tables {
        text += &format!("\n## {name} (`{path}`)\n\nOne row is {row}.\n\n");
        text += "| column | type | unit | what |\n|---|---|---|---|\n";
        for column in columns() {
            text += &format!("| `{}` | {} | {} | {} |\n", column.name, column.kind(), column.unit, column.what);
        }
    }
    text
}
