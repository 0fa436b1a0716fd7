//! Colours and marks of charts. Colour-blind readers can tell the colours apart, and every layer also has its own mark,
//! dash or hatching.

use crate::drawing::{Dash, Mark, Style};

/// Leaves.
pub const LEAF: &str = "#1b8a4b";
/// Trunks.
pub const TRUNK: &str = "#6b4423";
/// Outliers.
pub const OUTLIER: &str = "#c8102e";
/// Taxels without a verdict.
pub const UNCERTAIN: &str = "#1f5fbf";
/// Taxels that read a force although nothing presses on them.
pub const UNTOUCHED: &str = "#8a939c";
/// Correct verdicts.
pub const CORRECT: &str = "#009e73";
/// Wrong verdicts.
pub const WRONG: &str = "#d55e00";
/// Text and reference lines.
pub const INK: &str = "#222222";
/// The first of several series: the first recipe, the fewest states.
pub const FIRST: Style = Style::marked("#0072b2", Dash::Solid, Mark::Circle);
/// Published figures.
pub const PUBLISHED: Style = Style::marked(INK, Dash::Dotted, Mark::Diamond);
/// The majority baseline: a line without marks.
pub const MAJORITY: Style = Style::line("#7a828a", Dash::Dashed);

/// The majority baseline of single points.
pub const MAJORITY_MARK: Style = Style::marked("#7a828a", Dash::Dotted, Mark::Cross);

/// Series of a chart, in order.
const SERIES: [Style; 7] = [
    FIRST,
    Style::marked("#56b4e9", Dash::Dashed, Mark::Circle),
    Style::marked(TRUNK, Dash::Dashed, Mark::Square),
    Style::marked(OUTLIER, Dash::Dashed, Mark::Cross),
    Style::marked(WRONG, Dash::Solid, Mark::Diamond),
    Style::marked(UNCERTAIN, Dash::Dashed, Mark::Ring),
    Style::marked(CORRECT, Dash::Solid, Mark::Triangle),
];

/// Two series beside each other, in the two most different styles.
const PAIRED: [Style; 2] = [FIRST, Style::marked(WRONG, Dash::Dashed, Mark::Square)];

/// The style of a series by its position; styles repeat if there are more series.
pub fn series(place: usize) -> Style {
    SERIES[place % SERIES.len()]
}

/// The style of a series by its position, for charts with few series.
pub fn paired(place: usize) -> Style {
    PAIRED.get(place).copied().unwrap_or_else(|| series(place + 1))
}

/// Offset of the points of one of several series from their positions on an axis of names, so that the series do not
/// cover each other.
pub fn aside(place: usize, of: usize) -> f64 {
    let centred = place as f64 - (of.max(1) - 1) as f64 / 2.0;
    0.14 * centred
}
