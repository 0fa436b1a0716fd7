//! A picture of an arm alone, in its start posture, with its taxels.

use std::fmt::Write;

use glam::{DVec2, DVec3};
use underbrush_sim::arm::Arm;
use underbrush_sim::geometry::PlacedShape;

use super::panel::{ARM, Panel, goal_mark};
use super::{LEFT, LINE, RIGHT, WIDTH, legend, panels, views_of};
use crate::drawing::svg_document;
use crate::style::{LEAF, OUTLIER, UNCERTAIN, WRONG};

/// Colours of patches, in order.
const PATCHES: [&str; 4] = [UNCERTAIN, OUTLIER, LEAF, WRONG];
/// Directions in which the outline of a shape is found.
const DIRECTIONS: usize = 72;

/// Draws an arm in its start posture, from the right and from above: its collision shapes, the taxels that face the viewer in
/// a colour for each patch, and the end effector.
pub fn still(arm: &Arm, caption: &str) -> String {
    let poses = arm.forward_kinematics(&arm.start_posture_rad());
    let shapes: Vec<PlacedShape> = arm.placed_shapes(&poses).collect();
    let tip = arm.end_effector_pose(&poses).position;
    let mut points = vec![(tip, 0.0), (DVec3::ZERO, 0.0)];
    let ends = DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis]);
    points.extend(ends.flat_map(|end| shapes.iter().filter_map(move |shape| Some((shape.farthest(end)?, 0.0)))));
    let mut body = String::new();
    let mut y = 8.0;
    y += legend::paragraph(&mut body, caption, (8.0, WIDTH - 16.0), y);
    let patches = arm.skin.layout.patches.iter().zip(&arm.skin.surfaces).zip(PATCHES.iter().cycle());
    for ((patch, _), colour) in patches.clone() {
        let _ = writeln!(body, "<circle cx=\"15\" cy=\"{:.1}\" r=\"5\" fill=\"{colour}\"/>", y + LINE / 2.0);
        let text = format!("patch {}: {} taxels on {}", patch.name, patch.taxels.len(), patch.link);
        y += legend::paragraph(&mut body, &text, (28.0, WIDTH - 36.0), y);
    }
    let height = panels(&mut body, y + LINE, views_of(&points, WIDTH - LEFT - RIGHT), None, |body, panel, view| {
        let mut nearest_last: Vec<&PlacedShape> = shapes.iter().collect();
        nearest_last.sort_by(|a, b| panel.depth(a.pose.position).total_cmp(&panel.depth(b.pose.position)));
        for shape in nearest_last {
            let outline: Vec<String> = outline(shape, panel)
                .map(|point| panel.to_pixels(view, point))
                .map(|at| format!("{:.1} {:.1}", at.x, at.y))
                .collect();
            let path = outline.join("L");
            let _ = writeln!(body, "<path d=\"M{path}Z\" fill=\"{ARM}\" stroke=\"#fff\" opacity=\"0.75\"/>");
        }
        for ((patch, surface), colour) in patches.clone() {
            let pose = poses[surface.link];
            let facing = |normal: &DVec3| panel.depth(pose.transform_vector(*normal)) > 0.0;
            for taxel in patch.taxels.iter().filter(|taxel| facing(&taxel.normal_link)) {
                let at = panel.to_pixels(view, pose.transform_point(taxel.position_link));
                let _ = writeln!(body, "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"1.5\" fill=\"{colour}\"/>", at.x, at.y);
            }
        }
        *body += &goal_mark(panel.to_pixels(view, tip));
    });
    svg_document(WIDTH, height, super::FONT, caption, &body)
}

/// The outline of a convex shape as a panel shows it, world frame, m.
fn outline<'a>(shape: &'a PlacedShape, panel: &'a Panel) -> impl Iterator<Item = DVec3> + 'a {
    let turn = std::f64::consts::TAU / DIRECTIONS as f64;
    let directions = (0..DIRECTIONS).map(move |number| DVec2::from_angle(turn * number as f64));
    directions.filter_map(|direction| shape.farthest(panel.direction(direction)))
}
