//! Check 20: joint trees move as Rapier's multibodies do.
//!
//! Rapier's multibodies are made from what [`Rig::describe`] says, without any code of the trees. Their equations are
//! compared in random states at a step so short that its implicit terms vanish, and then along a second of free motion.

use glam::{DMat3, DQuat, DVec3};
use nalgebra::{Matrix3, SymmetricEigen};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rapier3d::prelude::*;
use rayon::prelude::*;
use underbrush_recording::Pose as WorldPose;
use underbrush_recording::math::larger;
use underbrush_sim::arm::Arm;
use underbrush_sim::dynamics::{Coordinate, Link, Tree};
use underbrush_sim::object::Object;
use underbrush_sim::object::foam_block::FoamBlock;
use underbrush_sim::object::leaf::Leaf;
use underbrush_sim::object::water_bottle::WaterBottle;
use underbrush_sim::physics::{PhysicsOptions, Theta};
use underbrush_sim::simulation::test_rig::{LinkDescription, Rig};

use crate::pressed_arm::{GRAVITY_M_PER_S2, LEAF, ROLL};
use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

/// Check 20.
pub const CHECK: Check = Check {
    name: "joint-trees",
    summary: "The arm and every object move as Rapier's multibodies do",
    cases: &[Case { compare, falsifications: &[HEAVY_LINKS, STRONG_GRAVITY] }],
};

const HEAVY_LINKS: Falsification = Falsification::new("mass of every simulated link", "0.1 % too high")
    // A free body falls as fast whatever its mass.
    .breaking(&["leaf", "roll", "block", "arm"]);
const STRONG_GRAVITY: Falsification = Falsification::new("gravity", "0.1 % too strong")
    // It does not act on the arm.
    .breaking(&["leaf", "roll", "block", "bottle"]);

/// A step so short that springs, dampers and Coriolis forces do not depend on whether they are taken at its start or end.
const INSTANT_S: f64 = 1e-14;
/// Random states of each tree.
const STATES: usize = 20;
/// Step of the free motion, s, and its length.
const STEP_S: f64 = 2e-5;
const MOTION_S: f64 = 1.0;
/// Largest difference of the free motions, rad or m.
const MOTION_BOUND: f64 = 1e-6;

fn compare(simulated: Simulated) -> Found {
    let mass_ratio = simulated.with(HEAVY_LINKS, 1.0, 1.001);
    let gravity_m_per_s2 = GRAVITY_M_PER_S2 * simulated.with(STRONG_GRAVITY, 1.0, 1.001);
    let mut subjects = Vec::new();
    let leaf = Leaf { height_m: 0.3, segments: 4, ..LEAF };
    let bottle =
        WaterBottle { diameter_m: 0.26, height_m: 0.45, empty_mass_kg: 0.75, water_mass_kg: 0.3, friction: 0.15 };
    let block = FoamBlock { height_m: 0.08, wet: true, modulus_pa: 5e4, stands_free: false };
    for (name, object) in
        [("leaf", &leaf as &dyn Object), ("foam roll", &ROLL), ("bottle", &bottle), ("foam block", &block)]
    {
        let mut rig = rig();
        rig.add_object(object);
        let mut structure = object.structure(9.81);
        for body in &mut structure.bodies {
            body.inertia.mass_kg *= mass_ratio;
            body.inertia.principal_kg_m2 *= mass_ratio;
            // Multibodies know no drag.
            body.drag = None;
        }
        subjects.push((name, Tree::of_structure(&structure, WorldPose::IDENTITY), rig));
    }
    let mut arm = Arm::cody()?;
    let mut arm_rig = rig();
    arm_rig.add_arm(&arm);
    let posture_rad = arm.start_posture_rad();
    for link in &mut arm.links {
        link.mass_kg *= mass_ratio;
        link.inertia_link *= mass_ratio;
    }
    subjects.push(("arm", Tree::of_arm(&arm, &posture_rad), arm_rig));
    let mut trees = Vec::new();
    for (name, tree, rig) in subjects {
        let described = rig.describe().into_iter().find(|links| links.len() == tree.links().len());
        let links = described.ok_or_else(|| Fault::Run(format!("no {name} on the rig")))?;
        trees.push((name, tree, stacked(&links)));
    }
    let compared = trees.par_iter().flat_map_iter(|(name, tree, links)| {
        let quantity = format!("accelerations of the {name} over the largest");
        let apart = accelerations_apart(tree, links, gravity_m_per_s2);
        let accelerations = Comparison::of(quantity, "", 0.0, apart).absolute(1e-9, "1e-9: rounding of both");
        // A foam block has one axis, and its mass hardly counts beside its springs: its accelerations say all.
        let motion = (tree.coordinates.len() > 1).then(|| {
            let quantity = format!("free motion of the {name}, largest difference");
            let apart = motions_apart(tree, links, gravity_m_per_s2);
            let reason = "1e-6: both are of the first order, but Rapier takes Coriolis forces at the end of the step";
            Comparison::of(quantity, "rad or m", 0.0, apart).absolute(MOTION_BOUND, reason)
        });
        [Some(accelerations), motion].into_iter().flatten()
    });
    Ok(compared.collect())
}

fn rig() -> Rig {
    Rig::new(PhysicsOptions { step_s: INSTANT_S, gravity_m_per_s2: GRAVITY_M_PER_S2 })
}

/// The largest difference of the accelerations in random states, over the largest acceleration of the state.
fn accelerations_apart(tree: &Tree, links: &[LinkDescription], gravity_m_per_s2: f64) -> f64 {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut worst = 0.0_f64;
    for _ in 0..STATES {
        let size = tree.coordinates.len();
        let mut draw =
            |size_of: f64| -> Vec<f64> { (0..size).map(|_| random.random_range(-size_of..size_of)).collect() };
        let (displacement, velocity) = (draw(0.3), draw(3.0));
        let own = prepared(tree, &displacement, &velocity, INSTANT_S, gravity_m_per_s2);
        let mut peer = Peer::new(links, INSTANT_S);
        peer.set(&displacement, &velocity);
        peer.world.step();
        let expected = peer.accelerations();
        let largest = expected.iter().fold(0.0_f64, |largest, value| largest.max(value.abs()));
        let apart = own.acceleration().iter().zip(&expected).map(|(own, other)| (own - other).abs());
        worst = larger(worst, apart.fold(0.0, larger) / largest);
    }
    worst
}

/// The largest difference of the displacements along a free motion from a bent state. The motion ends early at ten times the bound,
/// because the rest could only raise it.
fn motions_apart(tree: &Tree, links: &[LinkDescription], gravity_m_per_s2: f64) -> f64 {
    let size = tree.coordinates.len();
    // Angles of 1 to 3 degrees and displacements of 1 mm. If the shell of a roll starts centimetres away from rest,
    // the motions differ by 3.3 mm, and by 1.0 mm in steps of 5 µs: of the first order in the step.
    let bent = |(at, own): (usize, &Coordinate)| if own.turns { 0.02 * (1.0 + at as f64 % 3.0) } else { 0.001 };
    let displacement: Vec<f64> = tree.coordinates.iter().enumerate().map(bent).collect();
    let velocity = vec![0.1; size];
    let mut tree = tree.clone();
    for branch in tree.coordinates.iter_mut().filter_map(|own| own.spring.maxwell.as_mut()) {
        // Multibodies have no relaxing branches.
        branch.relaxation_time_s = f64::INFINITY;
    }
    let mut own = prepared(&tree, &displacement, &velocity, STEP_S, gravity_m_per_s2);
    let mut peer = Peer::new(links, STEP_S);
    peer.set(&displacement, &velocity);
    let mut worst = 0.0_f64;
    for _ in 0..(MOTION_S / STEP_S) as usize {
        own.advance();
        own.begin(STEP_S, Theta::EULER);
        own.prepare(gravity_m_per_s2);
        peer.world.step();
        let positions = own.coordinates.iter().map(|own| own.position).zip(peer.positions());
        worst = positions.map(|(own, other)| (own - other).abs()).fold(worst, larger);
        if worst.is_nan() || worst > 10.0 * MOTION_BOUND {
            break;
        }
    }
    worst
}

/// The tree after displacements and with velocities, prepared for a step.
fn prepared(tree: &Tree, displacement: &[f64], velocity: &[f64], step_s: f64, gravity_m_per_s2: f64) -> Tree {
    let mut tree = tree.clone();
    tree.displace(|_, at| displacement[at]);
    for (own, velocity) in tree.coordinates.iter_mut().zip(velocity) {
        own.velocity = *velocity;
        own.dashpot = 0.0;
    }
    tree.begin(step_s, Theta::EULER);
    tree.prepare(gravity_m_per_s2);
    tree
}

/// The same links with a massless one between two rotations of a joint: multibodies have joints with one or three.
fn stacked(links: &[LinkDescription]) -> Vec<LinkDescription> {
    let mut stacked: Vec<LinkDescription> = Vec::new();
    let mut place = Vec::new();
    for link in links {
        let mut own = link.clone();
        own.parent = link.parent.map(|parent| place[parent]);
        if let [(first, _), _] = own.axes[..]
            && first >= 3
        {
            let mut between = own.clone();
            (between.link.mass_kg, between.link.inertia_link) = (0.0, DMat3::ZERO);
            own.axes = between.axes.split_off(1);
            (own.parent, own.joint_frames[0]) = (Some(stacked.len()), own.joint_frames[1]);
            stacked.push(between);
        }
        place.push(stacked.len());
        stacked.push(own);
    }
    stacked
}

/// The same bodies and joints as a multibody of Rapier.
struct Peer {
    world: PhysicsWorld,
    joint: MultibodyJointHandle,
    /// Link and axis of each coordinate.
    axes: Vec<(usize, usize)>,
}

impl Peer {
    fn new(links: &[LinkDescription], step_s: f64) -> Self {
        let mut world = PhysicsWorld {
            gravity: DVec3::Z * -GRAVITY_M_PER_S2,
            integration_parameters: IntegrationParameters {
                dt: step_s,
                num_solver_iterations: 1,
                ..Default::default()
            },
            ..PhysicsWorld::new()
        };
        let mut handles: Vec<RigidBodyHandle> = Vec::new();
        let mut joint = MultibodyJointHandle::invalid();
        let mut axes = Vec::new();
        for (index, own) in links.iter().enumerate() {
            let builder = if own.fixed { RigidBodyBuilder::fixed() } else { RigidBodyBuilder::dynamic() };
            let body = builder.pose(pose(&own.link.pose_world)).gravity_scale(own.gravity_scale).can_sleep(false);
            // The mass is that of a shape that touches nothing: added to the body itself, its axes might be changed.
            let shape = ColliderBuilder::ball(1e-3)
                .mass_properties(mass(&own.link))
                .collision_groups(InteractionGroups::none());
            let (body, _) = world.insert(body, shape);
            if let Some(parent) = own.parent {
                let free = own.axes.iter().fold(JointAxesMask::empty(), |mask, (axis, _)| {
                    mask | JointAxesMask::from_bits_truncate(1 << *axis)
                });
                let mut data = GenericJoint::new(JointAxesMask::all().difference(free));
                data.set_local_frame1(pose(&own.joint_frames[0])).set_local_frame2(pose(&own.joint_frames[1]));
                if let Some(handle) = world.multibody_joints.insert(handles[parent], body, data, true) {
                    joint = handle;
                }
                axes.extend(own.axes.iter().map(|(axis, _)| (index, *axis)));
            }
            handles.push(body);
        }
        let mut peer = Peer { world, joint, axes };
        peer.set_springs(links);
        peer
    }

    fn set_springs(&mut self, links: &[LinkDescription]) {
        for body in self.world.bodies.iter_mut().map(|(_, body)| body) {
            body.recompute_mass_properties_from_colliders(&self.world.colliders);
        }
        let Some((tree, _)) = self.world.multibody_joints.get_mut(self.joint) else { return };
        // Drops the six degrees of freedom of the fixed root, because the vectors are indexed by the others.
        tree.forward_kinematics(&self.world.bodies, true);
        let described = links.iter().flat_map(|link| &link.axes);
        let mut displacement = vec![0.0; tree.ndofs()];
        for (degree, ((axis, own), (link, _))) in described.zip(&self.axes).enumerate() {
            if let Some(link) = tree.link_mut(*link) {
                link.joint.set_spring(*axis, own.spring.unrelaxed_stiffness(), own.spring.rest);
            }
            tree.damping_mut()[degree] = own.spring.damping;
            tree.armature_mut()[degree] = own.spring.armature;
            displacement[degree] = own.position;
        }
        tree.apply_displacements(&displacement);
        tree.forward_kinematics(&self.world.bodies, true);
    }

    fn set(&mut self, displacement: &[f64], velocity: &[f64]) {
        let Some((tree, _)) = self.world.multibody_joints.get_mut(self.joint) else { return };
        tree.apply_displacements(displacement);
        for (own, value) in tree.generalized_velocity_mut().iter_mut().zip(velocity) {
            *own = *value;
        }
        tree.forward_kinematics(&self.world.bodies, true);
        tree.update_rigid_bodies(&mut self.world.bodies, true);
    }

    fn accelerations(&self) -> Vec<f64> {
        let tree = self.world.multibody_joints.get(self.joint);
        tree.map_or(Vec::new(), |(tree, _)| tree.generalized_acceleration().iter().copied().collect())
    }

    fn positions(&self) -> impl Iterator<Item = f64> + '_ {
        let tree = self.world.multibody_joints.get(self.joint).map(|(tree, _)| tree);
        self.axes.iter().map(move |(link, axis)| {
            tree.and_then(|tree| tree.link(*link)).map_or(f64::NAN, |link| link.joint.coords()[*axis])
        })
    }
}

fn pose(pose: &WorldPose) -> Pose {
    Pose::from_parts(pose.position, pose.orientation)
}

/// Mass and inertia. The smallest principal moment comes first: where Rapier's library takes moments for equal, it gives
/// the first axis the smallest.
fn mass(link: &Link) -> MassProperties {
    let inertia = Matrix3::from_column_slice(&link.inertia_link.to_cols_array());
    let SymmetricEigen { eigenvalues, eigenvectors } = SymmetricEigen::new(inertia);
    let mut order = [0, 1, 2];
    order.sort_by(|first, second| eigenvalues[*first].total_cmp(&eigenvalues[*second]));
    let [first, second, third] = order.map(|own| DVec3::from_slice(eigenvectors.column(own).as_slice()));
    let third = if first.cross(second).dot(third) < 0.0 { -third } else { third };
    MassProperties::with_principal_inertia_frame(
        link.center_of_mass_link,
        link.mass_kg,
        DVec3::from_array(order.map(|own| eigenvalues[own])).max(DVec3::ZERO),
        DQuat::from_mat3(&DMat3::from_cols(first, second, third)).normalize(),
    )
}
