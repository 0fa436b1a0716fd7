//! Pictures of what objects do to the skin, as SVG: the unrolled forearm under each, and a foam roll's loop.

use std::fmt::Write;

use underbrush_validation::Portrait;

const CELL_PX: f64 = 22.0;
const MARGIN: f64 = 46.0;

fn begin(width: f64, height: f64, title: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" \
         height=\"{height:.0}\" font-family=\"sans-serif\" font-size=\"13\">\n<title>{title}</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n<text x=\"{MARGIN}\" y=\"20\" \
         font-size=\"14\">{title}</text>\n"
    )
}

/// White to dark blue, by the square root of the share: weak taxels stay visible.
fn shade(share: f64) -> (String, &'static str) {
    let share = share.clamp(0.0, 1.0).sqrt();
    let channel = |dark: f64| (255.0 + (dark - 255.0) * share) as u8;
    let fill = format!("#{:02x}{:02x}{:02x}", channel(16.0), channel(52.0), channel(110.0));
    (fill, if share > 0.6 { "#ffffff" } else { "#222222" })
}

/// The skin under each object, side by side, all on one scale.
pub fn skin(portraits: &[Portrait]) -> String {
    let largest = portraits
        .iter()
        .flat_map(|portrait| &portrait.force_n)
        .fold(0.0_f64, |a, b| a.max(*b));
    let panel_width = |portrait: &Portrait| portrait.grid.columns as f64 * CELL_PX;
    let rows = portraits.iter().map(|portrait| portrait.grid.rows).max().unwrap_or(0) as f64;
    let width = MARGIN
        + portraits
            .iter()
            .map(|portrait| panel_width(portrait) + MARGIN)
            .sum::<f64>();
    let height = rows * CELL_PX + 2.6 * MARGIN;
    let mut svg = begin(
        width,
        height,
        "True normal force on the forearm's taxels, N, pressed alike on three objects",
    );
    let mut left = MARGIN;
    for portrait in portraits {
        let sum: f64 = portrait.force_n.iter().sum();
        let lit = portrait.force_n.iter().filter(|force| **force > 0.0).count();
        let _ = writeln!(
            svg,
            "<text x=\"{left:.0}\" y=\"{:.0}\">{}: {sum:.2} N on {lit} taxels</text>",
            MARGIN - 6.0,
            portrait.name
        );
        for (taxel, force) in portrait.force_n.iter().enumerate() {
            let x = left + (taxel % portrait.grid.columns) as f64 * CELL_PX;
            let y = MARGIN + (taxel / portrait.grid.columns) as f64 * CELL_PX;
            let (fill, ink) = shade(force / largest);
            let _ = writeln!(
                svg,
                "<rect x=\"{x:.0}\" y=\"{y:.0}\" width=\"{CELL_PX}\" height=\"{CELL_PX}\" fill=\"{fill}\" \
                 stroke=\"#c8ced4\" stroke-width=\"0.6\"/>"
            );
            if *force >= 0.005 {
                let _ = writeln!(
                    svg,
                    "<text x=\"{:.1}\" y=\"{:.1}\" font-size=\"9\" text-anchor=\"middle\" fill=\"{ink}\">{force:.2}</text>",
                    x + CELL_PX / 2.0,
                    y + CELL_PX / 2.0 + 3.0
                );
            }
        }
        let _ = writeln!(
            svg,
            "<text x=\"{left:.0}\" y=\"{:.0}\" font-size=\"11\">columns, around the forearm, to the right; rows, towards \
             the tip, down</text>",
            MARGIN + rows * CELL_PX + 18.0
        );
        left += panel_width(portrait) + MARGIN;
    }
    svg + "</svg>\n"
}

/// Force over way of a foam roll that is pushed and let go.
pub fn roll_loop(points: &[(f64, f64)]) -> String {
    let (width, height) = (560.0, 420.0);
    let most = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).fold(0.0, f64::max);
    let (far_m, strong_n) = (most(|point| point.0).max(1e-6), most(|point| point.1).max(1e-6));
    let place = |way_m: f64, force_n: f64| {
        let x = MARGIN + way_m / far_m * (width - 2.0 * MARGIN);
        (x, height - MARGIN - force_n / strong_n * (height - 2.5 * MARGIN))
    };
    let mut svg = begin(width, height, "A foam roll pushed and let go by the forearm");
    let turn = points
        .iter()
        .enumerate()
        .max_by(|a, b| a.1.0.total_cmp(&b.1.0))
        .map_or(0, |(index, _)| index);
    for (part, colour) in [
        (&points[..=turn.min(points.len() - 1)], "#d1495b"),
        (&points[turn..], "#1f4fd1"),
    ] {
        let line: Vec<String> = part
            .iter()
            .map(|(way, force)| {
                let (x, y) = place(*way, *force);
                format!("{x:.1},{y:.1}")
            })
            .collect();
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"/>",
            line.join(" ")
        );
    }
    for step in 0..=4 {
        let share = f64::from(step) / 4.0;
        let (x, bottom) = place(far_m * share, 0.0);
        let (start, y) = place(0.0, strong_n * share);
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.1} {bottom:.1}v5M{start:.1} {y:.1}h-5\" stroke=\"#555\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-size=\"11\">{:.1}</text>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" font-size=\"11\">{:.2}</text>",
            bottom + 17.0,
            1e3 * far_m * share,
            start - 7.0,
            y + 4.0,
            strong_n * share
        );
    }
    let (left, bottom) = place(0.0, 0.0);
    let (right, top) = place(far_m, strong_n);
    let _ = writeln!(
        svg,
        "<path d=\"M{left:.1} {top:.1}V{bottom:.1}H{right:.1}\" fill=\"none\" stroke=\"#555\"/>\
         <text x=\"{left:.1}\" y=\"{:.1}\" font-size=\"11\">force / N; way of the forearm since first contact / mm; \
         red in, blue out</text>",
        top - 10.0
    );
    svg + "</svg>\n"
}
