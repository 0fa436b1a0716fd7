//! The contacts of a frame as in a recording: one for each patch, or bare part of a link, and body of an object.

use glam::DVec3;
use underbrush_recording::ContactPoint;

use super::{FrameReport, StepContact};

/// Contacts of one place, added up over the steps of a frame.
#[derive(Default)]
struct Sum {
    /// Link, patch, object and body.
    place: (u16, Option<u16>, Option<u16>, u16),
    force_n: f64,
    force: DVec3,
    /// Positions times magnitudes of the forces.
    weighted: DVec3,
    /// Moment about the origin of the world.
    moment: DVec3,
    normal: DVec3,
    slip: DVec3,
    steps: f64,
    depth_m: f64,
    area_m2: f64,
}

/// The contacts of a frame; `body` returns the index of a contact's body in a recording. The sums of forces and of their
/// moments are those of the report.
pub(super) fn contact_points(report: &FrameReport, body: impl Fn(&StepContact) -> u16) -> Vec<ContactPoint> {
    let mut sums: Vec<Sum> = Vec::new();
    for (contact, patch) in report.contacts.iter().zip(&report.tactile.contact_patch) {
        let place = (contact.link as u16, *patch, contact.object.map(|object| object as u16), body(contact));
        let at = sums.iter().position(|sum| sum.place == place).unwrap_or_else(|| {
            sums.push(Sum { place, ..Sum::default() });
            sums.len() - 1
        });
        let position = report.link_pose_world[contact.link].transform_point(contact.position_link);
        let (sum, force_n) = (&mut sums[at], contact.force_world.length());
        sum.force_n += force_n;
        sum.force += contact.force_world;
        sum.weighted += position * force_n;
        sum.moment += position.cross(contact.force_world) + contact.moment_world;
        sum.normal += contact.inward_world * force_n;
        sum.slip += contact.slip_world;
        sum.steps += 1.0;
        sum.depth_m = sum.depth_m.max(contact.penetration_m);
        sum.area_m2 = sum.area_m2.max(contact.area_m2);
    }
    sums.iter().map(Sum::point).collect()
}

impl Sum {
    fn point(&self) -> ContactPoint {
        let (link, patch, object, body) = self.place;
        let position = self.weighted / self.force_n;
        ContactPoint {
            link,
            patch,
            object,
            body,
            position_world: position.as_vec3(),
            normal_world: self.normal.normalize_or(DVec3::Z).as_vec3(),
            force_world: self.force.as_vec3(),
            moment_world: (self.moment - position.cross(self.force)).as_vec3(),
            slip_world: (self.slip / self.steps).as_vec3(),
            depth_m: self.depth_m as f32,
            area_m2: self.area_m2 as f32,
        }
    }
}
