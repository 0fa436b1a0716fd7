//! Pictures of one moment of a reach, as SVG: arm, clutter and the taxels that feel something, from the side and from
//! above. `draw` shows the whole scene, `close_ups` the surroundings of marked taxels, and `still` an arm alone, with all its
//! taxels.

mod blade;
mod close_up;
mod legend;
mod panel;
mod still;

use std::fmt::Write;

use crate::category_looks::CategoryLooks;
use crate::drawing::svg_document;
use glam::{DVec2, DVec3};
use underbrush_recording::{Category, SkinLayout};
use underbrush_sim::scene::Workspace;
use underbrush_sim::snapshot::Snapshot;

pub use close_up::{TaxelMark, close_ups};
use panel::{PANELS, Panel, View};
pub use still::still;

/// Font size, px. On a phone, where a picture is 390 px wide, text of this size is still 10 px tall.
const FONT: f64 = 16.0;
const LINE: f64 = 24.0;
/// Mean width of a letter of a sans-serif font, relative to the font size.
const LETTER: f64 = 0.54;
/// Width of the picture and of its margins, px.
const WIDTH: f64 = 640.0;
const LEFT: f64 = 52.0;
const RIGHT: f64 = 12.0;
/// Largest height of a panel, px, so that a tall arm does not make the picture a narrow strip.
const MAX_HEIGHT: f64 = 900.0;
/// Empty space around arm and objects, m.
const SPACE_M: f64 = 0.05;

/// Draws a snapshot with a caption.
pub fn draw(
    snapshot: &Snapshot,
    layout: &SkinLayout,
    objects: &[Category],
    workspace: &Workspace,
    caption: &str,
) -> String {
    let looks = CategoryLooks::of(objects.iter().map(|category| category.name()));
    let mut body = String::new();
    let mut y = 8.0;
    y += legend::paragraph(&mut body, caption, (8.0, WIDTH - 16.0), y);
    y += legend::legend(&mut body, (snapshot, &looks), layout, (8.0, WIDTH - 16.0), y) + LINE;
    let views = views(snapshot, workspace, WIDTH - LEFT - RIGHT);
    let height = panels(&mut body, y, views, Some(workspace), |body, panel, view| {
        panel.shapes(body, view, snapshot, &looks);
        panel.felt(body, view, (snapshot, &looks), layout, objects);
    });
    svg_document(WIDTH, height, FONT, caption, &body)
}

/// Draws both panels, the first one `y` px from the top, with what `content` draws on the table, if there is one. Returns
/// the height of the picture, px.
fn panels(
    body: &mut String,
    mut y: f64,
    views: Vec<View>,
    workspace: Option<&Workspace>,
    content: impl Fn(&mut String, &Panel, &View),
) -> f64 {
    for (panel, view) in PANELS.iter().zip(views) {
        let size = view.size_px();
        let _ = writeln!(
            body,
            "<svg x=\"{LEFT}\" y=\"{y:.1}\" width=\"{:.1}\" height=\"{:.1}\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#f6f7f9\"/>",
            size.x, size.y
        );
        if let Some(workspace) = workspace {
            panel.table(body, &view, workspace);
        }
        content(body, panel, &view);
        *body += "<rect width=\"100%\" height=\"100%\" fill=\"none\" stroke=\"#9aa3ad\" stroke-width=\"2\"/>\n</svg>\n";
        panel.axes(body, &view, DVec2::new(LEFT, y));
        y += size.y + 3.0 * LINE;
    }
    y - LINE
}

/// The view of each panel. It contains arm, objects, goal and workspace, and its edges are rounded outwards to 10 cm. Both panels have the same scale and the same x axis.
fn views(snapshot: &Snapshot, workspace: &Workspace, width_px: f64) -> Vec<View> {
    let mut points = extent(snapshot);
    for (x, y) in [(0, 0), (1, 1)] {
        let corner = DVec3::new(workspace.x_m[x], workspace.y_m[y], workspace.table_height_m);
        points.push((corner, 0.0));
    }
    views_of(&points, width_px)
}

/// The view of each panel that contains points, each with the radius of the shape around it, m.
fn views_of(points: &[(DVec3, f64)], width_px: f64) -> Vec<View> {
    let bounds = |panel: &Panel| {
        let ends = points.iter().map(|(point, radius_m)| {
            let (at, around) = (panel.project(*point), DVec2::splat(radius_m + SPACE_M));
            (at - around, at + around)
        });
        let (low, high) =
            ends.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), end| (low.min(end.0), high.max(end.1)));
        let corner = (10.0 * low).floor() / 10.0;
        (corner, (10.0 * high).ceil() / 10.0 - corner)
    };
    let bounds: Vec<(DVec2, DVec2)> = PANELS.iter().map(bounds).collect();
    let tallest = bounds.iter().map(|(_, size_m)| size_m.y).fold(0.0, f64::max);
    let widest = bounds.iter().map(|(_, size_m)| size_m.x).fold(0.0, f64::max);
    let scale = (width_px / widest).min(MAX_HEIGHT / tallest);
    let view = |(corner, size_m)| View { corner, size_m, scale };
    bounds.into_iter().map(view).collect()
}

/// Points that a view of a moment must contain, each with the radius of the shape around it, m.
fn extent(snapshot: &Snapshot) -> Vec<(DVec3, f64)> {
    let objects = snapshot.objects.iter();
    let capsules = snapshot.arm.iter().chain(objects.flat_map(|object| &object.capsules));
    let ends = capsules.flat_map(|capsule| [(capsule.start, capsule.radius_m), (capsule.end, capsule.radius_m)]);
    let blades = snapshot.objects.iter().flat_map(|object| &object.blades);
    let pieces = blades.flat_map(|blade| {
        let radius_m = blade.width_m / 2.0;
        blade.pieces.iter().flat_map(move |piece| {
            let end = piece.pose_world.transform_point(DVec3::Z * piece.length_m);
            [(piece.pose_world.position, radius_m), (end, radius_m)]
        })
    });
    let goal = (snapshot.frame.goal_position_world, 0.0);
    ends.chain(pieces).chain([goal]).collect()
}

#[cfg(test)]
mod tests;
