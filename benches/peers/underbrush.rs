//! This project's side of `benches/peers/compare.py`: writes the sweep as JSON, read back from the engine, or
//! runs it and writes the forces on the arm and the processor time.
//!
//!     foliage_peer setup LEAVES LAYOUT
//!     foliage_peer run LEAVES LAYOUT STEP_S SUBSTEPS DORMANCY(true|false)
//!     foliage_peer statics
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

use std::io::Write;
use std::time::Instant;

use glam::DVec3;
use rapier3d::prelude::*;
use serde_json::{Value, json};
use underbrush_sim::physics::{ENGINE, Physics, PhysicsOptions};
use underbrush_sim::scene::PhysicsSection;
use underbrush_sim::world::World;

use sweep::Sweep;

mod sweep;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let result = match words[..] {
        ["setup", leaves, layout] => setup(&sweep_of(leaves, layout)),
        ["run", leaves, layout, step_s, substeps, dormancy] => {
            let options = PhysicsOptions {
                step_s: step_s.parse().unwrap(),
                substeps: substeps.parse().unwrap(),
                ..PhysicsSection::default().options()
            };
            run(&sweep_of(leaves, layout), options, dormancy.parse().unwrap())
        }
        ["statics"] => statics(),
        _ => panic!("see the head of benches/peers/underbrush.rs"),
    };
    serde_json::to_writer(std::io::stdout().lock(), &result).unwrap();
    std::io::stdout().flush().unwrap();
}

fn sweep_of(leaves: &str, layout: &str) -> Sweep {
    Sweep::new(leaves.parse().unwrap(), layout.parse().unwrap())
}

fn run(sweep: &Sweep, options: PhysicsOptions, dormancy: bool) -> Value {
    let mut world = sweep.world(options, dormancy);
    let mut forces = Vec::with_capacity(Sweep::frames());
    let mut angles = Vec::with_capacity(Sweep::frames());
    let mut active = 0;
    let start = processor_time_s();
    sweep.run(&mut world, |world| {
        active += world.active_objects();
        forces.push(sweep::force_on_links(&sweep.arm, world));
        angles.push(world.arm.joint_angle_rad(&world.physics));
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

/// How the first leaf of the sweep bends under a force at its tip, how fast it swings when let go, and how the arm gives
/// under a force at its wrist.
fn statics() -> Value {
    let options = PhysicsOptions {
        step_s: 2.5e-4,
        substeps: 1,
        ..PhysicsSection::default().options()
    };
    // The softest leaf's damping ratio is over 0.05 at some 3 Hz: after this time e^-9 of a swing is left.
    let settle = (10.0 / options.step_s) as usize;
    let sweep = Sweep::new(1, 0);
    let mut world = sweep.world(options, false);
    let physics = &mut world.physics;
    let (tip, _) = physics
        .colliders
        .iter()
        .filter(|(_, collider)| collider.user_data == 1)
        .max_by(|a, b| a.1.position().translation.z.total_cmp(&b.1.position().translation.z))
        .unwrap();
    let collider = &physics.colliders[tip];
    let tip_body = collider.parent().unwrap();
    let half_height = collider.shape().compute_local_aabb().half_extents().z;
    let tip_of_body = *collider.position_wrt_parent().unwrap() * DVec3::new(0.0, 0.0, half_height);
    let tip_world = |physics: &Physics| physics.bodies[tip_body].position().transform_point(tip_of_body);
    let straight = tip_world(physics);
    let turn = physics.bodies[tip_body].position().rotation;
    let mut pushes = Vec::new();
    for force in [turn * DVec3::X * 0.05, turn * DVec3::Y * 0.05] {
        for _ in 0..settle {
            push(physics, tip_body, force, tip_of_body);
            physics.step();
        }
        let displacement = tip_world(physics) - straight;
        pushes.push(json!({"force_world_n": force.to_array(), "displacement_world_m": displacement.to_array()}));
    }
    // Let go, sideways last: the swing across the blade is the slower one, so that one is followed.
    let across = turn * DVec3::X;
    for _ in 0..settle {
        push(physics, tip_body, across * 0.05, tip_of_body);
        physics.step();
    }
    let mut swing = Vec::new();
    for _ in 0..(2.0 / options.step_s) as usize {
        push(physics, tip_body, DVec3::ZERO, tip_of_body);
        physics.step();
        swing.push((tip_world(physics) - straight).dot(across));
    }
    let wrist = world.arm.links[sweep.arm.link_index("wrist").unwrap()];
    let force = DVec3::new(-3.0, 4.0, 5.0);
    for _ in 0..settle {
        push(&mut world.physics, wrist, force, DVec3::ZERO);
        world.physics.step();
    }
    json!({
        "step_s": options.step_s,
        "tip_body": tip_body.into_raw_parts().0,
        "tip_of_body_m": tip_of_body.to_array(),
        "pushes": pushes,
        "swing_m": swing,
        "wrist_body": wrist.into_raw_parts().0,
        "wrist_force_world_n": force.to_array(),
        "joint_angle_rad": world.arm.joint_angle_rad(&world.physics),
    })
}

/// Sets the one force on a body, at a point of it.
fn push(physics: &mut Physics, body: RigidBodyHandle, force_world: DVec3, point_body: DVec3) {
    let body = &mut physics.bodies[body];
    let point = body.position().transform_point(point_body);
    // The second call takes away the torque that the force added.
    body.reset_forces(true);
    body.reset_torques(true);
    body.add_force_at_point(force_world, point, true);
}

/// Processor time of this thread, s; wall time where the system does not tell.
fn processor_time_s() -> f64 {
    thread_local!(static START: Instant = Instant::now());
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok())
        .map_or_else(
            || START.with(Instant::elapsed).as_secs_f64(),
            |nanoseconds| nanoseconds * 1e-9,
        )
}

/// Everything that another engine needs to run the same sweep, read from the engine's own bodies and joints.
fn setup(sweep: &Sweep) -> Value {
    let options = PhysicsSection::default().options();
    // Without dormancy, so that every leaf is in the engine to be read.
    let mut world = sweep.world(options, false);
    let engine = &mut world.physics;
    for (_, body) in engine.bodies.iter_mut() {
        // The engine would take masses up in its first step only.
        body.recompute_mass_properties_from_colliders(&engine.colliders);
    }
    let physics = &world.physics;
    let mut trees: Vec<Value> = physics
        .joints
        .multibodies()
        .map(|tree| describe(tree, physics))
        .collect();
    // The engine may list them in any order.
    trees.sort_by_key(|tree| tree[0]["body"].as_u64());
    let soft = &physics.parameters.contact_softness;
    json!({
        "engine": ENGINE,
        "frame_period_s": underbrush_recording::FRAME_PERIOD_S,
        "gravity_m_per_s2": options.gravity_m_per_s2,
        "contact_natural_frequency_hz": soft.natural_frequency,
        "contact_damping_ratio": soft.damping_ratio,
        "default_step_s": options.step_s,
        "default_substeps": options.substeps,
        "arm": arm(sweep, &world),
        "trees": trees,
        "equilibrium_rad": (0..Sweep::frames()).map(|frame| sweep.equilibrium_rad(frame)).collect::<Vec<_>>(),
    })
}

/// Which bodies are the arm's, and the limits of its joints' torques.
fn arm(sweep: &Sweep, world: &World) -> Value {
    json!({
        "bodies": world.arm.links.iter().map(|body| body.into_raw_parts().0).collect::<Vec<_>>(),
        "links": sweep.arm.links.iter().map(|link| &link.name).collect::<Vec<_>>(),
        "torque_limit_nm": sweep.arm.joints.iter().map(|joint| joint.torque_limit_nm).collect::<Vec<_>>(),
        "start_rad": sweep.arm.start_posture_rad(),
    })
}

/// One multibody, link by link from the root.
fn describe(tree: &Multibody, physics: &Physics) -> Value {
    tree.links()
        .map(|link| {
            let handle = link.rigid_body_handle();
            let body = &physics.bodies[handle];
            let mass = body.mass_properties().local_mprops;
            let inertia = mass.reconstruct_inertia_matrix();
            let joint = &link.joint.data;
            let locked = joint.locked_axes.bits();
            let axes: Vec<Value> = (0..6)
                .filter(|axis| link.parent_id().is_some() && locked & (1 << axis) == 0)
                .enumerate()
                .map(|(number, axis)| {
                    let degree = link.assembly_id() + number;
                    let (stiffness, rest) = link.joint.spring(axis);
                    let limited = joint.limit_axes.bits() & (1 << axis) != 0;
                    json!({
                        "axis": axis,
                        "coordinate": link.joint.coords()[axis],
                        "stiffness": stiffness,
                        "rest": rest,
                        "damping": tree.damping()[degree],
                        "armature": tree.armature()[degree],
                        "limits": limited.then(|| [joint.limits[axis].min, joint.limits[axis].max]),
                    })
                })
                .collect();
            json!({
                "body": handle.into_raw_parts().0,
                "parent": link.parent_id(),
                "fixed": !body.is_dynamic(),
                "pose_world": pose(body.position()),
                "gravity_scale": body.gravity_scale(),
                "mass_kg": mass.mass(),
                "center_of_mass": mass.local_com.to_array(),
                "inertia_kg_m2": inertia.to_cols_array(),
                "joint_frame_parent": pose(&joint.local_frame1),
                "joint_frame_child": pose(&joint.local_frame2),
                "axes": axes,
                "colliders": body.colliders().iter().map(|handle| collider(&physics.colliders[*handle])).collect::<Vec<_>>(),
            })
        })
        .collect()
}

fn collider(collider: &Collider) -> Value {
    let shape = match collider.shape().as_typed_shape() {
        TypedShape::Ball(ball) => json!({"sphere": {"radius_m": ball.radius}}),
        TypedShape::Cuboid(cuboid) => json!({"box": {"half_size_m": cuboid.half_extents.to_array()}}),
        TypedShape::Cylinder(cylinder) => {
            json!({"cylinder_y": {"radius_m": cylinder.radius, "half_length_m": cylinder.half_height}})
        }
        TypedShape::Capsule(capsule) => json!({"capsule": {
            "radius_m": capsule.radius, "start_m": capsule.segment.a.to_array(), "end_m": capsule.segment.b.to_array(),
        }}),
        TypedShape::ConvexPolyhedron(hull) => {
            json!({"hull": {"points_m": hull.points().iter().map(|point| point.to_array()).collect::<Vec<_>>()}})
        }
        other => panic!("no MuJoCo shape for {other:?}"),
    };
    let groups = collider.collision_groups();
    json!({
        "shape": shape,
        "pose_body": pose(collider.position_wrt_parent().unwrap()),
        "friction": collider.friction(),
        "memberships": groups.memberships.bits(),
        "filter": groups.filter.bits(),
    })
}

/// Position, m, and orientation as (w, x, y, z).
fn pose(pose: &Pose) -> Value {
    let turn = pose.rotation;
    json!({"position_m": pose.translation.to_array(), "orientation_wxyz": [turn.w, turn.x, turn.y, turn.z]})
}
