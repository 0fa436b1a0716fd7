//! Check 18: the law of contact in the dynamics, with force against overlap, loss, and the same skin along the forearm.

use std::f64::consts::FRAC_PI_2;

use glam::{DQuat, DVec3};
use underbrush_oracles::foundation::{self, Layer};
use underbrush_recording::{BodyPart, BodyShape, Pose};
use underbrush_sim::object::structure::part;
use underbrush_sim::simulation::test_rig::{BodyId, FreeBody, Rig};
use underbrush_sim::{Arm, PhysicsOptions, Surface};

use crate::pressed_arm::{Beside, FOREARM_RADIUS_M, GRAVITY_M_PER_S2, OPTIONS, PressedArm};
use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

mod thrown;

/// Check 18.
pub const CHECK: Check = Check {
    name: "contact-law",
    summary: "Bodies rest at the overlap of an elastic foundation whatever their mass, rebound as its loss says, and the \
              forearm has the same skin from wrist to elbow",
    cases: &[
        Case { compare: resting, falsifications: &[STIFF_SURFACE] },
        Case { compare: pressed_flat, falsifications: &[THICK_LAYER] },
        thrown::REBOUND,
        thrown::DEFAULT_STEPS,
        thrown::FAST_TOUCH,
        Case { compare: along_the_forearm, falsifications: &[STIFF_SKIN] },
    ],
};

const STIFF_SURFACE: Falsification = Falsification::new("stiffness of the simulated surface", "10 % too high");
const THICK_LAYER: Falsification = Falsification::new("thickness of the simulated layer", "20 % too large");
const STIFF_SKIN: Falsification = Falsification::new("stiffness of the simulated skin", "30 % too high");

const STIFFNESS_N_PER_M3: f64 = 3e7;

fn soft(stiffness_n_per_m3: f64, loss_time_s: f64) -> Surface {
    Surface { compliance_m3_per_n: 1.0 / stiffness_n_per_m3, thickness_m: None, loss_time_s, friction: 0.4 }
}

/// A cylinder that lies horizontally, with its axis at this angle from x.
fn lying(radius_m: f64, angle_rad: f64) -> BodyPart {
    let axis = DQuat::from_rotation_z(angle_rad) * DQuat::from_rotation_y(FRAC_PI_2);
    let shape = BodyShape::Cylinder { radius_m, length_m: 0.24 };
    BodyPart { shape, pose_body: Pose::from_orientation(axis) }
}

fn cuboid(size_m: DVec3) -> BodyPart {
    part(BodyShape::Box { size_m }, DVec3::ZERO)
}

/// A rig with a free body over one that is fixed and hard.
fn on(options: PhysicsOptions, lower: &BodyPart, upper: &FreeBody) -> Result<(Rig, BodyId), Fault> {
    let mut rig = Rig::new(options);
    let both = rig.add_fixed(lower, Surface::hard(0.4), &Pose::IDENTITY).zip(rig.add_free(upper));
    let (_, upper) = both.ok_or_else(|| Fault::Run("a body without volume".into()))?;
    Ok((rig, upper))
}

/// A body at rest at this height that does not turn.
fn above(part: &BodyPart, mass_kg: f64, surface: Surface, height_m: f64) -> FreeBody {
    let pose_world = Pose::from_position(DVec3::Z * height_m);
    FreeBody { may_rotate: false, ..FreeBody::resting(part.clone(), mass_kg, surface, pose_world) }
}

/// A body that rests on another: the two shapes, the height of the upper centre over the lower one at which they just
/// touch, and the volume of their overlap at a depth.
struct Resting {
    name: &'static str,
    upper: BodyPart,
    lower: BodyPart,
    height_m: f64,
    /// 1 / R of the thinner of two cylinders, 1/m, because their closed form is only the first term in d / R; 0 for
    /// exact forms.
    curvature_per_m: f64,
    overlap_m3: fn(f64) -> f64,
}

const BALL_M: f64 = 0.03;
const CYLINDER_M: f64 = 0.046;
const POST_M: f64 = 0.015;
const CROSSING_RAD: f64 = 1.1;
const BLADE_M: f64 = 0.03;
const PUNCH_M: f64 = 0.02;

fn bodies() -> [Resting; 4] {
    let table = || cuboid(DVec3::new(1.0, 1.0, 0.1));
    [
        Resting {
            name: "ball on a table",
            upper: part(BodyShape::Sphere { radius_m: BALL_M }, DVec3::ZERO),
            lower: table(),
            height_m: 0.05 + BALL_M,
            curvature_per_m: 0.0,
            overlap_m3: |depth| foundation::cap_volume_m3(BALL_M, depth),
        },
        Resting {
            name: "cylinder across a post",
            upper: lying(CYLINDER_M, CROSSING_RAD),
            lower: lying(POST_M, 0.0),
            height_m: CYLINDER_M + POST_M,
            curvature_per_m: 1.0 / POST_M,
            overlap_m3: |depth| {
                foundation::crossed_cylinders_force_n(1.0, [CYLINDER_M, POST_M], depth) / CROSSING_RAD.sin()
            },
        },
        Resting {
            name: "cylinder across a blade",
            upper: lying(CYLINDER_M, FRAC_PI_2),
            lower: cuboid(DVec3::new(0.3, BLADE_M, 0.002)),
            height_m: CYLINDER_M + 0.001,
            curvature_per_m: 0.0,
            overlap_m3: |depth| BLADE_M * foundation::segment_area_m2(CYLINDER_M, depth),
        },
        Resting {
            name: "flat punch on a table",
            upper: cuboid(DVec3::new(PUNCH_M, PUNCH_M, 0.04)),
            lower: table(),
            height_m: 0.07,
            curvature_per_m: 0.0,
            overlap_m3: |depth| PUNCH_M * PUNCH_M * depth,
        },
    ]
}

/// Forces that bodies of very different mass exert at rest, from the depth at which they rest.
fn resting(simulated: Simulated) -> Found {
    let stiffness = STIFFNESS_N_PER_M3 * simulated.with(STIFF_SURFACE, 1.0, 1.1);
    let mut comparisons = Vec::new();
    for body in bodies() {
        for mass_kg in [0.005, 1.0] {
            let body_above = above(&body.upper, mass_kg, soft(stiffness, 0.05), body.height_m);
            let (mut rig, upper) = on(OPTIONS, &body.lower, &body_above)?;
            rig.step_times(1000);
            let depth_m = body.height_m - rig.pose_world(upper).position.z;
            let quantity = format!("{}, k times the overlap's volume at rest, {} g", body.name, mass_kg * 1e3);
            let found = STIFFNESS_N_PER_M3 * (body.overlap_m3)(depth_m);
            let tolerance = 0.005 + body.curvature_per_m * depth_m / 4.0;
            let reason = "0.5 % of quadrature, and d / 4R where the closed form is the first term in d / R";
            let comparison = Comparison::of(quantity, "N", mass_kg * GRAVITY_M_PER_S2, found);
            comparisons.push(comparison.relative(tolerance, reason));
        }
    }
    Ok(comparisons)
}

/// The closed form of a layer on a hard shell, whose pressure over depth is that of two hard surfaces.
pub fn layer(stiffness_n_per_m3: f64, thickness_m: f64) -> Layer {
    Layer { stiffness_n_per_m3, ground_n_per_m3: 3e8, thickness_m }
}

/// The depth at which a flat punch rests on a layer of finite thickness, from light to nearly pressed flat.
fn pressed_flat(simulated: Simulated) -> Found {
    const THICKNESS_M: f64 = 3e-3;
    let layer = layer(STIFFNESS_N_PER_M3, THICKNESS_M);
    let [punch, table] = [PUNCH_M, 1.0].map(|side| cuboid(DVec3::new(side, side, 0.04)));
    let compare = |mass_kg: f64| -> Result<Comparison, Fault> {
        let thickness_m = Some(THICKNESS_M * simulated.with(THICK_LAYER, 1.0, 1.2));
        let surface = Surface { thickness_m, ..soft(STIFFNESS_N_PER_M3, 0.05) };
        let (mut rig, upper) = on(OPTIONS, &table, &above(&punch, mass_kg, surface, 0.04))?;
        rig.step_times(1000);
        let expected = layer.depth_m(mass_kg * GRAVITY_M_PER_S2 / (PUNCH_M * PUNCH_M));
        let found = 0.04 - rig.pose_world(upper).position.z;
        let name = format!("flat punch of {mass_kg} kg on a layer of 3 mm, depth at rest");
        Ok(Comparison::of(name, "m", expected, found).relative(1e-3, "0.1 %: the columns of a flat face are alike"))
    };
    [0.5, 2.0, 8.0, 32.0].into_iter().map(compare).collect()
}

/// A trunk pressed into the skin near the wrist, in the middle and near the elbow.
fn along_the_forearm(simulated: Simulated) -> Found {
    const RADIUS_M: f64 = 0.015;
    let compare = |(name, along_m): (&str, f64)| -> Result<Comparison, Fault> {
        let stiff = |arm: &mut Arm| arm.skin.stiffness_n_per_m3 *= simulated.with(STIFF_SKIN, 1.0, 1.3);
        let beside = Beside { along_m, ..Beside::trunk() };
        let mut pressed = PressedArm::new(beside, OPTIONS, stiff)?;
        let equilibrium = pressed.pressing_rad(9.0);
        pressed.hold(&equilibrium, 5.0);
        let forearm = pressed.report().link_pose_world[pressed.forearm];
        let foot = pressed.simulation.clutter().objects[0].foot_world;
        let axis = forearm.transform_vector(DVec3::Z);
        // The distance between two lines, and the angle between them.
        let normal = axis.cross(DVec3::Z);
        let distance_m = (foot - forearm.position).dot(normal.normalize()).abs();
        let depth_m = FOREARM_RADIUS_M + RADIUS_M - distance_m;
        let skin = &pressed.arm.skin;
        let layer = layer(skin.stiffness_n_per_m3, skin.thickness_m.unwrap_or(f64::INFINITY));
        let law = layer.force_n([FOREARM_RADIUS_M, RADIUS_M], depth_m);
        let contacts = pressed.report().contacts.iter().filter(|contact| contact.link == pressed.forearm);
        let force_n: f64 = contacts.map(|contact| contact.force_world.dot(contact.inward_world)).sum();
        let quantity = format!("trunk on the forearm {name}, 2π √(R₁R₂) ∫ p dh / sin α");
        Ok(Comparison::of(quantity, "N", force_n, law / normal.length())
            .relative(0.05, "5 %: terms of order d / R, a tenth for the trunk, a quarter of which enters"))
    };
    [("near the wrist", -0.05), ("in the middle", 0.0), ("near the elbow", 0.07)].into_iter().map(compare).collect()
}
