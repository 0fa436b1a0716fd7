//! Trees of arms and objects.

use glam::DMat3;
use underbrush_recording::Pose;

use super::{Coordinate, EndStop, Link, Tree};
use crate::arm::Arm;
use crate::object::structure::{Axis, Spring, Structure};

/// Angle by which an end stop gives way under the largest torque of the joint's actuator, rad: 2°, as rubber stops do.
const STOP_GIVE_RAD: f64 = 0.035;
/// Loss time of the stops, s. Choice: about critical damping for a joint of Cody's shoulder, whose inertia of about
/// 0.3 kg m² and stop of 2 kNm/rad oscillate with 13 Hz.
const STOP_LOSS_TIME_S: f64 = 0.02;

impl Tree {
    /// A tree that has only its ground yet, at this pose. Gravity acts on its links if it `weighs`.
    pub fn new(ground_world: Pose, weighs: bool) -> Self {
        let links = vec![Link { pose_world: ground_world, ..Link::new(0, Pose::IDENTITY) }];
        let (coordinates, pushes, inertia, grips, scratch) = Default::default();
        Tree { links, coordinates, weighs, pushes, inertia, grips, scratch }
    }

    /// Adds a link on a joint with these degrees of freedom, and returns its index. All translations come before the rotations. Of two
    /// rotations, the first turns the axis of the second; three are those of a ball joint.
    pub fn add(&mut self, link: Link, axes: impl IntoIterator<Item = Coordinate>) -> usize {
        let (index, first) = (self.links.len(), self.coordinates.len());
        let mut last = self.links[link.parent].last;
        for own in axes {
            self.coordinates.push(Coordinate { link: index, before: last, ..own });
            last = Some(self.coordinates.len() - 1);
        }
        let is_ball = self.coordinates[first..].iter().filter(|own| own.turns).count() == 3;
        self.links.push(Link { coordinates: (first, self.coordinates.len()), last, is_ball, ..link });
        self.pushes.resize(self.coordinates.len(), 0.0);
        self.place();
        index
    }

    /// An object with its foot at this pose.
    pub fn of_structure(structure: &Structure, foot_world: Pose) -> Self {
        let mut tree = Tree::new(foot_world, true);
        tree.add_bodies(structure, 0);
        tree
    }

    /// Adds an object whose foot is fixed to a link, at this pose in the link's frame. Returns the link that is its foot.
    pub fn carry(&mut self, structure: &Structure, carrier: usize, foot_carrier: Pose) -> usize {
        let foot = self.add(Link::new(carrier, foot_carrier), []);
        self.add_bodies(structure, foot);
        foot
    }

    /// Adds the bodies of an object, whose foot is this link, as links in the order of the bodies. A body without a joint is
    /// one more link that is fixed to the foot.
    fn add_bodies(&mut self, structure: &Structure, foot: usize) {
        for body in structure.bodies.iter().skip(1) {
            let inertia = body.inertia;
            let joint = body.joint.as_ref();
            let parent = foot + joint.map_or(0, |joint| joint.parent);
            let joint_parent =
                joint.map_or(Pose::IDENTITY, |joint| Pose::new(joint.origin_parent, joint.orientation_parent));
            let link = Link {
                mass_kg: inertia.mass_kg,
                center_of_mass_link: inertia.center_of_mass_body,
                inertia_link: DMat3::from_diagonal(inertia.principal_kg_m2),
                drag: body.drag,
                ..Link::new(parent, joint_parent)
            };
            let axes = joint.into_iter().flat_map(|joint| &joint.free_axes);
            let link = self.add(link, axes.map(|(axis, spring)| Coordinate::new(*axis, *spring)));
            self.grips.extend(joint.and_then(|joint| joint.grip).map(|grip| (link, grip)));
        }
    }

    /// An arm at rest in a posture, rad, with its equilibrium angles there. Its base frame is the world frame. Gravity does
    /// not act on it, because the robot compensates gravity.
    pub fn of_arm(arm: &Arm, posture_rad: &[f64]) -> Self {
        let mut tree = Tree::new(Pose::IDENTITY, false);
        for (index, (joint, link)) in arm.joints.iter().zip(&arm.links[1..]).enumerate() {
            let is_limited = joint.limits_rad.iter().all(|limit| limit.is_finite());
            let spring = Spring {
                stiffness: joint.stiffness_nm_per_rad,
                damping: joint.damping_nm_s_per_rad,
                armature: joint.armature_kg_m2,
                ..Spring::default()
            };
            let stop = is_limited.then_some(EndStop {
                limits_rad: joint.limits_rad,
                stiffness_nm_per_rad: joint.torque_limit_nm / STOP_GIVE_RAD,
                loss_time_s: STOP_LOSS_TIME_S,
            });
            let link = Link {
                mass_kg: link.mass_kg,
                center_of_mass_link: link.center_of_mass_link,
                inertia_link: link.inertia_link,
                ..Link::new(index, joint.origin_parent)
            };
            tree.add(link, [Coordinate { stop, ..Coordinate::new(Axis::about(joint.axis_child), spring) }]);
        }
        for (coordinate, angle) in tree.coordinates.iter_mut().zip(posture_rad) {
            (coordinate.position, coordinate.spring.rest) = (*angle, *angle);
        }
        tree.place();
        tree
    }
}
