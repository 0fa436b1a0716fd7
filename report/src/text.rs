//! Counts and tables for a terminal.

use std::collections::BTreeMap;
use std::fmt::Display;

use underbrush_experiments::audit::Worst;

use crate::drawing::{Rows, Table, joined};

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
    ///
    /// ```
    /// use underbrush_report::drawing::Rows;
    ///
    /// let rows = Rows::of([("leaf", 7_usize), ("trunk", 12)]).column("category", |row| row.0).column("trials", |row| row.1);
    /// assert_eq!(rows.text().lines().last(), Some("trunk         12"));
    /// ```
    pub fn text(self) -> String {
        first_columns(&self.table("", ""), usize::MAX)
    }
}

/// The first columns of a table, for a terminal, each padded to its widest entry. The first column is aligned left, the
/// others right.
pub fn first_columns(own: &Table, columns: usize) -> String {
    let mut lines = [vec![own.columns.clone()], own.texts()].concat();
    lines.iter_mut().for_each(|line| line.truncate(columns));
    let width = |column: usize| {
        let entries = lines.iter().filter_map(|line| line.get(column));
        entries.map(|entry| entry.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..lines[0].len()).map(width).collect();
    let padded = |line: &Vec<String>| {
        let cells = line.iter().zip(&widths).enumerate().map(|(column, (cell, width))| {
            if column == 0 { format!("{cell:<width$}") } else { format!("{cell:>width$}") }
        });
        joined(cells, "  ").trim_end().to_string() + "\n"
    };
    let rule = joined(widths.iter().map(|width| "-".repeat(*width)), "  ");
    padded(&lines[0]) + &rule + "\n" + &lines[1..].iter().map(padded).collect::<String>()
}
