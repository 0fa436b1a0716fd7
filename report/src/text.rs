//! Counts and audits for a terminal.

use std::collections::BTreeMap;
use std::fmt::Display;

use underbrush_experiments::audit::Worst;

use crate::Rows;

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
