//! Check 4: bodies at rest press with their weight.

use glam::DVec3;
use rapier3d::prelude::*;
use underbrush_sim::physics::{Physics, PhysicsOptions, pressed_points};

use crate::{Breaks, Case, Check, CheckError, Comparison, Falsification, Simulated};

/// Check 4.
pub const CHECK: Check = Check {
    number: 4,
    name: "resting-load",
    summary: "A ball, a box and a capsule at rest press on the ground with their weight",
    cases: &[Case {
        compare,
        falsifications: &[HEAVY_BODY],
    }],
};

const HEAVY_BODY: Falsification = Falsification {
    wrong: "mass of the simulated body",
    by: "1 % too high",
    breaks: Breaks::Every,
};

const GRAVITY_M_PER_S2: f64 = 9.81;
const MASS_KG: f64 = 0.4;
const OPTIONS: PhysicsOptions = PhysicsOptions {
    step_s: 0.005,
    substeps: 4,
    gravity_m_per_s2: GRAVITY_M_PER_S2,
};

fn compare(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let mass_kg = MASS_KG * simulated.with(HEAVY_BODY, 1.0, 1.01);
    let bodies = [
        ("ball", SharedShape::ball(0.03)),
        ("box", SharedShape::cuboid(0.04, 0.03, 0.03)),
        ("capsule", SharedShape::capsule_x(0.05, 0.03)),
    ];
    Ok(bodies
        .map(|(name, shape)| {
            Comparison::relative(
                format!("load under a {name}"),
                "N",
                MASS_KG * GRAVITY_M_PER_S2,
                resting_load_n(shape, mass_kg),
                1e-6,
                "1e-6: a state of rest has no error of the step; what remains is the solver's residual",
            )
        })
        .into())
}

/// The contact force between the ground and a body that has lain on it for three seconds, N.
fn resting_load_n(shape: SharedShape, mass_kg: f64) -> f64 {
    let mut physics = Physics::new(OPTIONS);
    let ground = physics.bodies.insert(RigidBodyBuilder::fixed());
    let plate = ColliderBuilder::cuboid(0.5, 0.5, 0.05).translation(DVec3::Z * -0.05);
    let plate = physics.colliders.insert_with_parent(plate, ground, &mut physics.bodies);
    // All three shapes are 3 cm high over their middle.
    // Kept from rolling about its axis, x: the engine holds on to a contact point while a body turns a little, and the
    // stale point starts a capsule that is free to roll, from 1e-13 m/s to 0.1 m/s in five seconds.
    let lying = RigidBodyBuilder::dynamic()
        .translation(DVec3::Z * 0.03)
        .enabled_rotations(false, true, true)
        .can_sleep(false);
    let lying = physics.bodies.insert(lying);
    let shape = ColliderBuilder::new(shape).mass(mass_kg);
    physics.colliders.insert_with_parent(shape, lying, &mut physics.bodies);
    for _ in 0..600 {
        physics.step();
    }
    let points = physics.narrow_phase.contact_pairs_with(plate);
    let impulse: f64 = points
        .flat_map(|pair| pair.manifolds())
        .flat_map(pressed_points)
        .map(|point| point.data.impulse)
        .sum();
    impulse / OPTIONS.step_s
}
