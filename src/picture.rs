//! A picture of one moment of a reach, as SVG: arm, clutter and the taxels that feel something, from the side and from
//! above.

use std::fmt::Write;

use glam::{DVec2, DVec3};
use underbrush_classifier::report::{Mark, escape};
use underbrush_recording::{Category, SkinLayout};
use underbrush_sim::geometry::Capsule;
use underbrush_sim::snapshot::Snapshot;

/// Pixels per metre.
const SCALE: f64 = 520.0;
/// Size of one panel, m.
const PANEL_M: DVec2 = DVec2::new(1.25, 1.05);
const MARGIN: f64 = 46.0;

/// Which two axes a panel shows, and from where.
struct Panel {
    title: &'static str,
    right: DVec3,
    up: DVec3,
    /// Towards the viewer: what is farther along it is drawn later.
    near: DVec3,
    /// World coordinates of the lower left corner.
    corner: DVec2,
    axes: [&'static str; 2],
}

const PANELS: [Panel; 2] = [
    Panel {
        title: "from the right",
        right: DVec3::X,
        up: DVec3::Z,
        near: DVec3::NEG_Y,
        corner: DVec2::new(-0.28, -0.68),
        axes: ["x / m", "z / m"],
    },
    Panel {
        title: "from above",
        right: DVec3::X,
        up: DVec3::Y,
        near: DVec3::Z,
        corner: DVec2::new(-0.28, -0.75),
        axes: ["x / m", "y / m"],
    },
];

/// Fill and name of each category, told apart by lightness too.
fn colour(category: Category) -> (&'static str, &'static str) {
    match category {
        Category::Leaf => ("#3a9d4f", "leaf"),
        Category::Trunk => ("#6b4423", "trunk"),
        Category::Block => ("#d9cfa8", "foam block"),
        Category::Outlier => ("#d1495b", "foam roll (outlier)"),
    }
}

/// Draws a snapshot. `caption` is one line under the picture.
pub fn draw(snapshot: &Snapshot, layout: &SkinLayout, objects: &[Category], caption: &str) -> String {
    let panel_px = PANEL_M * SCALE;
    let width = 2.0 * panel_px.x + 3.0 * MARGIN;
    let height = panel_px.y + 2.6 * MARGIN;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" \
         height=\"{height:.0}\" font-family=\"sans-serif\" font-size=\"13\">\n<title>{caption}</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
    );
    for (number, panel) in PANELS.iter().enumerate() {
        let left = MARGIN + number as f64 * (panel_px.x + MARGIN);
        let _ = writeln!(
            svg,
            "<svg x=\"{left:.0}\" y=\"{MARGIN}\" width=\"{:.0}\" height=\"{:.0}\">",
            panel_px.x, panel_px.y
        );
        let _ = writeln!(
            svg,
            "<rect width=\"100%\" height=\"100%\" fill=\"#f6f7f9\" stroke=\"#9aa3ad\"/>"
        );
        panel.shapes(&mut svg, snapshot);
        panel.felt(&mut svg, snapshot, layout, objects);
        svg.push_str("</svg>\n");
        panel.frame(&mut svg, left);
    }
    legend(&mut svg, height - 0.55 * MARGIN);
    let _ = writeln!(
        svg,
        "<text x=\"{MARGIN}\" y=\"20\" font-size=\"14\">{caption}</text>\n</svg>"
    );
    svg
}

/// A mark on a taxel.
pub struct TaxelMark {
    /// Patch and taxel.
    pub place: (usize, usize),
    /// Colour and shape.
    pub look: (&'static str, Mark),
}

/// Side lengths of a close-up, m: the forearm with what is around it.
const CLOSE_M: DVec2 = DVec2::new(0.30, 0.23);
/// Font size in a close-up, px, and the height of its title: it is shown about as wide as a page.
const CLOSE_FONT: f64 = 5.6;

/// The surroundings of marked taxels, from the right and from above; none without marks. `name` is unique on a page.
pub fn close_ups(
    name: &str,
    snapshot: &Snapshot,
    layout: &SkinLayout,
    marks: &[TaxelMark],
    description: &str,
) -> Vec<String> {
    let frame = &snapshot.frame;
    let position = |mark: &TaxelMark| {
        let taxel = layout.patches.get(mark.place.0)?.taxels.get(mark.place.1)?;
        Some(
            frame
                .patch_pose_world
                .get(mark.place.0)?
                .transform_point(taxel.position_link),
        )
    };
    let positions: Vec<(DVec3, &TaxelMark)> = marks.iter().filter_map(|mark| Some((position(mark)?, mark))).collect();
    if positions.is_empty() {
        return Vec::new();
    }
    let centre = positions.iter().map(|(position, _)| *position).sum::<DVec3>() / positions.len() as f64;
    PANELS
        .iter()
        .map(|panel| panel.close_up(name, snapshot, &positions, centre, description))
        .collect()
}

impl Panel {
    fn close_up(
        &self,
        name: &str,
        snapshot: &Snapshot,
        marks: &[(DVec3, &TaxelMark)],
        centre: DVec3,
        description: &str,
    ) -> String {
        let size = CLOSE_M * SCALE;
        let corner = self.to_pixels(centre) - size / 2.0;
        let top = 1.8 * CLOSE_FONT;
        let name = format!("{name}-{}", self.title.replace(' ', "-"));
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.1} {:.1}\" role=\"img\" \
             aria-labelledby=\"{name}-title {name}-desc\" font-family=\"sans-serif\" font-size=\"{CLOSE_FONT}\">\n\
             <title id=\"{name}-title\">Arm and skin {title}</title>\n<desc id=\"{name}-desc\">{}</desc>\n\
             <text x=\"1\" y=\"{CLOSE_FONT}\" font-weight=\"bold\">Arm and skin {title}</text>\n\
             <svg x=\"0\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" viewBox=\"{:.1} {:.1} {:.1} {:.1}\">\n\
             <rect x=\"-9999\" y=\"-9999\" width=\"29999\" height=\"29999\" fill=\"#f6f7f9\"/>\n",
            size.x,
            size.y + top,
            escape(description),
            size.x,
            size.y,
            corner.x,
            corner.y,
            size.x,
            size.y,
            title = self.title,
        );
        self.shapes(&mut svg, snapshot);
        // Those towards the viewer last.
        let mut marks: Vec<_> = marks.iter().collect();
        marks.sort_by(|a, b| a.0.dot(self.near).total_cmp(&b.0.dot(self.near)));
        for (position, mark) in marks {
            let at = self.to_pixels(*position);
            let _ = writeln!(
                svg,
                "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3\" fill=\"#ffffff\"/>",
                at.x, at.y
            );
            svg += &mark.look.1.svg(at.x, at.y, 2.3, mark.look.0);
        }
        let scale_px = 0.05 * SCALE;
        let (x, y) = (corner.x + size.x - scale_px - 6.0, corner.y + size.y - 6.0);
        // Whatever lies behind it.
        let plate = DVec2::new(scale_px + 6.0, CLOSE_FONT + 7.0);
        let _ = writeln!(
            svg,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" rx=\"2\" fill=\"#ffffff\" opacity=\"0.85\"/>",
            x - 3.0,
            y + 3.0 - plate.y,
            plate.x,
            plate.y
        );
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.1} {y:.1}h{scale_px:.1}\" stroke=\"#222222\" stroke-width=\"1.5\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">5 cm</text>",
            x + scale_px / 2.0,
            y - 3.0
        );
        svg + "</svg>\n</svg>\n"
    }

    fn to_pixels(&self, point: DVec3) -> DVec2 {
        let local = DVec2::new(point.dot(self.right), point.dot(self.up)) - self.corner;
        DVec2::new(local.x, PANEL_M.y - local.y) * SCALE
    }

    fn shapes(&self, svg: &mut String, snapshot: &Snapshot) {
        let mut shapes: Vec<(f64, String)> = Vec::new();
        let depth = |capsule: &Capsule| (capsule.start + capsule.end).dot(self.near) / 2.0;
        for (category, capsules) in &snapshot.objects {
            for capsule in capsules {
                let block = *category == Category::Block;
                // Foam lies under everything.
                let depth = if block { f64::NEG_INFINITY } else { depth(capsule) };
                let least = if *category == Category::Leaf { 2.5 } else { 0.0 };
                shapes.push((
                    depth,
                    self.line(capsule, colour(*category).0, least, if block { 0.45 } else { 0.9 }),
                ));
            }
        }
        for capsule in &snapshot.arm {
            shapes.push((depth(capsule), self.line(capsule, "#5b6b7b", 0.0, 0.75)));
        }
        shapes.sort_by(|a, b| a.0.total_cmp(&b.0));
        svg.extend(shapes.into_iter().map(|(_, shape)| shape));
    }

    /// The taxels that report a force, filled as what they touch, and the goal.
    fn felt(&self, svg: &mut String, snapshot: &Snapshot, layout: &SkinLayout, objects: &[Category]) {
        for reading in &snapshot.frame.taxels {
            let (patch, taxel) = (usize::from(reading.patch), usize::from(reading.taxel));
            let Some(place) = layout.patches.get(patch).and_then(|patch| patch.taxels.get(taxel)) else {
                continue;
            };
            if reading.sensed_force_n <= 0.0 {
                continue;
            }
            let at = self.to_pixels(snapshot.frame.patch_pose_world[patch].transform_point(place.position_link));
            let touched = reading.object.and_then(|object| objects.get(usize::from(object)));
            let fill = touched.map_or("#ffffff", |category| colour(*category).0);
            let radius = 2.0 + 3.0 * reading.sensed_force_n.sqrt();
            let _ = writeln!(
                svg,
                "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius:.1}\" fill=\"{fill}\" stroke=\"#ffd23f\" stroke-width=\"1.5\"/>",
                at.x, at.y
            );
        }
        let goal = self.to_pixels(snapshot.frame.goal_position_world);
        let _ = writeln!(
            svg,
            "<path d=\"M{0:.1} {1:.1}m-7 0h14m-7 -7v14\" stroke=\"#1f4fd1\" stroke-width=\"3\"/>",
            goal.x, goal.y
        );
    }

    fn line(&self, capsule: &Capsule, colour: &str, least: f64, opacity: f64) -> String {
        let (a, b) = (self.to_pixels(capsule.start), self.to_pixels(capsule.end));
        let thickness = (2.0 * capsule.radius_m * SCALE).max(least);
        if a.distance(b) < 1.0 {
            let radius = thickness / 2.0;
            return format!(
                "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{radius:.1}\" fill=\"{colour}\" opacity=\"{opacity}\"/>\n",
                a.x, a.y
            );
        }
        format!(
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{colour}\" stroke-width=\"{thickness:.1}\" stroke-linecap=\"round\" opacity=\"{opacity}\"/>\n",
            a.x, a.y, b.x, b.y
        )
    }

    /// Ticks every 20 cm, axis names and the title.
    fn frame(&self, svg: &mut String, left: f64) {
        let size = PANEL_M * SCALE;
        let first = |corner: f64| (corner / 0.2).ceil() as i32;
        for tick in first(self.corner.x)..=((self.corner.x + PANEL_M.x) / 0.2).floor() as i32 {
            let x = left + (f64::from(tick) * 0.2 - self.corner.x) * SCALE;
            let y = MARGIN + size.y;
            let _ = writeln!(
                svg,
                "<path d=\"M{x:.1} {y:.1}v5\" stroke=\"#555\"/><text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\" font-size=\"11\">{:.1}</text>",
                y + 17.0,
                f64::from(tick) * 0.2
            );
        }
        for tick in first(self.corner.y)..=((self.corner.y + PANEL_M.y) / 0.2).floor() as i32 {
            let y = MARGIN + size.y - (f64::from(tick) * 0.2 - self.corner.y) * SCALE;
            let _ = writeln!(
                svg,
                "<path d=\"M{left:.1} {y:.1}h-5\" stroke=\"#555\"/><text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" font-size=\"11\">{:.1}</text>",
                left - 7.0,
                y + 4.0,
                f64::from(tick) * 0.2
            );
        }
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\">{}; {} to the right, {} up</text>",
            left,
            MARGIN - 8.0,
            self.title,
            self.axes[0],
            self.axes[1]
        );
    }
}

fn legend(svg: &mut String, y: f64) {
    let mut x = MARGIN;
    let mut entry = |mark: String, text: &str| {
        let _ = writeln!(
            svg,
            "<g transform=\"translate({x:.0} {y:.0})\">{mark}<text x=\"16\" y=\"4\">{text}</text></g>"
        );
        x += 34.0 + 7.6 * text.len() as f64;
    };
    for category in Category::ALL {
        let (fill, name) = colour(category);
        entry(
            format!("<rect x=\"-2\" y=\"-6\" width=\"12\" height=\"12\" fill=\"{fill}\"/>"),
            name,
        );
    }
    entry(
        "<rect x=\"-2\" y=\"-6\" width=\"12\" height=\"12\" fill=\"#5b6b7b\"/>".into(),
        "arm",
    );
    entry(
        "<circle cx=\"4\" r=\"5\" fill=\"#ffffff\" stroke=\"#ffd23f\" stroke-width=\"1.5\"/>".into(),
        "taxel that reports a force: larger for more, filled as what it touches",
    );
    entry(
        "<path d=\"M-3 0h14m-7 -7v14\" stroke=\"#1f4fd1\" stroke-width=\"3\"/>".into(),
        "goal",
    );
}
