//! A start posture for an arm that has none yet, and the room in front of it for clutter and goals.

use std::f64::consts::PI;

use glam::DVec3;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::Arm;
use super::passing::overlap;

/// The room in front of an arm, in shares of its reach. Choice: that of the Panda in docs/arms.md, whose reach is 0.93 m.
pub(super) struct Room {
    /// Length of the chain from the second joint, the shoulder, to the end effector, m.
    pub(super) reach_m: f64,
    /// Place of the shoulder in the frame of the base at zero angles, m.
    pub(super) shoulder_m: DVec3,
}

/// Postures that the search begins with for each place of the end effector.
const STARTS: usize = 48;

impl Room {
    pub(super) fn of(arm: &Arm) -> Self {
        let poses = arm.forward_kinematics(&vec![0.0; arm.joints.len()]);
        let joints = poses[1..].iter().map(|pose| pose.position);
        let chain: Vec<DVec3> = joints.chain([arm.end_effector_pose(&poses).position]).collect();
        let from = 1.min(arm.joints.len() - 1);
        let reach_m = chain[from..].windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        Room { reach_m, shoulder_m: chain[from] }
    }

    /// Height of the table top, m.
    pub(super) fn table_m(&self) -> f64 {
        self.shoulder_m.z - 0.15 * self.reach_m
    }

    /// Smallest and largest height of goals, m.
    pub(super) fn goal_heights_m(&self) -> [f64; 2] {
        [0.05, 0.20].map(|share| self.shoulder_m.z + share * self.reach_m)
    }

    /// A posture with the end effector drawn back in front of the shoulder, above the table and level with the goals. Of those
    /// that are found it is the one in which the fewest links overlap, and then the one that is farthest from the limits of
    /// its joints. `None` if the end effector cannot be there.
    pub(super) fn start_posture(&self, arm: &Arm) -> Option<Vec<f64>> {
        let mut random = ChaCha8Rng::seed_from_u64(0);
        let [low, high] = self.goal_heights_m();
        let mut best: Option<(usize, f64, Vec<f64>)> = None;
        for (forward, height) in [(0.35, low), (0.35, high), (0.45, low), (0.45, high), (0.25, high)] {
            let place = DVec3::new(self.shoulder_m.x + forward * self.reach_m, self.shoulder_m.y, height);
            for number in 0..STARTS {
                let mut share = || if number == 0 { 0.5 } else { f64::from(random.next_u32()) / f64::from(u32::MAX) };
                let from: Vec<f64> = arm.joints.iter().map(|joint| joint.at_share(share())).collect();
                let Some(posture) = arm.posture_at(place, &from) else { continue };
                let room = posture.iter().zip(&arm.joints).map(|(angle, joint)| {
                    let [low, high] = joint.controller_limits_rad;
                    (angle - low).min(high - angle).min(PI - angle.abs()) / (high - low)
                });
                let room = room.fold(f64::INFINITY, f64::min);
                let Some(overlaps) = self.overlaps(arm, &posture) else { continue };
                if best.as_ref().is_none_or(|(most, least, _)| (overlaps, *least) < (*most, room)) {
                    best = Some((overlaps, room, posture));
                }
            }
        }
        best.map(|(.., posture)| posture)
    }

    /// How many pairs of links that are not neighbours overlap; `None` if a link beyond the shoulder is below the table.
    fn overlaps(&self, arm: &Arm, posture: &[f64]) -> Option<usize> {
        let poses = arm.forward_kinematics(posture);
        let shapes = arm.links.iter().zip(&poses).skip(3);
        let mut beyond = shapes.flat_map(|(link, pose)| link.placed_shapes(*pose));
        if beyond.any(|shape| -shape.extent_m(DVec3::NEG_Z) < self.table_m()) {
            return None;
        }
        let links = poses.len();
        let pairs = (0..links).flat_map(|a| (a + 2..links).map(move |b| [a, b]));
        Some(pairs.filter(|pair| overlap(arm, &poses, *pair)).count())
    }
}
