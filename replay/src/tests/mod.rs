//! Tests of the packed bytes, the single file and the server, on a small reach.
#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

mod http;
mod live;
mod pack;
mod server;
mod single_file;
mod touch;
mod trial_table;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use underbrush_recording::disk::write_recording;
use underbrush_recording::{
    Audit, Body, BodyOwner, BodyPart, BodyShape, Category, Contact, Frame, GoalRecord, Grid, MappedObstacle,
    ObjectRecord, ObstacleKind, Outcome, Patch, Pose, Recording, SkinLayout, Taxel, TaxelReading,
};

use crate::{ReplayContext, Source};

/// Made-up values of what the command line knows.
pub const KNOWN: ReplayContext = ReplayContext {
    force_limit_n: |controller| (controller == "cody-2013").then_some(3.0),
    stated_limit_n: None,
    audit_warnings: |audit, _| match audit.deepest_penetration_m > 0.01 {
        true => vec!["too deep".into()],
        false => Vec::new(),
    },
};

/// A reach of `frames` frames with one link that moves along x, a trunk, and a patch of 2 × 2 taxels. Taxel 1 is
/// pressed from frame 5 on, counted from 0, and taxel 2 reads a force in frame 7 although nothing presses it.
pub fn reach(reach_index: u64, frames: usize) -> Recording {
    let taxel = |x: f64| Taxel {
        position_link: DVec3::new(x, 0.02, 0.0),
        normal_link: DVec3::Y,
        tangent_link: DVec3::X,
        area_m2: 1e-4,
    };
    let pose = |frame: usize| Pose::new(DVec3::new(frame as f64 / 1024.0, 0.0, 0.25), DQuat::IDENTITY);
    let reading = |taxel, force_n, object: Option<u16>| TaxelReading {
        patch: 0,
        taxel,
        true_normal_force_n: if object.is_some() { force_n } else { 0.0 },
        true_shear_force_n: if object.is_some() { [0.25, -0.5] } else { [0.0; 2] },
        sensed_force_n: force_n,
        object,
    };
    let frame = |index: usize| Frame {
        time_s: index as f64 * 0.01,
        joint_angle_rad: vec![0.1],
        joint_velocity_rad_per_s: vec![0.0],
        equilibrium_angle_rad: vec![0.2],
        joint_torque_nm: vec![1.5],
        end_effector_pose_world: pose(index),
        goal_position_world: DVec3::new(0.5, 0.0, 0.0),
        goal_index: 0,
        patch_pose_world: vec![pose(index)],
        contact_force_world: vec![DVec3::ZERO],
        taxels: match index {
            0..5 => Vec::new(),
            7 => vec![reading(1, 2.0, Some(0)), reading(2, 0.5, None)],
            _ => vec![reading(1, 2.0, Some(0))],
        },
        contact_points: Vec::new(),
    };
    let mut link = Body {
        owner: BodyOwner::Link("forearm".into()),
        parts: vec![BodyPart { shape: BodyShape::Sphere { radius_m: 0.02 }, pose_body: Pose::IDENTITY }],
        rest_pose_world: pose(0),
        track: Vec::new(),
    };
    (0..frames).for_each(|index| link.observe(index as u32, &pose(index)));
    Recording {
        scene: "trunk".into(),
        controller: "cody-2013".into(),
        seed: u64::MAX,
        reach_index,
        rate_hz: 100.0,
        joint_names: vec!["shoulder".into()],
        layout: SkinLayout {
            patches: vec![Patch {
                name: "forearm".into(),
                link: "forearm".into(),
                grid: Some(Grid { rows: 2, columns: 2, wraps: false }),
                taxels: [0.0, 0.01, 0.02, 0.03].map(taxel).to_vec(),
            }],
        },
        objects: vec![ObjectRecord {
            kind: "trunk".into(),
            category: Category::TRUNK,
            position_world: DVec3::new(0.4, 0.1, -0.3),
            parameters: BTreeMap::from([("height_m".to_owned(), 0.4)]),
        }],
        bodies: vec![link],
        goals: vec![GoalRecord {
            position_world: DVec3::new(0.5, 0.0, 0.0),
            start_time_s: 0.0,
            end_time_s: frames as f64 * 0.01,
            outcome: Outcome::Stuck,
            safety_stop: None,
            given_up: None,
        }],
        contacts: vec![Contact {
            link: "forearm".into(),
            patch: Some(0),
            object: 0,
            first_frame: 5,
            last_frame: frames as u32 - 1,
            peak_force_n: 2.0,
            mean_force_n: 2.0,
        }],
        map: vec![MappedObstacle {
            kind: ObstacleKind::Fixed,
            top_world: DVec3::new(0.41, 0.1, 0.1),
            radius_m: 0.018,
            deviation_m: 0.006,
            first_frame: 8,
            last_frame: frames as u32 - 1,
        }],
        frames: (0..frames).map(frame).collect(),
        audit: Audit::default(),
    }
}

/// A recording in a file of this folder.
pub fn written(folder: &Path, reach_index: u64) -> PathBuf {
    let path = folder.join(format!("reach-{reach_index}.parquet"));
    write_recording(&path, &reach(reach_index, 20)).unwrap();
    path
}

/// The source of two recordings in this folder.
pub fn source(folder: &Path) -> Source {
    let paths = [written(folder, 0), written(folder, 1)];
    Source::open(&paths, KNOWN, None).unwrap()
}
