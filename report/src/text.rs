//! Counts and tables for a terminal.

use std::collections::BTreeMap;
use std::fmt::Display;

use underbrush_experiments::audit::Worst;

use crate::drawing::{Rows, Table};

/// A number with its noun, such as "1 reach" or "2 reaches".
///
/// ```
/// use underbrush_report::text::counted;
///
/// assert_eq!([1, 2].map(|count| counted(count, "reach", "reaches")), ["1 reach", "2 reaches"]);
/// ```
pub fn counted<N: Copy + Display + PartialEq + From<u8>>(count: N, one: &str, many: &str) -> String {
    format!("{count} {}", if count == N::from(1) { one } else { many })
}

/// A table of columns padded to their widest entry. The first column is aligned left, the others right.
///
/// ```
/// use underbrush_report::text::table;
///
/// let rows = [["leaf", "7"], ["trunk", "12"]].map(|row| row.map(String::from).to_vec());
/// assert_eq!(table(&["category", "trials"], &rows).lines().last(), Some("trunk         12"));
/// ```
pub fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let width = |column: usize| {
        let entries = rows.iter().filter_map(|row| row.get(column)).map(|entry| entry.chars().count());
        entries.chain([header[column].chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    let line = |row: Vec<&str>| {
        let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, width))| {
            if column == 0 { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
        });
        cells.collect::<Vec<_>>().join("  ").trim_end().to_string() + "\n"
    };
    let mut text = line(header.to_vec());
    text += &(widths.iter().map(|width| "-".repeat(*width)).collect::<Vec<_>>().join("  ") + "\n");
    text.extend(rows.iter().map(|row| line(row.iter().map(String::as_str).collect())));
    text
}

/// The figures of an audit that pass their bounds as a table, or one line if none does.
pub fn audit(worst: &BTreeMap<&'static str, Worst>) -> String {
    let passed = worst.iter().filter_map(|(name, worst)| {
        let bound = worst.bound.filter(|bound| worst.value > *bound)?;
        Some((*name, worst, bound))
    });
    let rows = Rows::of(passed);
    if rows.things().next().is_none() {
        return "audit: within bounds\n".into();
    }
    rows.column("audit, beyond its bounds", |(name, ..)| name)
        .column("value", |(_, worst, _)| format!("{:.1e}", worst.value))
        .column("bound", |(.., bound)| format!("{bound:.1e}"))
        .column("worst reach", |(_, worst, _)| format!("{} {}", worst.scene, worst.reach_index))
        .text()
}

impl<T: Copy> Rows<T> {
    /// The rows as a table for a terminal.
    pub fn text(self) -> String {
        first_columns(&self.table("", ""), usize::MAX)
    }
}

/// The first columns of a table, for a terminal.
pub fn first_columns(own: &Table, columns: usize) -> String {
    let header: Vec<&str> = own.columns.iter().take(columns).map(String::as_str).collect();
    let rows = own.texts().into_iter().map(|row| row.into_iter().take(columns).collect());
    table(&header, &rows.collect::<Vec<_>>())
}
