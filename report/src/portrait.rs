//! Pictures of how objects press on the skin, as SVG: the unrolled forearm under each object with its depth, and the
//! loading loop of a foam roll.

use std::fmt::Write;

use crate::drawing::{Axis, Dash, Layer, Shape, Style, chart, escape, svg_document};
use underbrush_validation::{Portrait, Section};

const CELL_PX: f64 = 24.0;
const MARGIN: f64 = 12.0;
/// Font size, px. A picture of 24 columns is 600 px wide, so text of this size is still 10 px tall on a phone.
const FONT: f64 = 16.0;
const LINE: f64 = 24.0;
/// Scale of the sections, px per metre.
const SECTION_PX_PER_M: f64 = 8000.0;
/// Height of a section above and below the skin's surface, px.
const ABOVE: f64 = 60.0;
const BELOW: f64 = 40.0;
/// Thickness of Cody's skin, m.
const SKIN_M: f64 = 0.003;
/// Steps of the legend's scale, as shares of the largest force.
const SHARES: [f64; 5] = [0.0, 0.05, 0.25, 0.5, 1.0];

/// Fill colour and text colour of a cell. The fill goes from white to dark blue with the square root of the share, so
/// that weakly pressed taxels stay visible.
fn shade(share: f64) -> (String, &'static str) {
    let share = share.clamp(0.0, 1.0).sqrt();
    let channel = |dark: f64| (255.0 + (dark - 255.0) * share) as u8;
    let fill = format!("#{:02x}{:02x}{:02x}", channel(16.0), channel(52.0), channel(110.0));
    (fill, if share > 0.6 { "#ffffff" } else { "#222222" })
}

/// The skin under each object, one below the other, with a common scale.
pub fn skin(portraits: &[Portrait]) -> String {
    let forces = portraits.iter().flat_map(|portrait| &portrait.force_n);
    // If there is no force, everything is white.
    let largest_n = forces.fold(f64::MIN_POSITIVE, |a, b| a.max(*b));
    let columns = portraits.iter().map(|portrait| portrait.grid.columns).max().unwrap_or(0);
    let width = (columns as f64 * CELL_PX + 2.0 * MARGIN).max(600.0);
    let mut body = String::new();
    let text = |body: &mut String, y: f64, weight: &str, words: &str| {
        let _ = writeln!(
            body,
            "<text x=\"{MARGIN}\" y=\"{:.1}\" font-weight=\"{weight}\">{}</text>",
            y + FONT,
            escape(words)
        );
    };
    let title = "True force on the forearm, pressed alike on each object";
    let mut y = MARGIN;
    text(&mut body, y, "bold", title);
    y += LINE;
    text(&mut body, y, "normal", "columns around the forearm to the right, rows towards the tip down;");
    y += LINE;
    text(&mut body, y, "normal", "below each, the object in the skin of 3 mm, to scale");
    y += 1.2 * LINE;
    scale(&mut body, y, largest_n);
    y += 1.6 * LINE;
    for portrait in portraits {
        let sum_n: f64 = portrait.force_n.iter().sum();
        let pressed = portrait.force_n.iter().filter(|force_n| **force_n > 0.0).count();
        let (name, depth_mm) = (portrait.name, 1e3 * portrait.depth_m);
        let words = format!("{name}: {sum_n:.2} N on {pressed} taxels, {depth_mm:.2} mm deep");
        text(&mut body, y, "bold", &words);
        y += 1.3 * LINE;
        cells(&mut body, portrait, y, largest_n);
        y += portrait.grid.rows as f64 * CELL_PX + LINE;
        section(&mut body, portrait, y, width);
        y += ABOVE + BELOW + LINE;
    }
    svg_document(width, y, FONT, title, &body)
}

/// The legend of the shades.
fn scale(body: &mut String, y: f64, largest_n: f64) {
    for (step, share) in SHARES.into_iter().enumerate() {
        let (x, fill, force_n) = (MARGIN + step as f64 * 100.0, shade(share).0, share * largest_n);
        let (beside, baseline) = (x + 26.0, y + FONT);
        let _ = writeln!(
            body,
            "<rect x=\"{x:.0}\" y=\"{y:.0}\" width=\"20\" height=\"20\" fill=\"{fill}\" stroke=\"#c8ced4\"/>\
             <text x=\"{beside:.0}\" y=\"{baseline:.0}\">{force_n:.2} N</text>"
        );
    }
}

/// The unrolled skin; a number in a cell is its force in newtons.
fn cells(body: &mut String, portrait: &Portrait, top: f64, largest_n: f64) {
    for (taxel, force_n) in portrait.force_n.iter().enumerate() {
        let x = MARGIN + (taxel % portrait.grid.columns) as f64 * CELL_PX;
        let y = top + (taxel / portrait.grid.columns) as f64 * CELL_PX;
        let (fill, ink) = shade(force_n / largest_n);
        let _ = writeln!(
            body,
            "<rect x=\"{x:.0}\" y=\"{y:.0}\" width=\"{CELL_PX}\" height=\"{CELL_PX}\" fill=\"{fill}\" \
             stroke=\"#c8ced4\" stroke-width=\"0.6\"/>"
        );
        if *force_n >= 0.005 {
            let _ = writeln!(
                body,
                "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"10\" text-anchor=\"middle\" fill=\"{ink}\">{force_n:.2}</text>",
                x + CELL_PX / 2.0,
                y + CELL_PX / 2.0 + 3.5
            );
        }
    }
}

/// The object in the undeformed skin, to scale.
fn section(body: &mut String, portrait: &Portrait, top: f64, width: f64) {
    let px = |length_m: f64| length_m * SECTION_PX_PER_M;
    let (surface, middle) = (top + ABOVE, width / 2.0);
    let lowest = surface + px(portrait.depth_m);
    let outline = match portrait.section {
        Section::Disc { radius_m } => {
            format!("<circle cx=\"{middle:.1}\" cy=\"{:.1}\" r=\"{:.1}\"", lowest - px(radius_m), px(radius_m))
        }
        Section::Bar { along_m, away_m } => {
            let (x, y, width, height) = (middle - px(along_m) / 2.0, lowest - px(away_m), px(along_m), px(away_m));
            format!("<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"")
        }
    };
    let (height, inner, skin, link) = (ABOVE + BELOW, width - 2.0 * MARGIN, px(SKIN_M), surface + px(SKIN_M));
    let _ = writeln!(
        body,
        "<svg x=\"0\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" viewBox=\"0 {top:.1} {width:.1} {height:.1}\">\
         <rect x=\"{MARGIN}\" y=\"{surface:.1}\" width=\"{inner:.1}\" height=\"{skin:.1}\" fill=\"#d9c9a3\"/>\
         <rect x=\"{MARGIN}\" y=\"{link:.1}\" width=\"{inner:.1}\" height=\"6\" fill=\"#6b7078\"/>\
         {outline} fill=\"#3f7d4e\" fill-opacity=\"0.6\" stroke=\"#1d4a28\"/></svg>"
    );
}

/// Force over displacement of a foam roll that is pushed and released, from pairs of displacement, m, and force, N.
pub fn roll_loop(points: &[(f64, f64)]) -> String {
    let farthest = (0..points.len()).max_by(|a, b| points[*a].0.total_cmp(&points[*b].0)).unwrap_or_default();
    let in_mm =
        |points: &[(f64, f64)]| Shape::Line(points.iter().map(|(way_m, force_n)| (1e3 * way_m, *force_n)).collect());
    let strongest_n = points.iter().map(|point| point.1).fold(0.0, f64::max);
    let description =
        format!("The force rises to {strongest_n:.2} N and falls along a lower path: the foam loses energy.");
    let axes = (Axis::from_zero("way of the forearm since first contact / mm"), Axis::from_zero("force / N"));
    let layers = vec![
        Layer::new("pushed", Style::line("#b23a4a", Dash::Solid), in_mm(&points[..points.len().min(farthest + 1)])),
        Layer::new("let go", Style::line("#1f4fd1", Dash::Dashed), in_mm(&points[farthest..])),
    ];
    chart("foam-roll", "A foam roll pushed and let go by the forearm", description, axes, layers)
}
