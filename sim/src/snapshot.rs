//! Arm and clutter at one instant, as plain capsules for pictures.

use underbrush_recording::{BodyShape, Category, Frame, Pose};

use crate::geometry::{Capsule, engine_shape};
use crate::simulation::Simulation;

/// The arm and the clutter at one instant.
#[derive(Clone, Debug)]
pub struct Snapshot {
    /// The shapes of the links, base first.
    pub arm: Vec<Capsule>,
    /// The shapes of the objects with their categories; a bent leaf is a chain of thin ones.
    pub objects: Vec<(Category, Vec<Capsule>)>,
    /// The frame with the state of arm and skin.
    pub frame: Frame,
}

impl Snapshot {
    /// A snapshot of a simulation in the frame `frame`.
    pub fn take(simulation: &Simulation, frame: &Frame) -> Self {
        let report = simulation.report();
        let links = simulation.arm().links.iter().zip(&report.link_pose_world);
        let arm = links
            .flat_map(|(link, pose)| link.colliders.iter().map(move |part| (part, pose)))
            .filter_map(|(part, pose)| capsule(&part.shape, &(*pose * part.pose_link)))
            .collect();
        let placed = simulation.clutter().objects.iter().zip(&report.objects).enumerate();
        let objects = placed
            .map(|(index, (placed, state))| {
                let shapes = if state.active {
                    let bodies = simulation.structure(index).bodies.iter().zip(&state.body_pose_world);
                    bodies
                        .flat_map(|(body, pose)| body.parts.iter().map(move |part| (part, pose)))
                        .filter_map(|(part, pose)| capsule(&part.shape, &(*pose * part.pose_body)))
                        .collect()
                } else {
                    let (outline, pose) = placed.outline();
                    vec![Capsule::around(&outline, &pose)]
                };
                (placed.object.category(), shapes)
            })
            .collect();
        Snapshot {
            arm,
            objects,
            frame: frame.clone(),
        }
    }
}

fn capsule(shape: &BodyShape, pose_world: &Pose) -> Option<Capsule> {
    let (shape, pose) = engine_shape(shape)?;
    Some(Capsule::around(shape.as_ref(), &(*pose_world * pose)))
}
