//! Writes a small data set as the driver of a real robot could, then reads it back, reach by reach: `cargo run -p
//! underbrush-recording --features disk --example write_a_data_set -- FOLDER [REACHES]`. A moving bump presses a
//! sleeve of 16 × 24 taxels; no physics is simulated.
//!
//! It prints the duration of each step and, on Linux, the peak memory after it. Runs with 100 and with 1000 reaches
//! show how the cost grows.

#![allow(clippy::print_stderr, reason = "an example has no other output")]

use std::collections::BTreeMap;
use std::env;
use std::error::Error;
use std::f64::consts::TAU;
use std::time::Instant;

use glam::{DQuat, DVec3};
use underbrush_recording::disk::{Dataset, DatasetPlan, DatasetWriter, PlannedEpisode, Provenance};
use underbrush_recording::{
    Audit, Body, BodyOwner, Category, Contact, Frame, GoalRecord, Grid, ObjectRecord, Outcome, Patch, Pose, Recording,
    SkinLayout, Taxel, TaxelReading,
};

const ROWS: usize = 16;
const COLUMNS: usize = 24;
const RATE_HZ: f64 = 100.0;

/// A sleeve of radius 46 mm on the forearm and a single taxel on the tip.
fn layout() -> SkinLayout {
    let taxel = |index: usize| {
        let angle = TAU * (index % COLUMNS) as f64 / COLUMNS as f64;
        let normal = DVec3::new(angle.cos(), angle.sin(), 0.0);
        Taxel {
            position_link: 0.046 * normal - DVec3::Z * (0.0942 + 0.0108 * (index / COLUMNS) as f64),
            normal_link: normal,
            tangent_link: DVec3::Z,
            area_m2: 81e-6,
        }
    };
    let grid = Grid { rows: ROWS, columns: COLUMNS, wraps: true };
    let patch = |name: &str, grid, taxels: usize| Patch {
        name: name.into(),
        link: name.into(),
        grid,
        taxels: (0..taxels).map(taxel).collect(),
    };
    SkinLayout { patches: vec![patch("forearm", Some(grid), ROWS * COLUMNS), patch("tip", None, 1)] }
}

/// One sample: a bump of up to 3 N moves along the sleeve.
fn frame(reach: u64, index: usize) -> Frame {
    let time_s = index as f64 / RATE_HZ;
    let phase = 1.3 * time_s + reach as f64;
    let centre_row = 8.0 + 6.0 * (0.5 * phase).sin();
    let press_n = (3.0 * phase.sin()).max(0.0);
    let taxels = (0..ROWS * COLUMNS).filter_map(|taxel| {
        let (row, column) = ((taxel / COLUMNS) as f64, (taxel % COLUMNS) as f64);
        let force = press_n * (-(row - centre_row).powi(2) - (column - 5.0).powi(2)).exp();
        (force > 0.02).then(|| TaxelReading {
            patch: 0,
            taxel: taxel as u16,
            true_normal_force_n: force,
            true_shear_force_n: [0.2 * force, -0.1 * force],
            sensed_force_n: (force * 1000.0).round() / 1000.0,
            object: Some((reach % 2) as u16),
        })
    });
    let joints = |shift: f64| (0..7).map(|joint| (phase + shift + joint as f64).sin()).collect::<Vec<_>>();
    let velocity = (0..7).map(|joint| 1.3 * (phase + joint as f64).cos()).collect();
    let pose =
        Pose { position: DVec3::new(0.3 + 0.05 * time_s, -0.2, 0.1), orientation: DQuat::from_rotation_z(phase) };
    Frame {
        time_s,
        joint_angle_rad: joints(0.0),
        joint_velocity_rad_per_s: velocity,
        equilibrium_angle_rad: joints(0.1),
        joint_torque_nm: joints(0.5),
        end_effector_pose_world: pose,
        goal_position_world: DVec3::new(0.5, -0.2, 0.1),
        goal_index: 0,
        patch_pose_world: vec![pose; 2],
        contact_force_world: vec![DVec3::new(-press_n, 0.0, 0.0), DVec3::ZERO],
        taxels: taxels.collect(),
        contact_points: Vec::new(),
    }
}

/// The link under the sleeve, whose pose a robot knows from its joint angles.
fn forearm(frames: &[Frame]) -> Body {
    let mut body = Body {
        owner: BodyOwner::Link("forearm".into()),
        parts: Vec::new(),
        rest_pose_world: frames[0].patch_pose_world[0],
        track: Vec::new(),
    };
    for (index, frame) in frames.iter().enumerate() {
        body.observe(index as u32, &frame.patch_pose_world[0]);
    }
    body
}

fn recording(reach: u64) -> Recording {
    let frames: Vec<Frame> = (0..400 + 20 * (reach as usize % 12)).map(|index| frame(reach, index)).collect();
    let object = |kind: &str, category, x_m| ObjectRecord {
        kind: kind.into(),
        category,
        position_world: DVec3::new(x_m, -0.2, -0.3),
        parameters: BTreeMap::from([("height_m".to_string(), 0.4)]),
    };
    let end_time_s = frames.len() as f64 / RATE_HZ;
    Recording {
        scene: "bumps".into(),
        controller: "none".into(),
        seed: 1,
        reach_index: reach,
        rate_hz: RATE_HZ,
        joint_names: (0..7).map(|joint| format!("joint_{joint}")).collect(),
        layout: layout(),
        objects: vec![object("leaf", Category::LEAF, 0.4), object("trunk", Category::TRUNK, 0.5)],
        bodies: vec![forearm(&frames)],
        goals: vec![GoalRecord {
            position_world: DVec3::new(0.5, -0.2, 0.1),
            start_time_s: 0.0,
            end_time_s,
            outcome: Outcome::Reached,
            safety_stop: None,
            given_up: None,
        }],
        map: Vec::new(),
        contacts: vec![Contact {
            link: layout().patches[0].link.clone(),
            patch: Some(0),
            object: (reach % 2) as u16,
            first_frame: 0,
            last_frame: frames.len() as u32 - 1,
            peak_force_n: 3.0,
            mean_force_n: 1.0,
        }],
        frames,
        // Nothing to audit, because there is no solver.
        audit: Audit::default(),
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let dir = env::args().nth(1).ok_or("usage: write_a_data_set FOLDER")?;
    let reaches = env::args().nth(2).map_or(Ok(12), |count| count.parse())?;
    let plan = DatasetPlan {
        provenance: Provenance {
            program: "write_a_data_set".into(),
            program_version: env!("CARGO_PKG_VERSION").into(),
            engine: "none".into(),
            arithmetic: String::new(),
            options: BTreeMap::new(),
            scenes: Vec::new(),
            arms: Vec::new(),
            seed: 1,
            controller: "none".into(),
            controller_parameters: BTreeMap::new(),
            shard: None,
        },
        robot: "a sleeve".into(),
        rate_hz: RATE_HZ,
        joint_names: recording(0).joint_names,
        layout: layout(),
        categories: Vec::new(),
        episodes: (0..reaches)
            .map(|reach_index| PlannedEpisode {
                scene: "bumps".into(),
                task: format!("pass the {}", if reach_index % 2 == 0 { "leaf" } else { "trunk" }),
                reach_index,
            })
            .collect(),
    };
    let start = Instant::now();
    let writer = DatasetWriter::create(&dir, plan, true)?;
    // After a crash, only missing reaches run again.
    for position in writer.missing()? {
        writer.stage(position, &recording(position as u64))?;
    }
    report("staged", start);
    let start = Instant::now();
    let set: Dataset = writer.finish()?;
    report("finished", start);
    let start = Instant::now();
    for index in 0..set.episodes().len() {
        set.read_reach(index)?;
    }
    report("read", start);
    Ok(())
}

/// Prints the duration of a step and, if the system reports it, the peak memory so far.
fn report(step: &str, start: Instant) {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let memory = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or("unknown");
    eprintln!("{step} in {:.2} s; largest memory {}", start.elapsed().as_secs_f64(), memory.trim());
}
