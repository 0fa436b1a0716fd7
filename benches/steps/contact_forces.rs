//! Contact forces of a frame, for the benches that compare steps.

use std::collections::BTreeMap;

use glam::DVec3;
use underbrush_sim::simulation::FrameReport;

/// Forces of one frame by link and object, or the arm itself, N, world frame.
pub type Forces = BTreeMap<(usize, Option<usize>), DVec3>;

/// The forces of a frame.
pub fn forces(report: &FrameReport) -> Forces {
    let mut forces = Forces::new();
    for contact in &report.contacts {
        *forces.entry((contact.link, contact.object)).or_default() += contact.force_world;
    }
    forces
}

/// Their sums by link.
pub fn by_link(forces: &Forces) -> BTreeMap<usize, DVec3> {
    let mut sums: BTreeMap<usize, DVec3> = BTreeMap::new();
    for ((link, _), force) in forces {
        *sums.entry(*link).or_default() += *force;
    }
    sums
}
