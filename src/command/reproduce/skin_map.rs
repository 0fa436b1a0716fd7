//! The unrolled skin with a mark for the verdict on each taxel in contact, as SVG.

use std::collections::BTreeMap;
use std::fmt::Write;

use underbrush_classifier::decision::Verdict;
use underbrush_classifier::report::{Mark, escape};
use underbrush_recording::Grid;

use super::figures::{LEAF, OUTLIER, TRUNK, UNCERTAIN};

/// Colour and shape of a verdict: the paper's colours, with a shape for those who do not see them.
pub fn mark_of(verdict: &Verdict) -> (&'static str, Mark) {
    match verdict {
        Verdict::Category(name) if name == "leaf" => (LEAF, Mark::Triangle),
        Verdict::Category(_) => (TRUNK, Mark::Square),
        Verdict::Outlier => (OUTLIER, Mark::Cross),
        Verdict::Uncertain => (UNCERTAIN, Mark::Ring),
    }
}

const CELL_PX: f64 = 21.0;
const LEFT: f64 = 30.0;
const TOP: f64 = 56.0;
const FONT: f64 = 15.0;

/// Draws rows, along the forearm towards the hand, downwards, and columns, around it, to the right. `name` is unique on a page.
pub fn svg(name: &str, grid: Grid, verdicts: &BTreeMap<usize, Verdict>) -> String {
    let (width, height) = (
        LEFT + grid.columns as f64 * CELL_PX + 6.0,
        TOP + grid.rows as f64 * CELL_PX + 28.0,
    );
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    verdicts
        .values()
        .for_each(|verdict| *counts.entry(verdict.name()).or_default() += 1);
    let counts: Vec<String> = counts.iter().map(|(name, count)| format!("{name} {count}")).collect();
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" \
         aria-labelledby=\"{name}-title {name}-desc\" font-family=\"sans-serif\" font-size=\"{FONT}\" fill=\"#222222\">\n\
         <title id=\"{name}-title\">Verdicts on the unrolled forearm</title>\n\
         <desc id=\"{name}-desc\">Taxels in contact by verdict: {}</desc>\n\
         <text x=\"2\" y=\"{FONT}\" font-weight=\"bold\">Verdicts on the unrolled forearm</text>\n",
        escape(&counts.join(", "))
    );
    let mut x = LEFT;
    for (label, verdict) in [
        ("leaf", Verdict::Category("leaf".into())),
        ("trunk", Verdict::Category("trunk".into())),
        ("outlier", Verdict::Outlier),
        ("uncertain", Verdict::Uncertain),
    ] {
        let (colour, mark) = mark_of(&verdict);
        let _ = writeln!(
            svg,
            "{}<text x=\"{:.1}\" y=\"40\">{label}</text>",
            mark.svg(x + 4.0, 35.0, 7.0, colour),
            x + 16.0
        );
        x += 34.0 + 9.0 * label.len() as f64;
    }
    for taxel in 0..grid.rows * grid.columns {
        let x = LEFT + (taxel % grid.columns) as f64 * CELL_PX;
        let y = TOP + (taxel / grid.columns) as f64 * CELL_PX;
        let _ = writeln!(
            svg,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{CELL_PX}\" height=\"{CELL_PX}\" fill=\"#ffffff\" stroke=\"#d0d5da\"/>"
        );
        if let Some(verdict) = verdicts.get(&taxel) {
            let (colour, mark) = mark_of(verdict);
            svg += &mark.svg(x + CELL_PX / 2.0, y + CELL_PX / 2.0, 8.0, colour);
        }
    }
    let _ = writeln!(
        svg,
        "<text x=\"{LEFT}\" y=\"{:.1}\">columns, around the forearm</text>\
         <text transform=\"translate(20 {TOP}) rotate(-90)\" text-anchor=\"end\">rows, to the hand</text>\n</svg>",
        height - 8.0
    );
    svg
}
