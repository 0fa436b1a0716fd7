//! Tests of the disk formats, and a small reach for them.

mod categories;
pub(crate) mod dataset;
mod dictionary;
mod finish;
mod flips;
mod generated;
mod merge;
mod peak_forces;
mod plain_pages;
mod recording;
mod row_groups;
mod shared;
mod trials;
mod whole_file;

use std::collections::BTreeMap;

use glam::{DQuat, DVec3, Vec3};

use crate::{
    Audit, Body, BodyOwner, BodyPart, BodyShape, Category, Contact, ContactPoint, Frame, GoalRecord, Grid,
    MappedObstacle, ObjectRecord, ObstacleKind, Outcome, Patch, Pose, Recording, SkinLayout, Taxel, TaxelReading,
};

/// The name of a field in an error, and a change that makes it invalid.
type Change<T> = (&'static str, fn(&mut T));

/// A link that moves for the first second.
fn link(offset: f64, frames: usize) -> Body {
    let pose = |frame: usize| Pose {
        position: DVec3::new(frame.min(100) as f64 * 0.002, offset, 0.3),
        orientation: DQuat::from_rotation_z(frame.min(100) as f64 * 0.01),
    };
    let mut body = Body {
        owner: BodyOwner::Link("forearm_link".into()),
        parts: vec![BodyPart { shape: BodyShape::Capsule { radius_m: 0.046, length_m: 0.2 }, pose_body: pose(0) }],
        rest_pose_world: pose(0),
        track: Vec::new(),
    };
    (0..frames).for_each(|frame| body.observe(frame as u32, &pose(frame)));
    body
}

/// The only body of an object, at rest.
fn stem(object: u16) -> Body {
    Body { owner: BodyOwner::Object(object), parts: Vec::new(), ..link(0.1 * f64::from(object), 0) }
}

/// A small smooth reach: two joints, a sleeve of 3 × 4 taxels, one taxel at the tip, and `frames` samples at 100 Hz.
pub(super) fn reach(reach_index: u64, frames: usize) -> Recording {
    let taxel = |angle: f64| Taxel {
        position_link: DVec3::new(0.046 * angle.cos(), 0.046 * angle.sin(), 0.01),
        normal_link: DVec3::new(angle.cos(), angle.sin(), 0.0),
        tangent_link: DVec3::Z,
        area_m2: 8.1e-5,
    };
    let patch = |name: &str, taxels: usize, grid| Patch {
        name: name.into(),
        link: format!("{name}_link"),
        grid,
        taxels: (0..taxels).map(|index| taxel(index as f64 / 2.0)).collect(),
    };
    let sleeve = patch("forearm", 12, Some(Grid { rows: 3, columns: 4, wraps: true }));
    let layout = SkinLayout { patches: vec![sleeve, patch("tip", 1, None)] };
    let object = |kind: &str, category, x| ObjectRecord {
        kind: kind.into(),
        category,
        position_world: DVec3::new(x, 0.1, -0.3),
        parameters: BTreeMap::from([("height_m".to_string(), 0.3 + x)]),
    };
    let offset = reach_index as f64 * 0.01;
    let frame = |index: usize| {
        let time_s = index as f64 * 0.01;
        let force = (3.0 * time_s).sin().max(0.0) * (1.0 + offset);
        let reading = |patch, taxel, object| TaxelReading {
            patch,
            taxel,
            true_normal_force_n: force,
            true_shear_force_n: [0.1 * force, -0.2 * force],
            sensed_force_n: f64::from((force * 100.0).round() as f32 / 100.0),
            object: Some(object),
        };
        let point = |patch, object: u16| ContactPoint {
            link: 0,
            patch,
            object: Some(object),
            body: 1 + object,
            position_world: DVec3::new(0.4, time_s, offset).as_vec3(),
            normal_world: Vec3::NEG_X,
            force_world: (DVec3::NEG_X * force).as_vec3(),
            moment_world: Vec3::X * 1e-4,
            slip_world: Vec3::Y * 0.02,
            depth_m: 1e-4 * force as f32,
            area_m2: 2e-5,
        };
        let pose = Pose { position: DVec3::new(time_s, offset, 0.3), orientation: DQuat::from_rotation_z(time_s) };
        Frame {
            time_s,
            joint_angle_rad: vec![time_s.sin() + offset, time_s.cos()],
            joint_velocity_rad_per_s: vec![time_s.cos(), -time_s.sin()],
            equilibrium_angle_rad: vec![time_s.sin() + offset + 0.1, time_s.cos()],
            joint_torque_nm: vec![2.0, -0.5 * time_s],
            end_effector_pose_world: pose,
            goal_position_world: DVec3::new(0.5, 0.1, -0.1),
            goal_index: 0,
            patch_pose_world: vec![pose; 2],
            contact_force_world: vec![DVec3::new(-force, 0.0, 0.0), DVec3::ZERO],
            taxels: if force > 0.0 { vec![reading(0, 5, 1), reading(0, 6, 1), reading(1, 0, 0)] } else { Vec::new() },
            contact_points: if force > 0.0 { vec![point(Some(0), 1), point(None, 0)] } else { Vec::new() },
        }
    };
    Recording {
        scene: "foliage".into(),
        controller: "cody-2013".into(),
        seed: 7,
        reach_index,
        rate_hz: 100.0,
        joint_names: vec!["shoulder".into(), "elbow".into()],
        layout,
        objects: vec![object("trunk", Category::TRUNK, 0.2), object("leaf", Category::LEAF, 0.3 + offset)],
        bodies: vec![link(offset, frames), stem(0), stem(1)],
        goals: vec![GoalRecord {
            position_world: DVec3::new(0.5, 0.1, -0.1),
            start_time_s: 0.0,
            end_time_s: frames as f64 * 0.01,
            outcome: if reach_index.is_multiple_of(2) { Outcome::Reached } else { Outcome::Stuck },
            safety_stop: None,
            given_up: None,
        }],
        map: vec![MappedObstacle {
            kind: ObstacleKind::Fixed,
            top_world: DVec3::new(0.4, offset, 0.1),
            radius_m: 0.018,
            deviation_m: 0.006,
            first_frame: 1,
            last_frame: 3,
        }],
        contacts: vec![Contact {
            link: "forearm_link".into(),
            patch: Some(0),
            object: 1,
            first_frame: 1,
            last_frame: frames as u32 - 1,
            peak_force_n: 2.0 + offset,
            mean_force_n: 1.25,
        }],
        frames: (0..frames).map(frame).collect(),
        audit: Audit {
            largest_force_residual: 1e-9,
            rest_frames: 7 + reach_index as u32,
            controller_steps: 10 + reach_index as u32,
            infeasible_controller_steps: 2,
            failed_controller_steps: 1,
            energy_residual: 0.01 + offset,
            ..Audit::default()
        },
    }
}
