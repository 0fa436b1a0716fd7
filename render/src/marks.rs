//! Marks in coloured pictures: the skin, the goal, a controller's map, and arrows of contact forces.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3, Vec3};
use underbrush_recording::{BodyShape, Frame, MappedObstacle, ObstacleKind, Pose, SkinLayout, TaxelReading, math};

use crate::colour;
use crate::mesh::Mesh;
use crate::scene::{Kind, Scene, Surface};

/// A taxel's plate lies this far above its place, m.
const LIFT_M: f64 = 0.0012;
/// Radius of a goal, m.
const GOAL_M: f64 = 0.016;
/// An obstacle on a map is a cage of rods. This is the radius of a rod, m.
const ROD_M: f64 = 0.0015;
/// Number of upright rods of a cage.
const UPRIGHTS: usize = 8;
/// Height of a cage where there is no table, m. Over a table it reaches down to the table.
const CAGE_M: f64 = 0.4;
/// Length of the shaft of an arrow, m per newton.
const METRES_PER_NEWTON: f64 = 0.04;
/// Least length of a shaft, m.
const SHORTEST_M: f64 = 0.012;
/// Largest length of a shaft, m.
const LONGEST_M: f64 = 0.25;
/// Radius of a shaft, m.
const SHAFT_M: f64 = 0.0025;
/// Radius of the head of an arrow, m.
const TIP_M: f64 = 0.007;
/// Length of the head, m.
const HEAD_M: f64 = 0.016;
/// Weaker contacts have no arrow, N.
const WEAKEST_N: f64 = 0.02;

fn mark(colour: Vec3) -> Surface {
    Surface { kind: Kind::Mark, colour, label: 0 }
}

/// The controller's map in the frame with this number, as on the replay page. `ground_m` is the height of the table.
pub fn add_map(map: &[MappedObstacle], ground_m: Option<f64>, number: u32, scene: &mut Scene) {
    for own in map.iter().filter(|own| (own.first_frame..=own.last_frame).contains(&number)) {
        let colour = match own.kind {
            ObstacleKind::Fixed => colour::FIXED,
            ObstacleKind::Doubtful => colour::GOAL,
            ObstacleKind::Yielding => colour::YIELDING,
        };
        let surface = mark(colour::linear(colour));
        let foot_m = ground_m.unwrap_or(own.top_world.z - CAGE_M).min(own.top_world.z);
        let corner = |upright: usize, height_m: f64| {
            let (sine, cosine) = math::sin_cos(TAU * upright as f64 / UPRIGHTS as f64);
            own.top_world.with_z(height_m) + DVec3::new(cosine, sine, 0.0) * own.radius_m
        };
        for upright in 0..UPRIGHTS {
            let (top, foot) = (corner(upright, own.top_world.z), corner(upright, foot_m));
            for end in [foot, corner(upright + 1, own.top_world.z)] {
                let rod = BodyShape::Capsule { radius_m: ROD_M, length_m: top.distance(end) };
                let turn = DQuat::from_rotation_arc(DVec3::Z, (top - end).normalize_or(DVec3::Z));
                scene.add(&Mesh::of(&rod), &Pose::new((top + end) / 2.0, turn), surface);
            }
        }
    }
}

/// The taxels in the colours of the forces that they sense. The scale ends at `full_scale_n`, N.
pub fn add_skin(layout: &SkinLayout, full_scale_n: f64, frame: &Frame, scene: &mut Scene) {
    let plate = mark(colour::linear(colour::PLATE));
    let mut readings = frame.taxels.iter().filter(|reading| reading.sensed_force_n > 0.0).peekable();
    for (number, (patch, pose)) in layout.patches.iter().zip(&frame.patch_pose_world).enumerate() {
        for (index, taxel) in patch.taxels.iter().enumerate() {
            let own = readings.next_if(|own| (usize::from(own.patch), usize::from(own.taxel)) == (number, index));
            let share = own.map(|own| own.sensed_force_n / full_scale_n);
            let surface = share.map_or(plate, |share| mark(colour::of_force(share)));
            let (mut square, half_m) = (Mesh::default(), 0.43 * taxel.area_m2.sqrt());
            let (right, up) = (taxel.tangent_link, taxel.normal_link.cross(taxel.tangent_link));
            square.add_plate(taxel.position_link + taxel.normal_link * LIFT_M, right * half_m, up * half_m);
            scene.add(&square, pose, surface);
        }
    }
}

/// The goal.
pub fn add_goal(frame: &Frame, scene: &mut Scene) {
    let points_m = DVec3::AXES.iter().flat_map(|axis| [*axis * GOAL_M, *axis * -GOAL_M]).collect();
    let goal = Mesh::of(&BodyShape::Hull { points_m });
    scene.add(&goal, &Pose::from_position(frame.goal_position_world), mark(colour::linear(colour::GOAL)));
}

/// The forces on the arm as arrows, as on the replay page (`replay/page/src/view/arrows.ts`), with the heads of the arrows where
/// they act, and in red where a taxel senses more than `limit_n`.
pub fn add_arrows(frame: &Frame, limit_n: f64, scene: &mut Scene) {
    for point in &frame.contact_points {
        let force_world = point.force_world.as_dvec3();
        let force_n = force_world.length();
        if force_n < WEAKEST_N {
            continue;
        }
        let own = |reading: &&TaxelReading| Some(reading.patch) == point.patch && reading.object == point.object;
        let over = frame.taxels.iter().filter(own).any(|reading| reading.sensed_force_n > limit_n);
        let colour = colour::linear(if over { colour::OVER } else { colour::ARROW });
        let shaft_m = (force_n * METRES_PER_NEWTON).clamp(SHORTEST_M, LONGEST_M);
        let line = [[0.0, 0.0], [SHAFT_M, 0.0], [SHAFT_M, shaft_m], [TIP_M, shaft_m], [0.0, shaft_m + HEAD_M]];
        // Marks are not lit, so that nobody needs their normals.
        let mesh = Mesh::turned(&line.map(|[radius_m, z_m]| [radius_m, z_m, 0.0, 0.0]), 12);
        let direction = force_world / force_n;
        let tail_world = point.position_world.as_dvec3() - direction * (shaft_m + HEAD_M);
        let pose = Pose::new(tail_world, DQuat::from_rotation_arc(DVec3::Z, direction));
        scene.add(&mesh, &pose, mark(colour));
    }
}
