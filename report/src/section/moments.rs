//! One moment of a general reach and of an outlier reach, with the verdicts on their taxels (Figs. 12 and 14): a picture, and the
//! unrolled skin with a mark for the verdict on each taxel in contact.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use underbrush_classifier::decision::Verdict;
use underbrush_classifier::frequencies;
use underbrush_experiments::experiment::moments::{Moment, ReachMoments};
use underbrush_recording::{Grid, Recording};
use underbrush_render::{RenderError, Size};

use crate::drawing::{LETTER, squeezed, svg_head, svg_text};
use crate::style::UNTOUCHED;
use crate::{CategoryLooks, Mark, Report, escape, joined, replayed, slug};

/// As wide as half the page on a screen with two pixels for one.
const SIZE: Size = Size { width: 960, height: 640 };

/// Adds the section.
pub fn add(report: &mut Report, outcome: &ReachMoments) {
    if outcome.all().next().is_none() {
        return;
    }
    report.section("moments", "moments of reaches");
    for (place, moment) in outcome.all().enumerate() {
        add_moment(report, moment, place);
    }
}

/// The address of a moment on the replay page.
pub fn address(moment: &Moment, place: usize) -> String {
    let patch = moment.recording.layout.patches.get(moment.patch);
    let pressed = moment.verdicts.keys().find(|taxel| moment.pressed.contains(taxel));
    let taxel = patch.zip(pressed).map(|(patch, taxel)| (patch.name.as_str(), *taxel));
    replayed::moment(replayed::TEST_FILE, place, moment.frame().time_s, taxel)
}

fn add_moment(report: &mut Report, moment: &Moment, place: usize) {
    let Some(patch) = moment.recording.layout.patches.get(moment.patch) else { return };
    let Some(grid) = patch.grid else { return };
    let looks = &report.looks;
    let Moment { verdicts, pressed, .. } = moment;
    let Recording { scene, reach_index, .. } = &moment.recording;
    let (time_s, taxels) = (moment.frame().time_s, verdicts.len());
    let labels = report.results.definition.labels();
    let skin = format!("moment-{place}-skin");
    let charts = [image(moment, place), skin_map(&skin, (&patch.name, grid), (&labels, looks), verdicts, pressed)];
    let untouched = verdicts.keys().filter(|taxel| !pressed.contains(taxel)).count();
    let caption = format!(
        "Scene {scene}, draw {reach_index}, {time_s:.2} s after the start: the moment with the most taxels in contact. The \
         picture shows sensed forces as colours of the skin and the forces of contacts as arrows, and the map of the skin \
         shows the verdicts. Grey marks are untouched taxels (spurious readings, creep, crosstalk): {untouched} of {taxels} here."
    );
    report.page.figure(&caption, &charts);
    report.page.link(&address(moment, place), "Replay this moment in 3-D");
}

/// A moment's picture on the page.
pub fn image(moment: &Moment, place: usize) -> String {
    let Size { width, height } = SIZE;
    let (file, scene) = (file(moment, place), escape(&moment.recording.scene));
    format!(
        "<img src=\"{file}\" width=\"{width}\" height=\"{height}\" alt=\"The arm among the clutter of scene {scene}\"/>"
    )
}

/// The file of a moment's picture, beside the page.
fn file(moment: &Moment, place: usize) -> String {
    format!("moment-{place}-{}.png", slug(&moment.recording.scene))
}

/// The pictures of all moments: files beside the page, with their names.
///
/// # Errors
/// If one cannot be drawn.
pub fn pictures(outcome: &ReachMoments) -> Result<Vec<(String, Vec<u8>)>, RenderError> {
    let drawn = |(place, moment): (usize, &Moment)| {
        Ok((file(moment, place), replayed::png(&moment.recording, moment.frame_index, SIZE, None)?))
    };
    outcome.all().enumerate().map(drawn).collect()
}

/// Colour and shape of a verdict: the paper's colours, with a shape for readers who cannot distinguish them. An
/// untouched taxel keeps the shape of its verdict and is grey.
fn mark_of(looks: &CategoryLooks, verdict: &str, pressed: bool) -> (&'static str, Mark) {
    let look = looks.look(verdict);
    (if pressed { look.colour } else { UNTOUCHED }, look.mark)
}

const CELL_PX: f64 = 21.0;
const LEFT: f64 = 30.0;
/// Least width of the drawing, px: the legend has room for the longest name of a category, 24 letters.
const NARROWEST: f64 = 264.0;
/// Baseline of the legend's first row, and the height of a row.
const LEGEND: f64 = 40.0;
const LEGEND_ROW: f64 = 22.0;

/// Draws the taxels of the moment's patch: rows along the forearm, the hand at the top, and columns around it from left
/// to right. The legend has the `labels` that a classifier can give. `name` is unique on a page.
pub fn skin_map(
    name: &str,
    (patch, grid): (&str, Grid),
    (labels, looks): (&[&str], &CategoryLooks),
    verdicts: &BTreeMap<usize, Verdict>,
    pressed: &BTreeSet<usize>,
) -> String {
    let width = (LEFT + grid.columns as f64 * CELL_PX + 6.0).max(NARROWEST);
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
    let (around, bottom) = (format!("columns, around the {patch}"), top + grid.rows as f64 * CELL_PX);
    let below = svg_text(LEFT, height - 8.0, &squeezed(&around, LETTER, width - LEFT), &around);
    let _ = writeln!(
        svg,
        "{below}<text transform=\"translate(20 {top}) rotate(-90)\" text-anchor=\"end\">hand</text>\
         <text transform=\"translate(20 {bottom:.1}) rotate(-90)\">elbow</text>\n</svg>"
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
