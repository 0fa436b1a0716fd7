//! The true stiffness of an object.

use glam::DVec3;
use underbrush_recording::Recording;

/// An object that has given way by less than this is fixed, m: ten times the rounding of stored poses.
const GIVES_WAY_M: f64 = 1e-3;

/// The true stiffness of an object in a frame, N/m: the force of its contacts over how far the points that are touched are
/// from where they are at rest, along the force. `None` if it has not given way, or if contacts or bodies are not recorded.
pub(super) fn true_stiffness_n_per_m(recording: &Recording, frame: usize, object: u16) -> Option<f64> {
    let (mut force, mut work) = (DVec3::ZERO, 0.0);
    for contact in recording.frames.get(frame)?.contact_points.iter().filter(|own| own.object == object) {
        let body = recording.bodies.get(usize::from(contact.body))?;
        let pose_world = body.pose_world(u32::try_from(frame).ok()?);
        let point_world = contact.position_world.as_dvec3();
        let at_rest = body.rest_pose_world.transform_point(pose_world.inverse_transform_point(point_world));
        // The force is the one on the link.
        force -= contact.force_world.as_dvec3();
        work -= contact.force_world.as_dvec3().dot(point_world - at_rest);
    }
    let force_n = force.length();
    (work > GIVES_WAY_M * force_n).then(|| force_n * force_n / work)
}

#[cfg(test)]
mod tests {
    use underbrush_recording::{Body, BodyOwner, ContactPoint, Frame, Pose};

    use super::*;
    use crate::trial::tests::recording;

    /// Tests the truth: a body that 4 N have moved by 2 cm along the force has 200 N/m, whatever its shift across it; one that
    /// did not move has none.
    #[test]
    fn the_true_stiffness_is_force_over_displacement() {
        let mut body = Body {
            owner: BodyOwner::Object(0),
            parts: Vec::new(),
            rest_pose_world: Pose::from_position(DVec3::X),
            track: Vec::new(),
        };
        body.observe(0, &body.rest_pose_world.clone());
        body.observe(1, &Pose::from_position(DVec3::new(1.02, 0.01, 0.0)));
        let contact = ContactPoint {
            link: 0,
            patch: None,
            object: 0,
            body: 0,
            position_world: glam::Vec3::new(0.97, 0.3, 0.2),
            normal_world: -glam::Vec3::X,
            force_world: -4.0 * glam::Vec3::X,
            moment_world: glam::Vec3::ZERO,
            slip_world: glam::Vec3::ZERO,
            depth_m: 0.0,
            area_m2: 0.0,
        };
        let frame = Frame { contact_points: vec![contact], ..Frame::blank(0) };
        let recording = Recording { bodies: vec![body], frames: vec![frame.clone(), frame], ..recording(&[]) };
        let found = true_stiffness_n_per_m(&recording, 1, 0).unwrap();
        assert!((found / 200.0 - 1.0).abs() < 0.01, "{found}");
        assert_eq!(true_stiffness_n_per_m(&recording, 0, 0), None);
    }
}
