//! This project's side of `benches/peers/compare.py` and `slide.py`: writes the sweep as JSON, read back from the
//! engine, or runs it and writes the forces on the arm and the processor time.
//!
//!     foliage_peer setup LEAVES LAYOUT
//!     foliage_peer run LEAVES LAYOUT STEP_S DORMANCY(true|false)
//!     foliage_peer windows LEAVES LAYOUT FRAMES REFERENCE_STEP_S STEP_S…
//!     foliage_peer statics
//!     foliage_peer slide SEGMENTS STEP_S ROTATION_DEG SLOPE_DEG SPEED_M_PER_S SKIN(true|false)
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

use std::io::Write;
use std::time::Instant;

use glam::DVec3;
use serde_json::{Value, json};
use underbrush_recording::{BodyShape, Pose};
use underbrush_sim::physics::{ENGINE, PhysicsOptions};
use underbrush_sim::scene::PhysicsSection;
use underbrush_sim::simulation::Simulation;
use underbrush_sim::simulation::test_rig::{BodyId, ColliderDescription, LinkDescription, Rig};

use slide::{Case, slide};
use sweep::Sweep;

mod slide;
mod sweep;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let result = match words[..] {
        ["setup", leaves, layout] => setup(&sweep_of(leaves, layout)),
        ["run", leaves, layout, step_s, dormancy] => {
            let options = PhysicsOptions { step_s: step_s.parse().unwrap(), ..PhysicsSection::default().options() };
            run(bare(sweep_of(leaves, layout)), options, dormancy.parse().unwrap())
        }
        ["windows", leaves, layout, frames, reference_step_s, ref steps_s @ ..] => {
            let options =
                PhysicsOptions { step_s: reference_step_s.parse().unwrap(), ..PhysicsSection::default().options() };
            let steps_s: Vec<f64> = steps_s.iter().map(|step_s| step_s.parse().unwrap()).collect();
            windows(bare(sweep_of(leaves, layout)), options, frames.parse().unwrap(), &steps_s)
        }
        ["statics"] => statics(),
        ["slide", segments, step_s, rotation_deg, slope_deg, speed_m_per_s, has_skin] => {
            let case = Case {
                segments: segments.parse().unwrap(),
                rotation_rad: rotation_deg.parse::<f64>().unwrap().to_radians(),
                slope_rad: slope_deg.parse::<f64>().unwrap().to_radians(),
                speed_m_per_s: speed_m_per_s.parse().unwrap(),
                has_skin: has_skin.parse().unwrap(),
            };
            slide(&case, step_s.parse().unwrap())
        }
        _ => panic!("see the head of benches/peers/underbrush.rs"),
    };
    serde_json::to_writer(std::io::stdout().lock(), &result).unwrap();
    std::io::stdout().flush().unwrap();
}

fn sweep_of(leaves: &str, layout: &str) -> Sweep {
    Sweep::new(leaves.parse().unwrap(), layout.parse().unwrap())
}

fn run(sweep: Sweep, options: PhysicsOptions, dormancy: bool) -> Value {
    let mut simulation = sweep.simulation(options, dormancy);
    let mut forces = Vec::with_capacity(Sweep::frames());
    let mut angles = Vec::with_capacity(Sweep::frames());
    let mut active = 0;
    let start = processor_time_s();
    Sweep::run(&mut simulation, |report| {
        active += report.objects.iter().filter(|object| object.active).count();
        forces.push(sweep::force_on_links(report));
        angles.push(report.joint_angle_rad());
    });
    let cost_s = processor_time_s() - start;
    json!({
        "engine": ENGINE,
        "processor_time_s": cost_s,
        "mean_active_leaves": active as f64 / Sweep::frames() as f64,
        "force_on_links_n": forces.iter().map(|links| links.iter().map(|f| f.to_array()).collect()).collect::<Vec<Vec<_>>>(),
        "joint_angle_rad": angles,
    })
}

/// The forces of a sweep at a fine step, and the forces of copies of it that continue with each of the other steps. The
/// copies start again every `frames` frames.
fn windows(sweep: Sweep, options: PhysicsOptions, frames: usize, steps_s: &[f64]) -> Value {
    let mut reference = sweep.simulation(options, true);
    let (mut own, mut others) = (Vec::new(), vec![Vec::new(); steps_s.len()]);
    let equilibrium_rad: Vec<Vec<f64>> =
        (0..Sweep::frames()).map(|frame| Sweep::equilibrium_rad(reference.arm(), frame)).collect();
    let continued = |simulation: &mut Simulation, window: &[Vec<f64>], forces: &mut Vec<Vec<[f64; 3]>>| {
        for angles in window {
            let links = sweep::force_on_links(simulation.step(angles));
            forces.push(links.iter().map(DVec3::to_array).collect());
        }
    };
    for window in equilibrium_rad.chunks(frames) {
        for (step_s, forces) in steps_s.iter().zip(&mut others) {
            let mut copy = reference.clone();
            copy.set_step(*step_s);
            continued(&mut copy, window, forces);
        }
        continued(&mut reference, window, &mut own);
    }
    json!({ "reference": own, "restarted": others })
}

/// How the first leaf of the sweep bends under a force at its tip, how fast it vibrates when released, and how far a
/// force at the wrist moves the arm.
fn statics() -> Value {
    let options = PhysicsOptions { step_s: 2.5e-4, ..PhysicsSection::default().options() };
    // The softest leaf's damping ratio is over 0.05 at about 3 Hz: after this time e^-9 of a vibration is left.
    let settle = (10.0 / options.step_s) as usize;
    let sweep = Sweep::new(1, 0);
    let (mut rig, links, leaves) = rig(&sweep, options);
    let leaf = &sweep.clutter.objects[0];
    let tip = *leaves[0].last().unwrap();
    let tip_world = leaf.foot_world + DVec3::Z * leaf.object.size().1;
    let tip_of_body = rig.pose_world(tip).inverse_transform_point(tip_world);
    let across = rig.pose_world(tip).transform_vector(DVec3::X);
    let along = rig.pose_world(tip).transform_vector(DVec3::Y);
    let mut pushes = Vec::new();
    for force in [across * 0.05, along * 0.05] {
        let displacement = push(&mut rig, tip, force, tip_of_body, settle) - tip_world;
        pushes.push(json!({"force_world_n": force.to_array(), "displacement_world_m": displacement.to_array()}));
    }
    // The leaf is released after a push across the blade, because that vibration is the slower one.
    push(&mut rig, tip, across * 0.05, tip_of_body, settle);
    let swing: Vec<f64> = (0..(2.0 / options.step_s) as usize)
        .map(|_| (push(&mut rig, tip, DVec3::ZERO, tip_of_body, 1) - tip_world).dot(across))
        .collect();
    let wrist = links[sweep.arm.link_index("wrist").unwrap()];
    let force = DVec3::new(-3.0, 4.0, 5.0);
    push(&mut rig, wrist, force, DVec3::ZERO, settle);
    let arm = &rig.describe()[0];
    let angles: Vec<f64> = arm.iter().flat_map(|link| &link.axes).map(|(_, own)| own.position).collect();
    json!({
        "step_s": options.step_s,
        "tip_body": tip.0,
        "tip_of_body_m": tip_of_body.to_array(),
        "pushes": pushes,
        "swing_m": swing,
        "wrist_body": wrist.0,
        "wrist_force_world_n": force.to_array(),
        "joint_angle_rad": angles,
    })
}

/// The arm and all leaves of a sweep, at rest: its links and the bodies of each leaf.
fn rig(sweep: &Sweep, options: PhysicsOptions) -> (Rig, Vec<BodyId>, Vec<Vec<BodyId>>) {
    let mut rig = Rig::new(options);
    let links = rig.add_arm(&sweep.arm);
    let leaves = sweep.clutter.objects.iter();
    let leaves = leaves.map(|leaf| rig.add_object_at(leaf.object.as_ref(), leaf.foot_world, leaf.yaw_rad));
    let leaves = leaves.collect();
    (rig, links, leaves)
}

/// Pushes a body at one of its points for `steps` steps and returns the final position of that point, m, world frame.
fn push(rig: &mut Rig, body: BodyId, force_world: DVec3, point_body: DVec3, steps: usize) -> DVec3 {
    for _ in 0..steps {
        let point = rig.pose_world(body).transform_point(point_body);
        rig.push(body, force_world, point, DVec3::ZERO);
        rig.step();
    }
    rig.pose_world(body).transform_point(point_body)
}

/// The sweep without skin: the other engine does not simulate skin, so it must not count in the processor time.
fn bare(mut sweep: Sweep) -> Sweep {
    sweep.arm.skin.layout.patches.clear();
    sweep.arm.skin.surfaces.clear();
    sweep
}

/// Processor time of this thread, s; wall time if the system does not report it.
fn processor_time_s() -> f64 {
    thread_local!(static START: Instant = Instant::now());
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok())
        .map_or_else(|| START.with(Instant::elapsed).as_secs_f64(), |nanoseconds| nanoseconds * 1e-9)
}

/// Everything that another engine needs to run the same sweep, read from the engine's own bodies and joints.
fn setup(sweep: &Sweep) -> Value {
    let options = PhysicsSection::default().options();
    let (mut rig, links, _) = rig(sweep, options);
    let mut setup = bodies_and_joints(&mut rig);
    setup["arm"] = arm(sweep, &links);
    setup["equilibrium_rad"] = (0..Sweep::frames()).map(|frame| Sweep::equilibrium_rad(&sweep.arm, frame)).collect();
    setup
}

/// The bodies and joints of a rig, and the engine's settings.
fn bodies_and_joints(rig: &mut Rig) -> Value {
    let options = rig.physics();
    let trees = rig.describe();
    let trees: Vec<Vec<Value>> = trees.iter().map(|tree| tree.iter().map(link).collect()).collect();
    json!({
        "engine": ENGINE,
        "frame_period_s": underbrush_recording::FRAME_PERIOD_S,
        "gravity_m_per_s2": options.gravity_m_per_s2,
        "default_step_s": options.step_s,
        "trees": trees,
    })
}

/// Which bodies are the arm's, and the limits of its joints' torques.
fn arm(sweep: &Sweep, links: &[BodyId]) -> Value {
    json!({
        "bodies": links.iter().map(|link| link.0).collect::<Vec<_>>(),
        "links": sweep.arm.links.iter().map(|link| &link.name).collect::<Vec<_>>(),
        "torque_limit_nm": sweep.arm.joints.iter().map(|joint| joint.torque_limit_nm).collect::<Vec<_>>(),
        "start_rad": sweep.arm.start_posture_rad(),
    })
}

fn link(link: &LinkDescription) -> Value {
    let axes = link.axes.iter().map(|(axis, own)| {
        json!({
            "axis": axis,
            "coordinate": own.position,
            "stiffness": own.spring.unrelaxed_stiffness(),
            "rest": own.spring.rest,
            "damping": own.spring.damping,
            "armature": own.spring.armature,
            "limits": own.stop.map(|stop| stop.limits_rad),
        })
    });
    json!({
        "body": link.body,
        "parent": link.parent,
        "fixed": link.fixed,
        "pose_world": pose(&link.link.pose_world),
        "gravity_scale": link.gravity_scale,
        "mass_kg": link.link.mass_kg,
        "center_of_mass": link.link.center_of_mass_link.to_array(),
        "inertia_kg_m2": link.link.inertia_link.to_cols_array(),
        "joint_frame_parent": pose(&link.joint_frames[0]),
        "joint_frame_child": pose(&link.joint_frames[1]),
        "axes": axes.collect::<Vec<_>>(),
        "colliders": link.colliders.iter().map(collider).collect::<Vec<_>>(),
    })
}

fn collider(collider: &ColliderDescription) -> Value {
    let shape = match &collider.part.shape {
        BodyShape::Sphere { radius_m } => json!({"sphere": {"radius_m": radius_m}}),
        BodyShape::Box { size_m } => json!({"box": {"half_size_m": (*size_m / 2.0).to_array()}}),
        BodyShape::Cylinder { radius_m, length_m } => {
            json!({"cylinder_z": {"radius_m": radius_m, "half_length_m": length_m / 2.0}})
        }
        BodyShape::Capsule { radius_m, length_m } => {
            let end = DVec3::Z * (length_m / 2.0);
            json!({"capsule": {"radius_m": radius_m, "start_m": (-end).to_array(), "end_m": end.to_array()}})
        }
        BodyShape::Hull { points_m } => {
            json!({"hull": {"points_m": points_m.iter().map(|point| point.to_array()).collect::<Vec<_>>()}})
        }
    };
    json!({
        "shape": shape,
        "pose_body": pose(&collider.part.pose_body),
        "friction": collider.friction,
        "memberships": collider.groups[0],
        "filter": collider.groups[1],
    })
}

/// Position, m, and orientation as (w, x, y, z).
fn pose(pose: &Pose) -> Value {
    let rotation = pose.orientation;
    json!({
        "position_m": pose.position.to_array(),
        "orientation_wxyz": [rotation.w, rotation.x, rotation.y, rotation.z],
    })
}
