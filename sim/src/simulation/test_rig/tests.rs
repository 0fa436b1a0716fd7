//! Tests of the rig itself.

use glam::DVec3;
use underbrush_recording::{BodyPart, BodyShape, Pose};

use super::{FreeBody, Rig};
use crate::{PhysicsOptions, Surface};

/// Tests that a free cylinder has its inertia, m r² / 2, about its own axis, and m (3 r² + l²) / 12 across it.
#[test]
fn a_cylinder_turns_about_its_own_axis() {
    let mut rig = Rig::new(PhysicsOptions { step_s: 0.005, gravity_m_per_s2: 0.0 });
    let part = BodyPart { shape: BodyShape::Cylinder { radius_m: 0.02, length_m: 0.3 }, pose_body: Pose::IDENTITY };
    rig.add_free(&FreeBody::resting(part, 2.0, Surface::hard(0.3), Pose::IDENTITY)).unwrap();
    let trees = rig.describe();
    let inertia = trees[0].last().unwrap().link.inertia_link;
    let across = 2.0 * (3.0 * 0.02 * 0.02 + 0.3 * 0.3) / 12.0;
    let expected = DVec3::new(across, across, 0.5 * 2.0 * 0.02 * 0.02);
    let found = DVec3::new(inertia.x_axis.x, inertia.y_axis.y, inertia.z_axis.z);
    assert!((found - expected).abs().max_element() < 1e-12, "{found} {expected}");
}
