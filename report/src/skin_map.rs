//! The unrolled skin with a mark for the verdict on each taxel in contact, as SVG.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use crate::drawing::{Mark, escape, slug};
use underbrush_classifier::decision::Verdict;
use underbrush_recording::Grid;

use crate::style::{self, UNTOUCHED};

/// Colour and shape of a verdict: the paper's colours, with a shape for readers who cannot distinguish them. A taxel
/// that nothing presses on keeps the shape of its verdict and is grey.
pub fn mark_of(verdict: &Verdict, pressed: bool) -> (&'static str, Mark) {
    let (colour, mark) = style::category(verdict.name(), verdict.name().len());
    (if pressed { colour } else { UNTOUCHED }, mark)
}

const CELL_PX: f64 = 21.0;
const LEFT: f64 = 30.0;
const TOP: f64 = 56.0;
const FONT: f64 = 15.0;

/// Draws the taxels of the moment's patch: rows along the forearm, the hand at the top, and columns around it from left to
/// right. `name` is unique on a page.
pub fn svg(name: &str, grid: Grid, verdicts: &BTreeMap<usize, Verdict>, pressed: &BTreeSet<usize>) -> String {
    let name = slug(name);
    let (width, height) = (
        LEFT + grid.columns as f64 * CELL_PX + 6.0,
        TOP + grid.rows as f64 * CELL_PX + 28.0,
    );
    let mut counts: BTreeMap<&str, usize> = BTreeMap::new();
    verdicts
        .values()
        .for_each(|verdict| *counts.entry(verdict.name()).or_default() += 1);
    let counts: Vec<String> = counts.iter().map(|(name, count)| format!("{name} {count}")).collect();
    let untouched = verdicts.keys().filter(|taxel| !pressed.contains(taxel)).count();
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" role=\"img\" \
         aria-labelledby=\"{name}-title {name}-desc\" font-family=\"sans-serif\" font-size=\"{FONT}\" fill=\"#222222\">\n\
         <title id=\"{name}-title\">Verdicts on the unrolled forearm</title>\n\
         <desc id=\"{name}-desc\">Taxels in contact by verdict: {}; nothing presses on {untouched} of them</desc>\n\
         <text x=\"2\" y=\"{FONT}\" font-weight=\"bold\">Verdicts on the unrolled forearm</text>\n",
        escape(&counts.join(", "))
    );
    legend(&mut svg);
    for taxel in 0..grid.rows * grid.columns {
        let (row, column) = (taxel / grid.columns, taxel % grid.columns);
        let x = LEFT + column as f64 * CELL_PX;
        // Skin files count rows towards the end effector.
        let y = TOP + (grid.rows - 1 - row) as f64 * CELL_PX;
        let _ = writeln!(
            svg,
            "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{CELL_PX}\" height=\"{CELL_PX}\" fill=\"#ffffff\" stroke=\"#d0d5da\"/>"
        );
        if let Some(verdict) = verdicts.get(&taxel) {
            let (colour, mark) = mark_of(verdict, pressed.contains(&taxel));
            svg += &mark.svg(x + CELL_PX / 2.0, y + CELL_PX / 2.0, 8.0, colour);
        }
    }
    let _ = writeln!(
        svg,
        "<text x=\"{LEFT}\" y=\"{:.1}\">columns, around the forearm</text>\
         <text transform=\"translate(20 {TOP}) rotate(-90)\" text-anchor=\"end\">hand</text>\
         <text transform=\"translate(20 {:.1}) rotate(-90)\">elbow</text>\n</svg>",
        height - 8.0,
        TOP + grid.rows as f64 * CELL_PX
    );
    svg
}

fn legend(svg: &mut String) {
    let mut x = LEFT;
    for (label, verdict, pressed) in [
        ("leaf", Verdict::Category("leaf".into()), true),
        ("trunk", Verdict::Category("trunk".into()), true),
        ("outlier", Verdict::Outlier, true),
        ("uncertain", Verdict::Uncertain, true),
        ("untouched", Verdict::Uncertain, false),
    ] {
        let (colour, mark) = mark_of(&verdict, pressed);
        // Any shape can be grey.
        let marks = match pressed {
            true => mark.svg(x + 4.0, 35.0, 7.0, colour),
            false => Mark::Square.svg(x + 4.0, 35.0, 7.0, colour),
        };
        let _ = writeln!(svg, "{marks}<text x=\"{:.1}\" y=\"40\">{label}</text>", x + 16.0);
        x += 32.0 + 8.4 * label.len() as f64;
    }
}
