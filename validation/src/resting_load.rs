//! Check 4: bodies at rest press with their weight.

use glam::{DQuat, DVec3};
use underbrush_recording::{BodyPart, BodyShape, Pose};
use underbrush_sim::Surface;
use underbrush_sim::object::structure;
use underbrush_sim::simulation::test_rig::{FreeBody, Rig};

use crate::pressed_arm::{GRAVITY_M_PER_S2, OPTIONS};
use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

/// Check 4.
pub const CHECK: Check = Check {
    name: "resting-load",
    summary: "A ball, a box and a capsule at rest press on the ground with their own weight",
    cases: &[Case { compare, falsifications: &[HEAVY_BODY] }],
};

const HEAVY_BODY: Falsification = Falsification::new("mass of the simulated body", "1 % too high");

const MASS_KG: f64 = 0.4;
/// Friction plays no part at rest.
const FRICTION: f64 = 0.5;

/// The contact force between the ground and bodies that have lain on it for three seconds.
fn compare(simulated: Simulated) -> Found {
    let mass_kg = MASS_KG * simulated.with(HEAVY_BODY, 1.0, 1.01);

    let along_x = Pose::from_orientation(DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2));
    let capsule = BodyShape::Capsule { radius_m: 0.03, length_m: 0.1 };
    let bodies = [
        ("ball", BodyShape::Sphere { radius_m: 0.03 }, Pose::IDENTITY),
        ("box", BodyShape::Box { size_m: DVec3::new(0.08, 0.06, 0.06) }, Pose::IDENTITY),
        ("capsule", capsule, along_x),
    ];
    let compare = |(name, shape, pose_body): (&str, BodyShape, Pose)| -> Result<Comparison, Fault> {
        let mut rig = Rig::new(OPTIONS);
        let plate = structure::part(BodyShape::Box { size_m: DVec3::new(1.0, 1.0, 0.1) }, DVec3::Z * -0.05);
        let plate = rig.add_fixed(&plate, Surface::hard(FRICTION), &Pose::IDENTITY);
        let part = BodyPart { shape, pose_body };
        // All three shapes reach 3 cm below their centre.
        let place = Pose::from_position(DVec3::Z * 0.03);
        let lying = rig.add_free(&FreeBody::resting(part, mass_kg, Surface::hard(FRICTION), place));
        let (plate, _) = plate.zip(lying).ok_or_else(|| Fault::Run("a body without volume".into()))?;
        rig.step_times(600);
        let found = rig.pressing_force_n(plate);
        let load = Comparison::of(format!("load under a {name}"), "N", MASS_KG * GRAVITY_M_PER_S2, found);
        let reason = "1e-6: a state of rest has no discretization error; what remains is the solver's residual";
        Ok(load.relative(1e-6, reason))
    };
    bodies.into_iter().map(compare).collect()
}
