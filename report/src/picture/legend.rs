//! Text around a picture, wrapped to its width.

use std::collections::BTreeSet;
use std::fmt::Write;

use crate::category_looks::CategoryLooks;
use crate::drawing::escape;
use glam::DVec2;
use underbrush_recording::{Category, SkinLayout};
use underbrush_sim::snapshot::Snapshot;

use super::panel::{ARM, TABLE, TABLE_EDGE, colour, felt_at, goal_mark, taxel_mark};
use super::{FONT, LETTER, LINE};

/// A mark around the origin, and what it means.
struct Entry {
    mark: String,
    text: String,
}

fn square(fill: &str) -> String {
    format!("<rect x=\"-7\" y=\"-7\" width=\"14\" height=\"14\" fill=\"{fill}\"/>")
}

/// Every kind of mark in the picture.
fn entries(snapshot: &Snapshot, looks: &CategoryLooks, layout: &SkinLayout) -> Vec<Entry> {
    let mut entries = Vec::new();
    let mut add = |mark: String, text: &str| {
        entries.push(Entry { mark, text: text.into() });
    };
    let categories: BTreeSet<Category> = snapshot.objects.iter().map(|object| object.category).collect();
    for category in categories {
        let (fill, name) = colour(category, looks);
        add(square(fill), name);
    }
    add(square(ARM), "arm");
    add(goal_mark(DVec2::ZERO), "goal of the moment");
    add(format!("{}<path d=\"M-7 -7h14\" stroke=\"{TABLE_EDGE}\" stroke-width=\"2\"/>", square(TABLE)), "table");
    add(
        format!("<path d=\"M-8 0h16\" stroke=\"{TABLE_EDGE}\" stroke-width=\"1.5\" stroke-dasharray=\"6 4\"/>"),
        "area for the feet of objects",
    );
    let felt = || {
        let taxels = snapshot.frame.taxels.iter();
        taxels.filter(|reading| felt_at(snapshot, layout, reading).is_some())
    };
    if felt().any(|reading| reading.object.is_some()) {
        add(
            taxel_mark(DVec2::ZERO, 1.0, colour(Category::LEAF, looks).0),
            "taxel that reports a force, filled as what it touches",
        );
    }
    if felt().any(|reading| reading.object.is_none()) {
        add(taxel_mark(DVec2::ZERO, 1.0, "#ffffff"), "taxel that reports a force though it touches nothing");
    }
    if felt().next().is_some() {
        add(taxel_mark(DVec2::ZERO, 0.05, "#ffffff"), "a taxel that reports 0.05 N");
        add(taxel_mark(DVec2::ZERO, 1.0, "#ffffff"), "1 N");
        add(taxel_mark(DVec2::ZERO, 5.0, "#ffffff"), "5 N");
    }
    entries
}

/// Writes the legend, starting at `top`, and returns its height, px.
pub fn legend(
    svg: &mut String,
    (snapshot, looks): (&Snapshot, &CategoryLooks),
    layout: &SkinLayout,
    (left, width): (f64, f64),
    top: f64,
) -> f64 {
    let (mut x, mut row) = (left, 0.0);
    for Entry { mark, text } in entries(snapshot, looks, layout) {
        let wide = 42.0 + LETTER * FONT * text.chars().count() as f64;
        if x > left && x + wide > left + width {
            (x, row) = (left, row + 1.0);
        }
        let _ = writeln!(
            svg,
            "<g transform=\"translate({:.1} {:.1})\">{mark}<text x=\"16\" y=\"{:.1}\">{}</text></g>",
            x + 10.0,
            top + (row + 0.5) * LINE,
            0.35 * FONT,
            escape(&text)
        );
        x += wide;
    }
    (row + 1.0) * LINE
}

/// Writes a text in as many lines as it needs, and returns its height, px.
pub fn paragraph(svg: &mut String, text: &str, (left, width): (f64, f64), top: f64) -> f64 {
    let max_letters = (width / (LETTER * FONT)) as usize;
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let last = lines.len() - 1;
        if !lines[last].is_empty() && lines[last].chars().count() + 1 + word.chars().count() > max_letters {
            lines.push(word.to_owned());
        } else {
            let space = if lines[last].is_empty() { "" } else { " " };
            lines[last] += &format!("{space}{word}");
        }
    }
    for (row, line) in lines.iter().enumerate() {
        let y = top + row as f64 * LINE + FONT;
        let _ = writeln!(svg, "<text x=\"{left:.1}\" y=\"{y:.1}\">{}</text>", escape(line));
    }
    lines.len() as f64 * LINE
}
