//! The unrolled skin with a mark for the verdict on each taxel in contact, as SVG.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use crate::drawing::{Mark, escape, joined, svg_head};
use underbrush_classifier::decision::Verdict;
use underbrush_classifier::frequencies;
use underbrush_recording::Grid;

use crate::category_looks::CategoryLooks;
use crate::style::UNTOUCHED;

/// Colour and shape of a verdict: the paper's colours, with a shape for readers who cannot distinguish them. A taxel
/// that nothing presses on keeps the shape of its verdict and is grey.
pub fn mark_of(looks: &CategoryLooks, verdict: &str, pressed: bool) -> (&'static str, Mark) {
    let look = looks.look(verdict);
    (if pressed { look.colour } else { UNTOUCHED }, look.mark)
}

const CELL_PX: f64 = 21.0;
const LEFT: f64 = 30.0;
/// Baseline of the legend's first row, and the height of a row.
const LEGEND: f64 = 40.0;
const LEGEND_ROW: f64 = 22.0;

/// Draws the taxels of the moment's patch: rows along the forearm, the hand at the top, and columns around it from left
/// to right. The legend has the `labels` that a classifier can give. `name` is unique on a page.
pub fn svg(
    name: &str,
    (patch, grid): (&str, Grid),
    (labels, looks): (&[&str], &CategoryLooks),
    verdicts: &BTreeMap<usize, Verdict>,
    pressed: &BTreeSet<usize>,
) -> String {
    let width = LEFT + grid.columns as f64 * CELL_PX + 6.0;
    let (legend, rows) = legend(labels, looks, width);
    let top = LEGEND + rows as f64 * LEGEND_ROW - 6.0;
    let height = top + grid.rows as f64 * CELL_PX + 28.0;
    let counts = frequencies(verdicts.values().map(Verdict::name));
    let counts = joined(counts.iter().map(|(name, count)| format!("{name} {count}")), ", ");
    let untouched = verdicts.keys().filter(|taxel| !pressed.contains(taxel)).count();
    let described = format!("Taxels in contact by verdict: {counts}; nothing presses on {untouched} of them");
    let title = format!("Verdicts on the unrolled {patch}");
    let mut svg = svg_head(name, &title, &described, [width, height]);
    svg += &legend;
    for taxel in 0..grid.rows * grid.columns {
        let (row, column) = (taxel / grid.columns, taxel % grid.columns);
        let x = LEFT + column as f64 * CELL_PX;
        // Skin files count rows towards the end effector.
        let y = top + (grid.rows - 1 - row) as f64 * CELL_PX;
        let _ = writeln!(
            svg,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{CELL_PX}\" height=\"{CELL_PX}\" fill=\"#ffffff\" stroke=\"#d0d5da\"/>"
        );
        if let Some(verdict) = verdicts.get(&taxel) {
            let (colour, mark) = mark_of(looks, verdict.name(), pressed.contains(&taxel));
            svg += &mark.svg(x + CELL_PX / 2.0, y + CELL_PX / 2.0, 8.0, colour);
        }
    }
    let patch = escape(patch);
    let _ = writeln!(
        svg,
        "<text x=\"{LEFT}\" y=\"{:.1}\">columns, around the {patch}</text>\
         <text transform=\"translate(20 {top}) rotate(-90)\" text-anchor=\"end\">hand</text>\
         <text transform=\"translate(20 {:.1}) rotate(-90)\">elbow</text>\n</svg>",
        height - 8.0,
        top + grid.rows as f64 * CELL_PX
    );
    svg
}

/// A mark for each label and each other verdict, in as many rows as the width needs.
fn legend(labels: &[&str], looks: &CategoryLooks, width: f64) -> (String, usize) {
    let (mut svg, mut x, mut rows) = (String::new(), LEFT, 1);
    let verdicts = labels.iter().copied().chain(["outlier", "uncertain", "untouched"]);
    for label in verdicts {
        let entry = 32.0 + 8.4 * label.chars().count() as f64;
        if x > LEFT && x + entry > width {
            (x, rows) = (LEFT, rows + 1);
        }
        let y = LEGEND + (rows - 1) as f64 * LEGEND_ROW;
        let (colour, mark) = match label {
            // Any shape can be grey.
            "untouched" => (UNTOUCHED, Mark::Square),
            verdict => mark_of(looks, verdict, true),
        };
        svg += &mark.svg(x + 4.0, y - 5.0, 7.0, colour);
        let _ = writeln!(svg, "<text x=\"{:.1}\" y=\"{y}\">{}</text>", x + 16.0, escape(label));
        x += entry;
    }
    (svg, rows)
}
