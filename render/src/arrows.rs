//! Arrows of contact forces, as on the replay page (`replay/page/src/view/arrows.ts`).

use glam::{DQuat, DVec3};
use underbrush_recording::{Frame, Pose, TaxelReading};

use crate::colour;
use crate::mesh::Mesh;
use crate::scene::{Kind, Scene, Surface};

/// Length of a shaft, m per newton, and its least and largest length, m.
const METRES_PER_NEWTON: f64 = 0.04;
const SHORTEST_M: f64 = 0.012;
const LONGEST_M: f64 = 0.25;
/// Radius of the shaft and of the head, and the length of the head, m.
const SHAFT_M: f64 = 0.0025;
const TIP_M: f64 = 0.007;
const HEAD_M: f64 = 0.016;
/// Weaker contacts have no arrow, N.
const WEAKEST_N: f64 = 0.02;

/// Adds the forces on the arm, with the heads of the arrows where they act, and in red where a taxel senses more than `limit_n`.
pub fn add(frame: &Frame, limit_n: f64, scene: &mut Scene) {
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
        scene.add(&mesh, &pose, Surface { kind: Kind::Mark, colour, label: 0 });
    }
}
