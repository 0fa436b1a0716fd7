//! Tests on hand-made frames: trials by taxel, and what is refused.

mod components;
mod labels;

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};
use underbrush_recording::{Audit, Category, Frame, Grid, ObjectRecord, Patch, Pose, SkinLayout, Taxel, TaxelReading};

use super::*;

/// Options under which every taxel that senses any force is in contact; the hand-made recordings have small forces.
pub(crate) fn any_force() -> TrialOptions {
    TrialOptions { threshold_n: 0.0, ..TrialOptions::default() }
}

const PITCH_M: f64 = 0.01;

/// A flat 3 × 6 patch in the link's x-y plane, with taxel (row, column) at (0.01 column, 0.01 row, 0) m.
pub(crate) fn layout() -> SkinLayout {
    let taxels = (0..18)
        .map(|index| Taxel {
            position_link: DVec3::new(PITCH_M * f64::from(index % 6), PITCH_M * f64::from(index / 6), 0.0),
            normal_link: DVec3::Z,
            tangent_link: DVec3::X,
            area_m2: 1e-4,
        })
        .collect();
    let grid = Some(Grid { rows: 3, columns: 6, wraps: true });
    SkinLayout { patches: vec![Patch { name: "forearm".into(), link: "forearm".into(), grid, taxels }] }
}

/// One frame: (taxel, sensed force, object) of each taxel, and the patch's shift along world x, m.
pub(crate) type Drawn<'a> = (f64, &'a [(u16, f64, Option<u16>)]);

/// A recording with a leaf (object 0) and a trunk (object 1), from hand-made frames.
pub(crate) fn recording(frames: &[Drawn]) -> Recording {
    let object = |kind: &str, category| ObjectRecord {
        kind: kind.into(),
        category,
        position_world: DVec3::ZERO,
        parameters: BTreeMap::new(),
    };
    let frames = frames
        .iter()
        .enumerate()
        .map(|(index, (shift_m, readings))| {
            let pose = Pose { position: DVec3::new(*shift_m, 0.0, 0.0), orientation: DQuat::IDENTITY };
            Frame {
                time_s: index as f64 * 0.01,
                joint_angle_rad: vec![],
                joint_velocity_rad_per_s: vec![],
                equilibrium_angle_rad: vec![],
                joint_torque_nm: vec![],
                end_effector_pose_world: pose,
                goal_position_world: DVec3::ZERO,
                goal_index: 0,
                patch_pose_world: vec![pose],
                contact_force_world: vec![DVec3::ZERO],
                taxels: readings
                    .iter()
                    .map(|&(taxel, sensed_force_n, object)| TaxelReading {
                        patch: 0,
                        taxel,
                        true_normal_force_n: sensed_force_n,
                        true_shear_force_n: [0.0; 2],
                        sensed_force_n,
                        object,
                    })
                    .collect(),
                contact_points: Vec::new(),
            }
        })
        .collect();
    Recording {
        scene: "hand-drawn".into(),
        controller: "none".into(),
        seed: 0,
        reach_index: 4,
        rate_hz: 100.0,
        joint_names: vec![],
        layout: layout(),
        objects: vec![object("leaf", Category::LEAF), object("trunk", Category::TRUNK)],
        bodies: vec![],
        goals: vec![],
        contacts: vec![],
        map: Vec::new(),
        frames,
        audit: Audit::default(),
    }
}

fn forces(contact: &ContactTrial) -> Vec<f64> {
    contact.trial.samples.iter().map(|sample| sample.force_n).collect()
}

fn motions_mm(contact: &ContactTrial) -> Vec<f64> {
    contact.trial.samples.iter().map(|sample| (1e6 * sample.motion_m.unwrap()).round() / 1e3).collect()
}

/// Tests that trials start and end with contact, that motion is measured in the world frame from the start of each
/// contact, and the order and numbers of trials.
#[test]
fn a_taxel_makes_one_trial_per_contact() {
    let recording = recording(&[
        (0.000, &[(7, 0.5, Some(0))]),
        (0.003, &[(2, 0.1, None), (7, 0.6, Some(0))]),
        (0.004, &[(2, 0.2, Some(1))]),
        (0.009, &[(2, 0.3, Some(1)), (7, 0.7, Some(1))]),
    ]);
    let trials = taxel_trials(&recording, &any_force()).unwrap();
    let summary: Vec<_> = trials
        .iter()
        .map(|contact| (contact.trial.trial, contact.trial.taxel, contact.trial.category.as_deref(), contact.object))
        .collect();
    assert_eq!(
        summary,
        [
            (0, Some(7), Some("leaf"), Some(0)),
            (1, Some(2), Some("trunk"), Some(1)),
            (2, Some(7), Some("trunk"), Some(1)),
        ]
    );
    assert_eq!(forces(&trials[0]), [0.5, 0.6]);
    assert_eq!(motions_mm(&trials[0]), [0.0, 3.0]);
    assert_eq!(motions_mm(&trials[1]), [0.0, 1.0, 6.0]);
    assert_eq!(motions_mm(&trials[2]), [0.0]);
    assert_eq!(trials[1].trial.reach, Some(4));
    assert_eq!(trials[1].trial.samples[0].time_s, 0.01);
}

/// Tests that a force equal to the threshold is not contact, and that short trials are left out.
#[test]
fn threshold_and_length_leave_out_trials() {
    let recording = recording(&[
        (0.0, &[(0, 0.2, Some(0)), (3, 0.9, Some(0))]),
        (0.0, &[(0, 0.3, Some(0)), (3, 0.2, Some(0))]),
        (0.0, &[(0, 0.3, Some(0))]),
    ]);
    let found = |options: &TrialOptions| -> Vec<Vec<f64>> {
        let trials = taxel_trials(&recording, options).unwrap();
        trials.iter().map(forces).collect()
    };
    let options = TrialOptions { threshold_n: 0.2, ..any_force() };
    assert_eq!(found(&options), [vec![0.9], vec![0.3, 0.3]]);
    let options = TrialOptions { min_samples: 2, ..options };
    assert_eq!(found(&options), [[0.3, 0.3]]);
}

/// Tests the errors for unknown patches, missing grids, invalid options and frames that do not fit.
#[test]
fn bad_input_is_named() {
    let sound = recording(&[(0.0, &[(0, 1.0, Some(0))])]);
    let unknown = TrialOptions { patch: Some("elbow".into()), ..any_force() };
    assert!(matches!(taxel_trials(&sound, &unknown), Err(TrialError::UnknownPatch { .. })));
    let negative = TrialOptions { threshold_n: -1.0, ..any_force() };
    assert!(matches!(taxel_trials(&sound, &negative), Err(TrialError::BadOption { .. })));
    let endless = TrialOptions { association_distance_m: f64::NAN, ..any_force() };
    assert!(matches!(component_trials(&sound, &endless), Err(TrialError::BadOption { .. })));

    let mut gridless = sound.clone();
    gridless.layout.patches[0].grid = Some(Grid { rows: 4, columns: 4, wraps: false });
    assert!(matches!(component_trials(&gridless, &any_force()), Err(TrialError::NoGrid { .. })));
    assert!(taxel_trials(&gridless, &any_force()).is_ok());

    let breakages: [fn(&mut Recording); 4] = [
        |recording| recording.frames[0].taxels[0].taxel = 18,
        |recording| recording.frames[0].taxels[0].sensed_force_n = f64::NAN,
        |recording| recording.frames[0].patch_pose_world.clear(),
        |recording| recording.objects.clear(),
    ];
    for breakage in breakages {
        let mut broken = sound.clone();
        breakage(&mut broken);
        for cut in [taxel_trials, component_trials] {
            let error = cut(&broken, &any_force()).unwrap_err();
            assert!(matches!(error, TrialError::BadFrame { frame: 0, .. }), "{error}");
        }
    }
}

/// Tests that the paper's trials have at least one sample for each of the 20 time slices of its largest models.
#[test]
fn the_papers_trials_fill_twenty_slices() {
    let lit: &[(u16, f64, Option<u16>)] = &[(0, 1.0, Some(1))];
    let count = |frames: usize| {
        let reach = recording(&vec![(0.0, lit); frames]);
        taxel_trials(&reach, &TrialOptions::paper()).unwrap().len()
    };
    assert_eq!((count(19), count(20)), (0, 1));
}

/// Tests that a taxel carried 3 mm there and back has travelled 6 mm, while its distance from the start is 0.
#[test]
fn motion_is_the_length_of_the_path() {
    let lit: &[(u16, f64, Option<u16>)] = &[(0, 1.0, Some(1))];
    let reach = recording(&[(0.0, lit), (0.003, lit), (0.0, lit)]);
    let trials = taxel_trials(&reach, &any_force()).unwrap();
    assert_eq!(motions_mm(&trials[0]), [0.0, 3.0, 6.0]);
}
