//! Check 20: joint trees move as Rapier's multibodies do.
//!
//! Rapier's multibodies are made from what [`Rig::describe`] says, without any code of the trees. Their equations are
//! compared in random states at a step so short that its implicit terms vanish, and then along a second of free motion.
//! The rule for steps that resolve the motion is compared with a fine integration of the multibodies' accelerations.
//!
//! Where a step adds energy, Rapier solves a multibody again with another mass matrix, and says nothing of it
//! (`free_velocity_energy_guard`). It looks only at steps that move a coordinate by [`GUARDED`] or more, so such a step is an error
//! here.

use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use underbrush_recording::Pose;
use underbrush_recording::math::larger;
use underbrush_sim::arm::Arm;
use underbrush_sim::dynamics::{Coordinate, Tree};
use underbrush_sim::object::blade::grip;
use underbrush_sim::object::foam_block::FoamBlock;
use underbrush_sim::object::leaf::Leaf;
use underbrush_sim::object::water_bottle::WaterBottle;
use underbrush_sim::object::{Footing, Object, Structure};
use underbrush_sim::physics::{PhysicsOptions, Theta};
use underbrush_sim::scene::Scene;
use underbrush_sim::simulation::test_rig::{LinkDescription, Rig};

use crate::pressed_arm::{GRAVITY_M_PER_S2, LEAF, ROLL};
use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};
use peer::{Peer, stacked};

mod order;
mod peer;
#[cfg(test)]
mod tests;

/// Check 20.
pub const CHECK: Check = Check {
    name: "joint-trees",
    summary: "The arm and every object move as Rapier's multibodies do, and the arm's steps are of second order",
    cases: &[
        Case { compare, falsifications: &[HEAVY_LINKS, STRONG_GRAVITY, STIFF_SPRINGS, STRONG_DAMPERS] },
        order::IN_STEP,
    ],
};

const HEAVY_LINKS: Falsification = Falsification::new("mass of every simulated link", "0.1 % too high")
    // A free body falls as fast whatever its mass.
    .breaking(SPRUNG);
const STRONG_GRAVITY: Falsification = Falsification::new("gravity", "0.1 % too strong")
    // It does not act on the arm, and hardly moves a leaf on a sliding root that starts so near to rest.
    .breaking(&["accelerations of the leaf", "motion of the leaf,", "roll", "block", "bottle", "plant"]);
const STIFF_SPRINGS: Falsification =
    Falsification::new("stiffness of every simulated spring", "0.1 % too high").breaking(SPRUNG);
const STRONG_DAMPERS: Falsification = Falsification::new("every simulated damper", "0.1 % too strong").breaking(SPRUNG);
/// What has springs and dampers: all but the bottle.
const SPRUNG: &[&str] = &["leaf", "roll", "block", "arm", "plant"];

/// A step so short that springs, dampers and Coriolis forces do not depend on whether they are taken at its start or end.
const INSTANT_S: f64 = 1e-14;
/// Random states of each tree.
const STATES: usize = 20;
/// Length of the free motion, s.
const MOTION_S: f64 = 1.0;
/// Largest difference of the free motions, rad or m.
const MOTION_BOUND: f64 = 1e-6;
/// Rapier's guard looks at steps in which a coordinate moves by this or more, rad or m.
const GUARDED: f64 = 1e-3;

/// A plant of 15 joints: two blades on different pieces of the stem. One as it ships has 60.
const PLANT: &str = "summary = \"A plant\"\n[[objects.foam_block]]\ncount = 1\n[[objects.plant]]\ncount = 1\nblades = 2\n\
                     segments = 2\n";

/// The step of a free motion, s, and its start as a share of [`bent`].
type Motion = (f64, f64);
/// The shell of a roll that starts centimetres away from rest would differ by 3.3 mm, and by 1.0 mm in steps of 5 µs: of the first
/// order in the step.
const WIDE: Motion = (2e-5, 1.0);
/// Light blades on stiff hinges turn at 20 rad/s when they start from so far. The motions of a plant then differ by 6e-5 rad, and by 2e-6
/// rad in steps of 2.5 µs.
const NARROW: Motion = (1e-4, 1.0 / 16.0);

/// An object that stands on another one, and where its foot is at rest.
type Carried<'a> = (&'a dyn Object, Pose);

/// A tree, and the same links as multibodies are made from.
struct Subject {
    name: &'static str,
    tree: Tree,
    links: Vec<LinkDescription>,
    motion: Motion,
    /// Whether its mass matrix is singular without the springs and dampers of a step.
    is_singular: bool,
}

fn compare(simulated: Simulated) -> Found {
    let gravity_m_per_s2 = GRAVITY_M_PER_S2 * simulated.with(STRONG_GRAVITY, 1.0, 1.001);
    let compared = subjects(simulated)?.into_par_iter().map(|subject| {
        let name = subject.name;
        let apart = accelerations_apart(&subject, gravity_m_per_s2);
        let reason = if subject.is_singular {
            "1e-9: rounding of both. A root without mass turns only on its springs and dampers, so they are in the step, of 5 ms, and the \
             tree is at rest: Rapier takes Coriolis forces at the end of the step"
        } else {
            "1e-9: rounding of both"
        };
        let accelerations = Comparison::of(format!("accelerations of the {name} over the largest"), "", 0.0, apart);
        let mut found = vec![accelerations.absolute(1e-9, reason)];
        // A foam block has one axis, and its mass hardly counts beside its springs: its accelerations say all.
        if subject.tree.coordinates.len() > 1 {
            let apart = motions_apart(&subject, gravity_m_per_s2)?;
            let reason = "1e-6: both are of the first order, but Rapier takes Coriolis forces at the end of the step";
            let motion = Comparison::of(format!("free motion of the {name}, largest difference"), "rad or m", 0.0, apart);
            found.push(motion.absolute(MOTION_BOUND, reason));
        }
        Ok(found)
    });
    Ok(compared.collect::<Result<Vec<_>, Fault>>()?.concat())
}

/// The arm and one object of each kind that moves.
fn subjects(simulated: Simulated) -> Result<Vec<Subject>, Fault> {
    let leaf = Leaf { height_m: 0.3, segments: 4, ..LEAF };
    let small = Leaf { segments: 2, ..leaf };
    let sliding = Leaf { grip: grip(Some(5e4), 0.04, 0.3), ..small };
    let bottle =
        WaterBottle { diameter_m: 0.26, height_m: 0.45, empty_mass_kg: 0.75, water_mass_kg: 0.3, friction: 0.15 };
    let block = FoamBlock { height_m: 0.08, wet: true, modulus_pa: 5e4, stands_free: false };
    let free = FoamBlock { stands_free: true, ..block };
    let plant = plant()?;
    let on_block = [-0.06, 0.08].map(|x| {
        let foot = Pose::new(DVec3::new(x, 0.01, block.height_m), DQuat::from_rotation_z(10.0 * x));
        (&small as &dyn Object, foot)
    });
    let objects: [(&str, &dyn Object, &[Carried<'_>], Motion); 7] = [
        ("leaf", &leaf, &[], WIDE),
        ("foam roll", &ROLL, &[], WIDE),
        ("bottle", &bottle, &[], WIDE),
        ("foam block", &block, &[], WIDE),
        ("plant", &*plant, &[], NARROW),
        ("free block with leaves", &free, &on_block, NARROW),
        ("leaf on a sliding root", &sliding, &[], NARROW),
    ];
    let mass_ratio = simulated.with(HEAVY_LINKS, 1.0, 1.001);
    let structure = |object: &dyn Object| -> Structure {
        let mut structure = object.structure(GRAVITY_M_PER_S2);
        for body in &mut structure.bodies {
            body.inertia.mass_kg *= mass_ratio;
            body.inertia.principal_kg_m2 *= mass_ratio;
            // Multibodies know no drag.
            body.drag = None;
        }
        structure
    };
    let mut subjects = vec![of_arm("arm", Arm::cody()?, simulated)?];
    for (name, object, carried, motion) in objects {
        let mut rig = rig();
        rig.add_carrying(object, carried);
        let mut tree = Tree::of_structure(&structure(object), Pose::IDENTITY);
        if let Some(carrier) = object.carrier() {
            let at_rest = tree.links()[carrier].pose_world;
            for (own, foot) in carried {
                tree.carry(&structure(*own), carrier, at_rest.inverse() * *foot);
            }
        }
        subjects.push(Subject { motion, ..Subject::new(name, tree, &rig, simulated)? });
    }
    Ok(subjects)
}

fn rig() -> Rig {
    Rig::new(PhysicsOptions { step_s: INSTANT_S, gravity_m_per_s2: GRAVITY_M_PER_S2 })
}

fn of_arm(name: &'static str, mut arm: Arm, simulated: Simulated) -> Result<Subject, Fault> {
    let mut rig = rig();
    rig.add_arm(&arm);
    let mass_ratio = simulated.with(HEAVY_LINKS, 1.0, 1.001);
    for link in &mut arm.links {
        link.mass_kg *= mass_ratio;
        link.inertia_link *= mass_ratio;
    }
    Subject::new(name, Tree::of_arm(&arm, &arm.start_posture_rad()), &rig, simulated)
}

fn plant() -> Result<Box<dyn Object>, Fault> {
    let scene = Scene::parse("plant.toml", PLANT.into())?;
    let groups = scene.file.objects.groups();
    let group = groups.iter().find(|(kind, ..)| *kind == "plant");
    let (.., group) = group.ok_or_else(|| Fault::Run("a scene without its plant".into()))?;
    let footing = Footing { height_m: 0.0, foam_modulus_pa: Some(5e4) };
    let drawn = group.draw(&mut ChaCha8Rng::seed_from_u64(1), &footing);
    Ok(drawn.map_err(|error| Fault::Run(error.to_string()))?.0)
}

impl Subject {
    /// The tree, and what a rig says of the one tree on it that has as many links.
    fn new(name: &'static str, mut tree: Tree, rig: &Rig, simulated: Simulated) -> Result<Self, Fault> {
        for own in &mut tree.coordinates {
            let stiffness_ratio = simulated.with(STIFF_SPRINGS, 1.0, 1.001);
            own.spring.stiffness *= stiffness_ratio;
            if let Some(branch) = &mut own.spring.maxwell {
                branch.stiffness *= stiffness_ratio;
            }
            own.spring.damping *= simulated.with(STRONG_DAMPERS, 1.0, 1.001);
        }
        let described = rig.describe().into_iter().find(|links| links.len() == tree.links().len());
        let links = stacked(&described.ok_or_else(|| Fault::Run(format!("no {name} on the rig")))?);
        let is_singular = tree.coordinates_of(1).len() == 6 && tree.links()[1].mass_kg == 0.0;
        Ok(Subject { name, tree, links, motion: WIDE, is_singular })
    }
}

/// The largest difference of the accelerations in random states, over the largest acceleration of the state.
fn accelerations_apart(subject: &Subject, gravity_m_per_s2: f64) -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut worst = 0.0_f64;
    let size = subject.tree.coordinates.len();
    let step_s = if subject.is_singular { 5e-3 } else { INSTANT_S };
    for _ in 0..STATES {
        let mut draw =
            |size_of: f64| -> Vec<f64> { (0..size).map(|_| random.random_range(-size_of..size_of)).collect() };
        let (displacement, mut velocity) = (draw(0.3), draw(3.0));
        if subject.is_singular {
            velocity.fill(0.0);
        }
        let mut own = displaced(&subject.tree, &displacement, &velocity);
        own.begin(step_s, Theta::EULER);
        own.prepare(gravity_m_per_s2);
        let mut peer = Peer::new(&subject.links, step_s);
        peer.set(&displacement, &velocity);
        peer.step();
        let expected = peer.accelerations();
        let largest = expected.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let apart = own.acceleration().iter().zip(&expected).map(|(own, other)| (own - other).abs());
        worst = larger(worst, apart.fold(0.0, larger) / largest);
    }
    worst
}

/// The largest difference of the displacements along a free motion from a bent state. The motion ends early at ten times the bound,
/// because the rest could only raise it.
fn motions_apart(subject: &Subject, gravity_m_per_s2: f64) -> Result<f64, Fault> {
    let mut tree = subject.tree.clone();
    for branch in tree.coordinates.iter_mut().filter_map(|own| own.spring.maxwell.as_mut()) {
        // Multibodies have no relaxing branches.
        branch.relaxation_time_s = f64::INFINITY;
    }
    let (step_s, share) = subject.motion;
    let (displacement, velocity) = (bent(&tree, share), vec![0.1 * share; tree.coordinates.len()]);
    let mut own = displaced(&tree, &displacement, &velocity);
    let mut peer = Peer::new(&subject.links, step_s);
    peer.set(&displacement, &velocity);
    let mut worst = 0.0_f64;
    for _ in 0..(MOTION_S / step_s).round() as usize {
        own.begin(step_s, Theta::EULER);
        own.prepare(gravity_m_per_s2);
        own.advance();
        peer.step();
        let positions = own.coordinates.iter().map(|own| own.position).zip(peer.positions());
        worst = positions.map(|(own, other)| (own - other).abs()).fold(worst, larger);
        if worst.is_nan() || worst > 10.0 * MOTION_BOUND {
            break;
        }
        if own.coordinates.iter().any(|own| own.velocity.abs() * step_s >= GUARDED) {
            return Err(Fault::Run(format!("Rapier's guard of the energy may have acted on the {}", subject.name)));
        }
    }
    Ok(worst)
}

/// This share of angles of 1 to 3 degrees and displacements of 1 mm.
fn bent(tree: &Tree, share: f64) -> Vec<f64> {
    let bent = |(at, own): (usize, &Coordinate)| if own.turns { 0.02 * (1.0 + at as f64 % 3.0) } else { 0.001 };
    tree.coordinates.iter().enumerate().map(|own| share * bent(own)).collect()
}

/// The tree after displacements and with velocities.
fn displaced(tree: &Tree, displacement: &[f64], velocity: &[f64]) -> Tree {
    let mut tree = tree.clone();
    tree.displace(|_, at| displacement[at]);
    for (own, velocity) in tree.coordinates.iter_mut().zip(velocity) {
        own.velocity = *velocity;
        own.dashpot = 0.0;
    }
    tree
}
