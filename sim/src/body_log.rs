//! The poses of all links and bodies during a reach, as a recording stores them.

use underbrush_recording::{Body, BodyOwner, BodyPart, Pose};

use crate::arm::{Arm, Link, LinkCollider};
use crate::simulation::{FrameReport, Simulation};

/// The links of an arm at these poses.
pub fn link_bodies(arm: &Arm, poses_world: &[Pose]) -> Vec<Body> {
    let part = |own: &LinkCollider| BodyPart { shape: own.shape.clone(), pose_body: own.pose_link };
    let body = |(link, pose): (&Link, &Pose)| Body {
        owner: BodyOwner::Link(link.name.clone()),
        parts: link.colliders.iter().map(part).collect(),
        rest_pose_world: *pose,
        track: Vec::new(),
    };
    arm.links.iter().zip(poses_world).map(body).collect()
}

/// Follows all bodies, frame by frame.
#[derive(Clone)]
pub struct BodyLog {
    /// All bodies with their poses: the links of the arm, base first, then the bodies of the objects, object by object.
    pub bodies: Vec<Body>,
    /// For each body of an object, the object and the body's index in it.
    places: Vec<(usize, usize)>,
    /// Poses in the last frame, world frame; `None` before the first.
    last_world: Vec<Option<Pose>>,
}

impl BodyLog {
    /// The bodies of a simulation at its start.
    pub fn new(simulation: &Simulation) -> Self {
        let mut bodies = link_bodies(simulation.arm(), &simulation.report().link_pose_world);
        let places = simulation.recorded_bodies().to_vec();
        bodies.extend(places.iter().map(|(object, body)| Body {
            owner: BodyOwner::Object(*object as u16),
            parts: simulation.structure(*object).bodies[*body].parts.clone(),
            rest_pose_world: simulation.rest_pose_world(*object)[*body],
            track: Vec::new(),
        }));
        BodyLog { last_world: vec![None; bodies.len()], bodies, places }
    }

    /// The bodies of a running simulation, with their present poses. At rest the arm is in its start posture.
    pub fn now(simulation: &Simulation) -> Self {
        let mut log = BodyLog::new(simulation);
        let arm = simulation.arm();
        for (body, pose) in log.bodies.iter_mut().zip(arm.forward_kinematics(&arm.start_posture_rad())) {
            body.rest_pose_world = pose;
        }
        log.observe(simulation.report());
        log
    }

    /// Records the poses in a frame.
    pub fn observe(&mut self, report: &FrameReport) {
        let of_objects = self.places.iter().map(|(object, body)| &report.objects[*object].body_pose_world[*body]);
        let poses = report.link_pose_world.iter().chain(of_objects);
        for ((body, last), pose) in self.bodies.iter_mut().zip(&mut self.last_world).zip(poses) {
            // Most bodies rest.
            if last.replace(*pose) != Some(*pose) {
                body.observe(report.frame, pose);
            }
        }
    }
}

#[cfg(test)]
mod tests;
