//! One view of a moment: which two axes it shows, and what is drawn in it.

use std::fmt::Write;

use glam::{DVec2, DVec3};
use underbrush_recording::{Category, SkinLayout, TaxelReading};
use underbrush_sim::geometry::Capsule;
use underbrush_sim::scene::Workspace;
use underbrush_sim::snapshot::Snapshot;

use super::{FONT, blade};
use crate::category_looks::CategoryLooks;
use crate::drawing::{svg_rect, svg_text};

pub const ARM: &str = "#5b6b7b";
pub const GOAL: &str = "#1f4fd1";
pub const TABLE: &str = "#e9dfd0";
pub const TABLE_EDGE: &str = "#8a7355";
/// The rim of a taxel that reports a force.
pub const RIM: &str = "#ffd23f";

/// Which two axes a panel shows, and from where.
pub struct Panel {
    pub title: &'static str,
    right: DVec3,
    up: DVec3,
    /// Direction towards the viewer. Shapes that are farther along it are drawn later.
    near: DVec3,
    axes: [&'static str; 2],
}

pub const PANELS: [Panel; 2] = [
    Panel { title: "from the right", right: DVec3::X, up: DVec3::Z, near: DVec3::NEG_Y, axes: ["x / m", "z / m"] },
    Panel { title: "from above", right: DVec3::X, up: DVec3::Y, near: DVec3::Z, axes: ["x / m", "y / m"] },
];

/// The part of a panel's plane that is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The lower left corner, m.
    pub corner: DVec2,
    /// Width and height, m.
    pub size_m: DVec2,
    /// Pixels per metre.
    pub scale: f64,
}

impl View {
    /// Width and height, px.
    pub fn size_px(&self) -> DVec2 {
        self.size_m * self.scale
    }
}

/// A shape of arm or clutter on a panel.
pub struct Outline {
    /// Position along the direction towards the viewer, m.
    pub depth: f64,
    /// The `d` of its path.
    pub path: String,
    /// The other attributes of its path.
    pub style: String,
}

/// Fill colour and name of a category. The colours differ in lightness, too.
pub fn colour(category: Category, looks: &CategoryLooks) -> (&'static str, &'static str) {
    match category {
        Category::LEAF => ("#3a9d4f", "leaf"),
        Category::TRUNK => ("#6b4423", "trunk"),
        Category::BLOCK => ("#c9b97f", "foam block"),
        Category::OUTLIER => ("#d1495b", "outlier"),
        further => (looks.look(further.name()).colour, further.name()),
    }
}

/// Radius of a taxel's mark, px.
fn radius_px(force_n: f64) -> f64 {
    2.0 + 3.0 * force_n.sqrt()
}

/// A taxel that reports a force.
pub fn taxel_mark(at: DVec2, force_n: f64, fill: &str) -> String {
    format!(
        "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"{:.1}\" fill=\"{fill}\" stroke=\"{RIM}\" stroke-width=\"1.5\"/>",
        at.x,
        at.y,
        radius_px(force_n)
    )
}

pub fn goal_mark(at: DVec2) -> String {
    format!("<path d=\"M{:.1} {:.1}m-7 0h14m-7 -7v14\" stroke=\"{GOAL}\" stroke-width=\"3\"/>", at.x, at.y)
}

/// Position of a taxel in the world frame, m; `None` if it is not drawn because it reports no force.
pub fn felt_at(snapshot: &Snapshot, layout: &SkinLayout, reading: &TaxelReading) -> Option<DVec3> {
    let (patch, taxel) = (usize::from(reading.patch), usize::from(reading.taxel));
    let taxel = layout.patches.get(patch)?.taxels.get(taxel)?;
    let pose = snapshot.frame.patch_pose_world.get(patch)?;
    (reading.sensed_force_n > 0.0).then(|| pose.transform_point(taxel.position_link))
}

impl Panel {
    /// A point on the panel's plane, m.
    pub fn project(&self, point: DVec3) -> DVec2 {
        DVec2::new(point.dot(self.right), point.dot(self.up))
    }

    /// The direction in space of one on the panel's plane.
    pub fn direction(&self, flat: DVec2) -> DVec3 {
        self.right * flat.x + self.up * flat.y
    }

    /// A point in pixels from the view's upper left corner.
    pub fn to_pixels(&self, view: &View, point: DVec3) -> DVec2 {
        let local = self.project(point) - view.corner;
        DVec2::new(local.x, view.size_m.y - local.y) * view.scale
    }

    /// Position of a point along the direction towards the viewer, m.
    pub fn depth(&self, point: DVec3) -> f64 {
        point.dot(self.near)
    }

    /// Draws the table: seen from the side, everything below its top; from above, the area for the feet of objects.
    pub fn table(&self, svg: &mut String, view: &View, workspace: &Workspace) {
        let size = view.size_px();
        if self.up == DVec3::Z {
            let top = self.to_pixels(view, DVec3::Z * workspace.table_height_m).y;
            let _ = writeln!(
                svg,
                "<rect x=\"0\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"{TABLE}\"/>\
                 <path d=\"M0 {top:.1}h{:.1}\" stroke=\"{TABLE_EDGE}\" stroke-width=\"2\"/>",
                size.x,
                (size.y - top).max(0.0),
                size.x
            );
            return;
        }
        let corner = |x: usize, y: usize| {
            let point = DVec3::new(workspace.x_m[x], workspace.y_m[y], workspace.table_height_m);
            self.to_pixels(view, point)
        };
        let (low, high) = (corner(0, 1), corner(1, 0));
        let edge = format!("fill=\"none\" stroke=\"{TABLE_EDGE}\" stroke-width=\"1.5\" stroke-dasharray=\"6 4\"");
        let area = svg_rect(low.into(), (high - low).into(), &edge);
        let _ = writeln!(svg, "<rect width=\"100%\" height=\"100%\" fill=\"{TABLE}\"/>\n{area}");
    }

    /// Draws arm and objects, nearest to the viewer last.
    pub fn shapes(&self, svg: &mut String, view: &View, snapshot: &Snapshot, looks: &CategoryLooks) {
        let mut shapes = self.outlines(view, snapshot, looks);
        shapes.sort_by(|a, b| a.depth.total_cmp(&b.depth));
        for shape in shapes {
            let _ = writeln!(svg, "<path d=\"{}\" {}/>", shape.path, shape.style);
        }
    }

    /// Every shape of arm and objects as a path. Their number and order are the same for all snapshots of a reach.
    pub fn outlines(&self, view: &View, snapshot: &Snapshot, looks: &CategoryLooks) -> Vec<Outline> {
        let depth = |capsule: &Capsule| self.depth(capsule.start + capsule.end) / 2.0;
        let mut outlines = Vec::new();
        for object in &snapshot.objects {
            let fill = colour(object.category, looks).0;
            let block = object.category == Category::BLOCK;
            for capsule in &object.capsules {
                // Foam is drawn under everything else.
                let depth = if block { f64::NEG_INFINITY } else { depth(capsule) };
                let opacity = if block { 0.45 } else { 0.9 };
                outlines.push(self.line(view, capsule, fill, opacity, depth));
            }
            for blade in &object.blades {
                let middle = blade.pieces.iter().map(|piece| self.depth(piece.pose_world.position));
                outlines.push(Outline {
                    depth: middle.sum::<f64>() / blade.pieces.len() as f64,
                    path: blade::path(blade, |point| self.to_pixels(view, point)),
                    // Seen from its edge, a blade has no area, so it needs a stroke.
                    style: format!(
                        "fill=\"{fill}\" stroke=\"{fill}\" stroke-width=\"2\" stroke-linejoin=\"round\" opacity=\"0.9\""
                    ),
                });
            }
        }
        let arm = snapshot.arm.iter();
        outlines.extend(arm.map(|capsule| self.line(view, capsule, ARM, 0.75, depth(capsule))));
        outlines
    }

    /// Draws the taxels that report a force, in the colour of what they touch, and the goal.
    pub fn felt(
        &self,
        svg: &mut String,
        view: &View,
        (snapshot, looks): (&Snapshot, &CategoryLooks),
        layout: &SkinLayout,
        objects: &[Category],
    ) {
        for reading in &snapshot.frame.taxels {
            let Some(position) = felt_at(snapshot, layout, reading) else {
                continue;
            };
            let touched = reading.object.and_then(|object| objects.get(usize::from(object)));
            let fill = touched.map_or("#ffffff", |category| colour(*category, looks).0);
            *svg += &taxel_mark(self.to_pixels(view, position), reading.sensed_force_n, fill);
            svg.push('\n');
        }
        *svg += &goal_mark(self.to_pixels(view, snapshot.frame.goal_position_world));
        svg.push('\n');
    }

    /// A capsule as a thick line with round ends; a line without length is a disc.
    fn line(&self, view: &View, capsule: &Capsule, colour: &str, opacity: f64, depth: f64) -> Outline {
        let (a, b) = (self.to_pixels(view, capsule.start), self.to_pixels(view, capsule.end));
        let thickness = 2.0 * capsule.radius_m * view.scale;
        Outline {
            depth,
            path: format!("M{:.1} {:.1}L{:.1} {:.1}", a.x, a.y, b.x, b.y),
            style: format!(
                "fill=\"none\" stroke=\"{colour}\" stroke-width=\"{thickness:.1}\" stroke-linecap=\"round\" opacity=\"{opacity}\""
            ),
        }
    }

    /// Ticks, axis names and the title, around a view whose upper left corner is at `at`.
    pub fn axes(&self, svg: &mut String, view: &View, at: DVec2) {
        let size = view.size_px();
        // A number needs about 45 px.
        let step = if 0.2 * view.scale >= 45.0 { 0.2 } else { 0.5 };
        let ticks = |from: f64, length: f64| {
            let (first, last) = ((from / step - 1e-9).ceil() as i32, ((from + length) / step + 1e-9).floor() as i32);
            (first..=last).map(move |tick| f64::from(tick) * step)
        };
        for tick in ticks(view.corner.x, view.size_m.x) {
            let (x, y) = (at.x + (tick - view.corner.x) * view.scale, at.y + size.y);
            let text = svg_text(x, y + FONT + 5.0, " text-anchor=\"middle\"", &format!("{tick:.1}"));
            let _ = writeln!(svg, "<path d=\"M{x:.1} {y:.1}v5\" stroke=\"#555\"/>{text}");
        }
        for tick in ticks(view.corner.y, view.size_m.y) {
            let y = at.y + size.y - (tick - view.corner.y) * view.scale;
            let text = svg_text(at.x - 8.0, y + 0.35 * FONT, " text-anchor=\"end\"", &format!("{tick:.1}"));
            let _ = writeln!(svg, "<path d=\"M{:.1} {y:.1}h-5\" stroke=\"#555\"/>{text}", at.x);
        }
        let title = format!("{}; {} to the right, {} up", self.title, self.axes[0], self.axes[1]);
        let _ = writeln!(svg, "{}", svg_text(at.x, at.y - 8.0, " font-weight=\"bold\"", &title));
    }
}
