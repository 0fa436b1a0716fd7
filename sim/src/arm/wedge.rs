//! Clefts between links of an arm that close like scissors, in which leaves and stems would be caught.

use std::f64::consts::PI;

use glam::{DQuat, DVec3};
use serde::Serialize;
use underbrush_recording::{Pose, math};

use super::skin_fit::Surface;
use super::{Arm, Joint, within_half_turn};

/// Radius of the ball that is tried, m: a stem, or the rolled edge of a leaf. Choice.
const BALL_M: f64 = 0.004;
/// Distance of neighbouring places that are tried, m, and how far the ball may be from touching there: half of it.
const STEP_M: f64 = 0.004;
/// Places are tried this near to the joint, m. Farther away the torque of a joint presses less.
const REACH_M: f64 = 0.1;
/// Angles of a joint that are tried, evenly spaced over its range.
const ANGLES: usize = 13;
/// A joint that turns with a shorter lever slides along the ball instead of pressing it, m.
const SHORTEST_LEVER_M: f64 = 0.005;
/// Smaller forces are not worth a warning, N: twice the largest that a leaf should feel.
const FORCE_N: f64 = 50.0;

/// A place at which a ball of 8 mm touches two links at once and cannot slip out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Wedge {
    /// The links, the one nearer to the base first.
    pub links: [String; 2],
    /// The joint that closes it.
    pub joint: String,
    /// Angle of this joint, degrees, while other joints between the links are at their start.
    pub joint_deg: f64,
    /// Angle between the surfaces that the ball touches, degrees. It is held if this is at most twice the angle of friction.
    pub opening_deg: f64,
    /// How far the closing surface moves for each radian, m.
    pub lever_m: f64,
    /// The joint's largest torque at this lever, N.
    pub force_n: f64,
}

/// The wedges of an arm: for each pair of links with one or two joints between them the one that presses hardest, if it presses
/// with more than 50 N.
pub fn wedges(arm: &Arm) -> Vec<Wedge> {
    let links = 0..arm.links.len();
    let pairs = links.flat_map(|first| [first + 1, first + 2].map(|second| (first, second)));
    let pairs = pairs.filter(|(_, second)| *second < arm.links.len());
    pairs.filter_map(|(first, second)| worst(arm, first, second)).collect()
}

/// The worst wedge between two links.
fn worst(arm: &Arm, first: usize, second: usize) -> Option<Wedge> {
    let parts = Surface::of(&arm.links[first]);
    // In the frame of the first link: the last joint, at which both meet.
    let joint = poses(arm, first, second, None)[second - first - 1].position;
    let places: Vec<DVec3> = around(joint).filter(|place| near(parts.distance_m(*place))).collect();
    let mut worst: Option<Wedge> = None;
    for joint in first..second {
        let [lower, upper] = within_half_turn(arm.joints[joint].limits_rad);
        for step in 0..ANGLES {
            let angle_rad = lower + (upper - lower) * step as f64 / (ANGLES - 1) as f64;
            let links = poses(arm, first, second, Some((joint, angle_rad)));
            let shapes = links.iter().zip(&arm.links[first + 1..]).map(|(pose, link)| link.placed_shapes(*pose));
            let mut shapes: Vec<Surface> = shapes.map(|shapes| Surface(shapes.collect())).collect();
            let Some(child) = shapes.pop() else { continue };
            let turning = links[joint - first];
            let axis = turning.orientation * arm.joints[joint].axis_child;
            for place in &places {
                let between_m = shapes.iter().map(|own| own.distance_m(*place)).fold(f64::INFINITY, f64::min);
                if between_m < BALL_M - STEP_M / 2.0 || !near(child.distance_m(*place)) {
                    continue;
                }
                let (of_first, of_second) = (normal(&parts, *place), normal(&child, *place));
                let opening_rad = PI - math::acos(of_first.dot(of_second).clamp(-1.0, 1.0));
                let lever_m = axis.cross(*place - of_second * BALL_M - turning.position).dot(of_second).abs();
                let force_n = arm.joints[joint].torque_limit_nm / lever_m;
                let holds = opening_rad <= 2.0 * math::atan2(arm.friction, 1.0);
                let is_worse = worst.as_ref().is_none_or(|worst| force_n > worst.force_n);
                if holds && lever_m >= SHORTEST_LEVER_M && force_n > FORCE_N && is_worse {
                    worst = Some(Wedge {
                        links: [first, second].map(|link| arm.links[link].name.clone()),
                        joint: arm.joints[joint].name.clone(),
                        joint_deg: angle_rad.to_degrees(),
                        opening_deg: opening_rad.to_degrees(),
                        lever_m,
                        force_n,
                    });
                }
            }
        }
    }
    worst
}

/// The poses of the links after `first` up to `second`, in the frame of the first, with one joint at an angle and the others at
/// their start.
fn poses(arm: &Arm, first: usize, second: usize, turned: Option<(usize, f64)>) -> Vec<Pose> {
    let place = |pose: &mut Pose, (joint, own): (usize, &Joint)| {
        let angle_rad = turned.filter(|(turned, _)| *turned == joint).map_or(own.start_rad, |(_, angle_rad)| angle_rad);
        *pose = *pose * own.origin_parent * Pose::from_orientation(DQuat::from_axis_angle(own.axis_child, angle_rad));
        Some(*pose)
    };
    arm.joints.iter().enumerate().take(second).skip(first).scan(Pose::IDENTITY, place).collect()
}

/// Places in a ball around a point, on a grid.
fn around(middle: DVec3) -> impl Iterator<Item = DVec3> {
    let steps = (REACH_M / STEP_M) as i32;
    let along = move || (-steps..=steps).map(|step| f64::from(step) * STEP_M);
    let grid = along().flat_map(move |x| along().flat_map(move |y| along().map(move |z| DVec3::new(x, y, z))));
    grid.filter(|offset| offset.length() <= REACH_M).map(move |offset| middle + offset)
}

/// Whether a ball at this distance from a surface touches it, within half a step.
fn near(distance_m: f64) -> bool {
    (distance_m - BALL_M).abs() <= STEP_M / 2.0
}

/// The direction in which the distance from the shapes grows fastest.
fn normal(parts: &Surface, place: DVec3) -> DVec3 {
    let step_m = 1e-4;
    let slope = |axis: DVec3| parts.distance_m(place + axis * step_m) - parts.distance_m(place - axis * step_m);
    DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z)).normalize_or(DVec3::Z)
}
