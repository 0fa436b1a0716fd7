//! What an agent sees: named parts of one row of numbers.

use crate::{Arm, Simulation};

/// A part of an observation.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Its name.
    pub name: String,
    /// Its shape. Taxels of a patch whose taxels form a grid have rows and columns.
    pub shape: Vec<usize>,
    /// Where it begins in the row.
    pub first: usize,
    /// Smallest and largest number; numbers outside are clamped to this range.
    pub range: [f32; 2],
}

impl Part {
    /// How many numbers it has.
    pub fn size(&self) -> usize {
        self.shape.iter().product()
    }
}

/// Angles, rad: two turns, since a continuous joint has no limits.
const ANGLE_RAD: f32 = 12.6;
/// Joint velocities, rad/s: faster than any joint of an arm.
const VELOCITY_RAD_PER_S: f32 = 100.0;
/// Joint torques, N m: more than any joint of such an arm has.
const TORQUE_NM: f32 = 1000.0;
/// Places, m: far beyond an arm's reach.
const PLACE_M: f32 = 10.0;
/// Sensed forces, N. Cody's taxels read 17 N at most.
const FORCE_N: f32 = 100.0;

/// The parts of an observation of this arm, in their order. A robot could know all of them.
pub(super) fn parts(arm: &Arm) -> Vec<Part> {
    let joints = arm.joints.len();
    let mut parts: Vec<Part> = Vec::new();
    let mut add = |name: &str, shape: Vec<usize>, low: f32, high: f32| {
        let first = parts.last().map_or(0, |last| last.first + last.size());
        parts.push(Part { name: name.to_owned(), shape, first, range: [low, high] });
    };
    for (name, largest) in [
        ("joint_angle_rad", ANGLE_RAD),
        ("joint_velocity_rad_per_s", VELOCITY_RAD_PER_S),
        ("equilibrium_angle_rad", ANGLE_RAD),
        ("joint_torque_nm", TORQUE_NM),
    ] {
        add(name, vec![joints], -largest, largest);
    }
    for name in ["end_effector_position_world", "goal_position_world"] {
        add(name, vec![3], -PLACE_M, PLACE_M);
    }
    for patch in &arm.skin.layout.patches {
        let shape = match patch.grid {
            Some(grid) => vec![grid.rows, grid.columns],
            None => vec![patch.taxels.len()],
        };
        add(&format!("sensed_force_n.{}", patch.name), shape, -1.0, FORCE_N);
    }
    parts
}

/// Writes the present observation into `row`.
pub(super) fn write(
    parts: &[Part],
    simulation: &Simulation,
    equilibrium_rad: &[f64],
    goal_world: glam::DVec3,
    row: &mut [f32],
) {
    let report = simulation.report();
    let numbers: [&[f64]; 6] = [
        &report.joint_angle_rad(),
        &report.joint_velocity_rad_per_s(),
        equilibrium_rad,
        &report.joint_torque_nm(),
        &report.end_effector_pose_world.position.to_array(),
        &goal_world.to_array(),
    ];
    for (part, numbers) in parts.iter().zip(numbers) {
        let places = &mut row[part.first..part.first + part.size()];
        places.iter_mut().zip(numbers).for_each(|(place, number)| *place = *number as f32);
    }
    let taxels = &parts[numbers.len()..];
    if let (Some(first), Some(last)) = (taxels.first(), taxels.last()) {
        row[first.first..last.first + last.size()].fill(0.0);
    }
    for reading in &report.tactile.taxels {
        row[taxels[usize::from(reading.patch)].first + usize::from(reading.taxel)] = reading.sensed_force_n as f32;
    }
    for part in parts {
        let [low, high] = part.range;
        for number in &mut row[part.first..part.first + part.size()] {
            *number = number.clamp(low, high);
        }
    }
}
