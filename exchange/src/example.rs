//! A small reach for tests.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use underbrush_recording::{
    Audit, Body, BodyOwner, BodyPart, BodyShape, Category, Frame, GoalRecord, Grid, ObjectRecord, Outcome, Patch, Pose,
    Recording, SkinLayout, Taxel, TaxelReading, math,
};

/// A file in the folder with the tests' temporary files, and the folder, which is removed when dropped.
pub(crate) fn file(name: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    (folder, path)
}

/// Writes a text file.
pub(crate) fn written(path: &Path, text: &str) -> PathBuf {
    std::fs::write(path, text).unwrap();
    path.to_path_buf()
}

fn patch(name: &str, taxels: usize, grid: Option<Grid>) -> Patch {
    let taxel = |index: usize| Taxel {
        position_link: DVec3::new(0.01 * index as f64, 0.05, 0.0),
        normal_link: DVec3::Y,
        tangent_link: DVec3::Z,
        area_m2: 1e-4,
    };
    Patch { name: name.into(), link: format!("{name}_link"), grid, taxels: (0..taxels).map(taxel).collect() }
}

fn body(owner: BodyOwner, shape: BodyShape, speed: f64, frames: usize) -> Body {
    let pose = |frame: usize| Pose::new(DVec3::new(0.0, speed * frame as f64, 0.3), DQuat::from_rotation_z(0.5));
    let mut body = Body {
        owner,
        parts: vec![BodyPart { shape, pose_body: Pose::from_position(DVec3::Z) }],
        rest_pose_world: pose(0),
        track: Vec::new(),
    };
    (0..frames).for_each(|frame| body.observe(frame as u32, &pose(frame)));
    body
}

/// A reach of two joints with a sleeve of 2 × 3 taxels and two taxels without a grid, which feel something in some
/// frames.
pub(crate) fn reach(scene: &str, reach_index: u64, frames: usize) -> Recording {
    let layout = SkinLayout {
        patches: vec![patch("sleeve", 6, Some(Grid { rows: 2, columns: 3, wraps: true })), patch("tip", 2, None)],
    };
    let frame = |index: usize| {
        let time_s = index as f64 / 100.0;
        let force_n = math::sin(7.0 * time_s + reach_index as f64) / 3.0;
        let reading = |patch, taxel, share: f64| TaxelReading {
            patch,
            taxel,
            true_normal_force_n: share * force_n,
            true_shear_force_n: [0.0; 2],
            sensed_force_n: share * force_n,
            object: Some(0),
        };
        Frame {
            time_s,
            joint_angle_rad: vec![math::sin(time_s), 0.1 / 3.0],
            joint_velocity_rad_per_s: vec![math::cos(time_s), -0.2],
            equilibrium_angle_rad: vec![math::sin(time_s) + 0.1, 0.3],
            joint_torque_nm: vec![2.0, -0.5 * time_s],
            end_effector_pose_world: Pose::new(DVec3::new(time_s, 0.2, 0.3), DQuat::from_rotation_x(time_s)),
            goal_position_world: DVec3::new(0.5, 0.1 * (index / 40) as f64, -0.1),
            goal_index: (index / 40) as u16,
            patch_pose_world: vec![Pose::IDENTITY; 2],
            contact_force_world: vec![DVec3::ZERO; 2],
            taxels: match force_n > 0.0 {
                true => vec![reading(0, 1, 1.0), reading(0, 4, 0.7), reading(1, 1, 0.3)],
                false => Vec::new(),
            },
        }
    };
    let corner = |index: usize| DVec3::new((index & 1) as f64, (index >> 1 & 1) as f64, (index >> 2) as f64);
    let hull = BodyShape::Hull { points_m: (0..8).map(corner).collect() };
    let capsule = BodyShape::Capsule { radius_m: 0.04, length_m: 0.2 };
    let goal = |number: usize, outcome| GoalRecord {
        position_world: DVec3::new(0.5, 0.1 * number as f64, -0.1),
        start_time_s: 0.4 * number as f64,
        end_time_s: 0.4 * (number + 1) as f64,
        outcome,
        safety_stop: None,
    };
    Recording {
        scene: scene.into(),
        controller: "cody-2013".into(),
        seed: u64::MAX,
        reach_index,
        rate_hz: 100.0,
        joint_names: vec!["shoulder".into(), "elbow".into()],
        layout,
        objects: vec![ObjectRecord {
            kind: "leaf".into(),
            category: Category::LEAF,
            position_world: DVec3::X,
            parameters: BTreeMap::new(),
        }],
        bodies: vec![
            body(BodyOwner::Link("sleeve_link".into()), capsule, 0.002, frames),
            body(BodyOwner::Object(0), hull, 0.0, frames),
            body(BodyOwner::Object(0), BodyShape::Box { size_m: DVec3::ONE }, 0.0005, frames),
        ],
        goals: vec![goal(0, Outcome::Reached), goal(1, Outcome::Stuck)],
        contacts: Vec::new(),
        frames: (0..frames).map(frame).collect(),
        audit: Audit::default(),
    }
}
