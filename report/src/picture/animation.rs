//! A reach as a picture that moves: moments in a loop, as an SVG with SMIL animations, which browsers also play in
//! `<img>`.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::category_looks::CategoryLooks;
use crate::drawing::svg_document;
use underbrush_recording::{Category, SkinLayout};
use underbrush_sim::scene::Workspace;
use underbrush_sim::snapshot::Snapshot;

use super::panel::{GOAL, Panel, RIM, View, colour, felt_at};
use super::{FONT, LEFT, LINE, RIGHT, WIDTH, legend, panels, views};

/// Largest size of the file, bytes, for use in a README.
const MAX_BYTES: usize = 900_000;
/// Largest number of moments. Choice: a loop of nine seconds with ten moments a second.
const MAX_MOMENTS: usize = 90;
/// A moment is shown for this long, s, and the last one for `HOLD` moments, so that the end of the loop can be seen.
const MOMENT_S: f64 = 0.1;
const HOLD: usize = 10;

/// Draws these moments of a reach one after the other. It takes as many of them, evenly spaced, as fit into a file of
/// 0.9 MB, but 90 at most. `None` if there are no moments.
pub fn animate(
    snapshots: &[Snapshot],
    layout: &SkinLayout,
    objects: &[Category],
    workspace: &Workspace,
    caption: &str,
) -> Option<String> {
    let mut count = snapshots.len().min(MAX_MOMENTS);
    loop {
        let chosen = evenly(snapshots, count);
        let svg = draw(&chosen, layout, objects, workspace, caption)?;
        if svg.len() <= MAX_BYTES || count <= 2 {
            return Some(svg);
        }
        count = (count * 3 / 4).max(2);
    }
}

/// `count` evenly spaced snapshots, including the first and the last.
fn evenly(snapshots: &[Snapshot], count: usize) -> Vec<Snapshot> {
    let (last, steps) = (snapshots.len().saturating_sub(1), count.saturating_sub(1).max(1));
    (0..count).map(|step| snapshots[step * last / steps].clone()).collect()
}

fn draw(
    snapshots: &[Snapshot],
    layout: &SkinLayout,
    objects: &[Category],
    workspace: &Workspace,
    caption: &str,
) -> Option<String> {
    let fullest = snapshots.iter().max_by_key(|snapshot| snapshot.frame.taxels.len())?;
    let looks = CategoryLooks::of(objects.iter().map(|category| category.name()));
    let times: Vec<f64> = snapshots.iter().map(|snapshot| snapshot.frame.time_s).collect();
    let mut body = String::new();
    let mut y = 8.0;
    y += legend::paragraph(&mut body, caption, (8.0, WIDTH - 16.0), y);
    y += clock(&mut body, &times, y);
    y += legend::legend(&mut body, (fullest, &looks, false), layout, (8.0, WIDTH - 16.0), y) + LINE;
    let views = views(snapshots, workspace, WIDTH - LEFT - RIGHT);
    let height = panels(&mut body, y, views, Some(workspace), |body, panel, view| {
        shapes(body, panel, view, snapshots, &looks);
        felt(body, panel, view, snapshots, (layout, objects), &looks);
    });
    Some(svg_document(WIDTH, height, FONT, caption, &body))
}

/// A bar that fills as the reach proceeds, with its length in seconds; returns its height, px.
fn clock(svg: &mut String, times: &[f64], top: f64) -> f64 {
    let (first, last) = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(0.0));
    let width = 0.6 * WIDTH;
    let paths: Vec<String> = times
        .iter()
        .map(|time_s| format!("M8 0H{:.1}", 8.0 + width * (time_s - first) / (last - first).max(1e-9)))
        .collect();
    let _ = writeln!(
        svg,
        "<g transform=\"translate(0 {:.1})\"><path d=\"M8 0h{width:.1}\" stroke=\"#d5dae0\" stroke-width=\"6\"/>",
        top + LINE / 2.0
    );
    moving(svg, &paths, &format!("stroke=\"{GOAL}\" stroke-width=\"6\""));
    let _ = writeln!(svg, "<text x=\"{:.1}\" y=\"{:.1}\">{:.1} s</text></g>", width + 18.0, 0.35 * FONT, last - first);
    LINE + 8.0
}

/// Draws arm and objects, nearest to the viewer last. They are sorted by their mean depth, because their order is the
/// same at all moments.
fn shapes(svg: &mut String, panel: &Panel, view: &View, snapshots: &[Snapshot], looks: &CategoryLooks) {
    let moments: Vec<_> = snapshots.iter().map(|snapshot| panel.outlines(view, snapshot, looks)).collect();
    let count = moments.first().map_or(0, Vec::len);
    let depth = |shape: usize| moments.iter().map(|moment| moment[shape].depth).sum::<f64>();
    let mut order: Vec<(f64, usize)> = (0..count).map(|shape| (depth(shape), shape)).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (_, shape) in order {
        let paths: Vec<String> = moments.iter().map(|moment| moment[shape].path.clone()).collect();
        moving(svg, &paths, &moments[0][shape].style);
    }
}

/// Draws the taxels that report a force as dots in the colour of what they touch, and the goal.
fn felt(
    svg: &mut String,
    panel: &Panel,
    view: &View,
    snapshots: &[Snapshot],
    (layout, objects): (&SkinLayout, &[Category]),
    looks: &CategoryLooks,
) {
    let mut dots: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for (moment, snapshot) in snapshots.iter().enumerate() {
        for reading in &snapshot.frame.taxels {
            let Some(position) = felt_at(snapshot, layout, reading) else {
                continue;
            };
            let touched = reading.object.and_then(|object| objects.get(usize::from(object)));
            let fill = touched.map_or("#ffffff", |category| colour(*category, looks).0);
            let at = panel.to_pixels(view, position);
            let paths = dots.entry(fill).or_insert_with(|| vec![String::new(); snapshots.len()]);
            let _ = write!(paths[moment], "M{:.1} {:.1}h0", at.x, at.y);
        }
    }
    let round = "fill=\"none\" stroke-linecap=\"round\"";
    // All rims lie under all dots, so that neighbouring taxels do not hide each other.
    for (width, of_fill) in [(8.5, false), (5.5, true)] {
        for (fill, paths) in &dots {
            let stroke = if of_fill { fill } else { RIM };
            moving(svg, paths, &format!("{round} stroke=\"{stroke}\" stroke-width=\"{width}\""));
        }
    }
    let goals = snapshots.iter().map(|snapshot| {
        let at = panel.to_pixels(view, snapshot.frame.goal_position_world);
        format!("M{:.1} {:.1}m-7 0h14m-7 -7v14", at.x, at.y)
    });
    moving(svg, &goals.collect::<Vec<_>>(), &format!("stroke=\"{GOAL}\" stroke-width=\"3\""));
}

/// Draws a path that has these values of `d`, one for each moment. Moments at which nothing changes are left out.
fn moving(svg: &mut String, paths: &[String], style: &str) {
    let Some(first) = paths.first() else { return };
    // An empty path is not a valid value. A path that only moves draws nothing.
    let value = |path: &str| {
        if path.is_empty() { "M0 0".to_owned() } else { path.to_owned() }
    };
    let mut changes: Vec<(usize, String)> = Vec::new();
    for (moment, path) in paths.iter().enumerate() {
        if changes.last().is_none_or(|(_, last)| *last != value(path)) {
            changes.push((moment, value(path)));
        }
    }
    if changes.len() < 2 {
        if !first.is_empty() {
            let _ = writeln!(svg, "<path d=\"{first}\" {style}/>");
        }
        return;
    }
    let moments = paths.len() + HOLD;
    let times: Vec<String> =
        changes.iter().map(|(moment, _)| format!("{:.4}", *moment as f64 / moments as f64)).collect();
    let values: Vec<&str> = changes.iter().map(|(_, path)| path.as_str()).collect();
    let _ = writeln!(
        svg,
        "<path d=\"{}\" {style}><animate attributeName=\"d\" calcMode=\"discrete\" dur=\"{:.1}s\" \
         repeatCount=\"indefinite\" keyTimes=\"{}\" values=\"{}\"/></path>",
        value(first),
        MOMENT_S * moments as f64,
        times.join(";"),
        values.join(";")
    );
}
