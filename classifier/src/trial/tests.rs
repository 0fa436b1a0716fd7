use glam::DQuat;
use underbrush_recording::{Audit, Category, Grid, Patch, Pose, SkinLayout, Taxel, TaxelReading};

use super::*;

/// Options under which every taxel that senses anything is in contact: the hand-made recordings hold small forces.
pub(crate) fn any_force() -> TrialOptions {
    TrialOptions {
        threshold_n: 0.0,
        ..TrialOptions::default()
    }
}

const PITCH_M: f64 = 0.01;

/// A flat 3 × 6 patch in the link's x-y plane, taxel (row, column) at (0.01 column, 0.01 row, 0) m.
pub(crate) fn layout() -> SkinLayout {
    let taxels = (0..18)
        .map(|index| Taxel {
            position_link: DVec3::new(PITCH_M * f64::from(index % 6), PITCH_M * f64::from(index / 6), 0.0),
            normal_link: DVec3::Z,
            tangent_link: DVec3::X,
            area_m2: 1e-4,
        })
        .collect();
    let grid = Some(Grid {
        rows: 3,
        columns: 6,
        wraps: true,
    });
    SkinLayout {
        patches: vec![Patch {
            name: "forearm".into(),
            link: "forearm".into(),
            grid,
            taxels,
        }],
    }
}

/// One frame: (taxel, sensed force, object) of each taxel, and the patch's shift along world x, m.
pub(crate) type Drawn<'a> = (f64, &'a [(u16, f64, Option<u16>)]);

/// A recording with a leaf (object 0) and a trunk (object 1), from hand-drawn frames.
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
            let pose = Pose {
                position: DVec3::new(*shift_m, 0.0, 0.0),
                orientation: DQuat::IDENTITY,
            };
            Frame {
                time_s: index as f64 * 0.01,
                joint_angle_rad: vec![],
                joint_velocity_rad_per_s: vec![],
                equilibrium_angle_rad: vec![],
                joint_torque_nm: vec![],
                tip_pose_world: pose,
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
        objects: vec![object("leaf", Category::Leaf), object("trunk", Category::Trunk)],
        goals: vec![],
        contacts: vec![],
        frames,
        audit: Audit::default(),
    }
}

fn forces(contact: &ContactTrial) -> Vec<f64> {
    contact.trial.samples.iter().map(|sample| sample.force_n).collect()
}

fn motions_mm(contact: &ContactTrial) -> Vec<f64> {
    contact
        .trial
        .samples
        .iter()
        .map(|sample| (1e6 * sample.motion_m.unwrap()).round() / 1e3)
        .collect()
}

#[test]
fn a_taxel_makes_one_trial_per_contact() {
    // Pins cutting at contact and break, motion in the world frame from each contact's own start, order and numbers.
    let recording = recording(&[
        (0.000, &[(7, 0.5, Some(0))]),
        (0.003, &[(2, 0.1, None), (7, 0.6, Some(0))]),
        (0.004, &[(2, 0.2, Some(1))]),
        (0.009, &[(2, 0.3, Some(1)), (7, 0.7, Some(1))]),
    ]);
    let trials = taxel_trials(&recording, &any_force()).unwrap();
    let summary: Vec<_> = trials
        .iter()
        .map(|contact| {
            (
                contact.trial.trial,
                contact.trial.taxel,
                contact.trial.category.as_deref(),
                contact.object,
            )
        })
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

#[test]
fn threshold_and_length_leave_out_trials() {
    // Pins that a force equal to the threshold is no contact, and that short trials go.
    let recording = recording(&[
        (0.0, &[(0, 0.2, Some(0)), (3, 0.9, Some(0))]),
        (0.0, &[(0, 0.3, Some(0)), (3, 0.2, Some(0))]),
        (0.0, &[(0, 0.3, Some(0))]),
    ]);
    let options = TrialOptions {
        threshold_n: 0.2,
        ..any_force()
    };
    assert_eq!(
        taxel_trials(&recording, &options)
            .unwrap()
            .iter()
            .map(forces)
            .collect::<Vec<_>>(),
        [vec![0.9], vec![0.3, 0.3]]
    );
    let options = TrialOptions {
        min_samples: 2,
        ..options
    };
    assert_eq!(
        taxel_trials(&recording, &options)
            .unwrap()
            .iter()
            .map(forces)
            .collect::<Vec<_>>(),
        [[0.3, 0.3]]
    );
}

#[test]
fn truth_is_the_object_of_most_samples() {
    // Pins the majority vote, that samples without object have no vote, and no category without any.
    let recording = recording(&[
        (0.0, &[(0, 1.0, None), (5, 1.0, None)]),
        (0.0, &[(0, 1.0, None)]),
        (0.0, &[(0, 1.0, Some(1))]),
        (0.0, &[(0, 1.0, Some(0))]),
        (0.0, &[(0, 1.0, Some(1))]),
    ]);
    let trials = taxel_trials(&recording, &any_force()).unwrap();
    assert_eq!(
        (trials[0].object, trials[0].trial.category.as_deref()),
        (Some(1), Some("trunk"))
    );
    assert_eq!((trials[1].object, &trials[1].trial.category), (None, &None));
}

#[test]
fn components_wrap_around_only_where_asked() {
    // Pins 4-connectivity (no diagonals), wrap-around by the layout, and its override.
    let recording = recording(&[(
        0.0,
        &[(0, 1.0, Some(0)), (5, 2.0, Some(0)), (7, 3.0, Some(0)), (14, 4.0, None)],
    )]);
    let largest = |wrap| -> Vec<f64> {
        let options = TrialOptions { wrap, ..any_force() };
        component_trials(&recording, &options)
            .unwrap()
            .iter()
            .flat_map(forces)
            .collect()
    };
    assert_eq!(largest(None), [2.0, 3.0, 4.0]);
    assert_eq!(largest(Some(false)), [1.0, 2.0, 3.0, 4.0]);
}

#[test]
fn a_component_reports_its_largest_force_and_the_motion_of_its_centre() {
    // Pins both features: taxels 7, 8 (centre column 1.5) then 7, 8, 9 (centre column 2), the patch 1 mm further on.
    let recording = recording(&[
        (0.000, &[(7, 0.5, None), (8, 0.9, None)]),
        (0.001, &[(7, 0.4, Some(1)), (8, 0.8, Some(1)), (9, 1.1, None)]),
    ]);
    let trials = component_trials(&recording, &any_force()).unwrap();
    assert_eq!(trials.len(), 1);
    assert_eq!(forces(&trials[0]), [0.9, 1.1]);
    assert_eq!(motions_mm(&trials[0]), [0.0, 6.0]);
    // The strongest taxel of the second frame touches nothing (crosstalk): the truth is that of its neighbours.
    assert_eq!((trials[0].trial.taxel, trials[0].object), (Some(8), Some(1)));
}

#[test]
fn of_two_merging_components_the_nearer_goes_on() {
    // Pins merging: columns 0–1 and column 3 become 0–3 (centre 1.5): the first was 10 mm away, the second 15 mm.
    let options = TrialOptions {
        wrap: Some(false),
        ..any_force()
    };
    let recording = recording(&[
        (0.0, &[(0, 1.0, Some(0)), (1, 1.0, Some(0)), (3, 2.0, Some(1))]),
        (
            0.0,
            &[
                (0, 1.1, Some(0)),
                (1, 1.0, Some(0)),
                (2, 0.1, Some(0)),
                (3, 2.2, Some(1)),
            ],
        ),
    ]);
    let trials = component_trials(&recording, &options).unwrap();
    assert_eq!(
        trials.iter().map(forces).collect::<Vec<_>>(),
        [vec![1.0, 2.2], vec![2.0]]
    );
    assert_eq!(motions_mm(&trials[0]), [0.0, 10.0]);
}

#[test]
fn of_a_splitting_component_the_nearer_piece_goes_on() {
    // Pins splitting: columns 0–3 (centre 1.5) become 0–1 (10 mm off) and 3 (15 mm off), which starts from zero motion.
    let options = TrialOptions {
        wrap: Some(false),
        ..any_force()
    };
    let recording = recording(&[
        (
            0.0,
            &[
                (0, 1.1, Some(0)),
                (1, 1.0, Some(0)),
                (2, 0.1, Some(0)),
                (3, 2.2, Some(1)),
            ],
        ),
        (0.0, &[(0, 1.0, Some(0)), (1, 1.0, Some(0)), (3, 2.0, Some(1))]),
    ]);
    let trials = component_trials(&recording, &options).unwrap();
    assert_eq!(
        trials.iter().map(forces).collect::<Vec<_>>(),
        [vec![2.2, 1.0], vec![2.0]]
    );
    assert_eq!(motions_mm(&trials[1]), [0.0]);
}

#[test]
fn tracking_is_greedy_by_world_distance() {
    // Pins association: a patch that slides 10 mm in x under a fixed contact moves it by one column at rest in the
    // world; a contact that jumps farther than allowed ends and begins anew.
    let recording = recording(&[
        (0.00, &[(1, 1.0, Some(0)), (4, 5.0, Some(1))]),
        (-0.01, &[(2, 2.0, Some(0)), (5, 6.0, Some(1))]),
        (-0.01, &[(2, 3.0, Some(0))]),
        (-0.01, &[(17, 4.0, Some(0))]),
    ]);
    let options = TrialOptions {
        wrap: Some(false),
        ..any_force()
    };
    let trials = component_trials(&recording, &options).unwrap();
    let expected = [vec![1.0, 2.0, 3.0], vec![5.0, 6.0], vec![4.0]];
    assert_eq!(trials.iter().map(forces).collect::<Vec<_>>(), expected);
    assert_eq!(motions_mm(&trials[0]), [0.0; 3]);
}

#[test]
fn bad_input_is_named() {
    // Pins the errors for unknown patches, missing grids, bad options and frames that do not fit.
    let sound = recording(&[(0.0, &[(0, 1.0, Some(0))])]);
    let unknown = TrialOptions {
        patch: "elbow".into(),
        ..any_force()
    };
    assert!(matches!(
        taxel_trials(&sound, &unknown),
        Err(TrialError::UnknownPatch { .. })
    ));
    let negative = TrialOptions {
        threshold_n: -1.0,
        ..any_force()
    };
    assert!(matches!(
        taxel_trials(&sound, &negative),
        Err(TrialError::BadOption { .. })
    ));
    let endless = TrialOptions {
        association_distance_m: f64::NAN,
        ..any_force()
    };
    assert!(matches!(
        component_trials(&sound, &endless),
        Err(TrialError::BadOption { .. })
    ));

    let mut gridless = sound.clone();
    gridless.layout.patches[0].grid = Some(Grid {
        rows: 4,
        columns: 4,
        wraps: false,
    });
    assert!(matches!(
        component_trials(&gridless, &any_force()),
        Err(TrialError::NoGrid { .. })
    ));
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

#[test]
fn samples_know_their_contact_region() {
    // Pins taxels, largest force and sum of the region that a taxel is part of, at each instant, in taxel and in component
    // trials: 1, 2 and 8 hang together in a grid of rows of six, 11 stands alone; then 2 breaks and parts the others.
    let recording = recording(&[
        (
            0.0,
            &[
                (1, 0.5, Some(0)),
                (2, 0.25, None),
                (8, 1.0, Some(0)),
                (11, 2.0, Some(1)),
            ],
        ),
        (0.0, &[(1, 0.5, Some(0)), (8, 0.75, Some(0)), (11, 2.0, Some(1))]),
    ]);
    let of = |contact: &ContactTrial| -> Vec<(u32, f64, f64)> {
        let regions = contact.trial.samples.iter().map(|sample| sample.region.unwrap());
        regions
            .map(|region| (region.taxels, region.largest_force_n, region.force_sum_n))
            .collect()
    };
    let options = TrialOptions {
        wrap: Some(false),
        ..any_force()
    };
    let taxels = taxel_trials(&recording, &options).unwrap();
    let joined = (3, 1.0, 1.75);
    let expected = [
        (Some(1), vec![joined, (1, 0.5, 0.5)]),
        (Some(2), vec![joined]),
        (Some(8), vec![joined, (1, 0.75, 0.75)]),
        (Some(11), vec![(1, 2.0, 2.0), (1, 2.0, 2.0)]),
    ];
    assert_eq!(
        taxels
            .iter()
            .map(|contact| (contact.trial.taxel, of(contact)))
            .collect::<Vec<_>>(),
        expected
    );
    let components = component_trials(&recording, &options).unwrap();
    assert_eq!(of(&components[0])[0], joined);
    assert!(
        components
            .iter()
            .all(|contact| of(contact).len() == contact.trial.samples.len())
    );
    // Where the patch has no grid, nobody knows the neighbours.
    let mut loose = recording;
    loose.layout.patches[0].grid = None;
    let trials = taxel_trials(&loose, &options).unwrap();
    assert!(
        trials
            .iter()
            .flat_map(|contact| &contact.trial.samples)
            .all(|sample| sample.region.is_none())
    );
}

#[test]
fn the_environment_labels_what_nothing_touched() {
    // Pins labels: by contact a trial without an object has none; by environment it has that of the only category, foam
    // blocks aside; in mixed clutter both label alike.
    let touched: &[(u16, f64, Option<u16>)] = &[(0, 1.0, Some(1)), (9, 1.0, None)];
    let mut reach = recording(&[(0.0, touched), (0.0, touched)]);
    let labels = |reach: &Recording, labels| -> Vec<Option<String>> {
        let options = TrialOptions { labels, ..any_force() };
        let trials = taxel_trials(reach, &options).unwrap();
        trials.into_iter().map(|contact| contact.trial.category).collect()
    };
    let trunk = Some("trunk".to_owned());
    assert_eq!(labels(&reach, Labels::Contact), [trunk.clone(), None]);
    assert_eq!(labels(&reach, Labels::Environment), [trunk.clone(), None]);
    reach.objects[0].category = Category::Block;
    assert_eq!(labels(&reach, Labels::Contact), [trunk.clone(), None]);
    assert_eq!(labels(&reach, Labels::Environment), [trunk.clone(), trunk]);
}

#[test]
fn the_papers_trials_fill_twenty_slices() {
    // Pins that the paper's trials have a sample for each of the 20 time slices of its largest models, and none fewer.
    let lit: &[(u16, f64, Option<u16>)] = &[(0, 1.0, Some(1))];
    let count = |frames: usize| {
        let reach = recording(&vec![(0.0, lit); frames]);
        taxel_trials(&reach, &TrialOptions::paper()).unwrap().len()
    };
    assert_eq!((count(19), count(20)), (0, 1));
}

#[test]
fn motion_is_the_length_of_the_path() {
    // Pins that a taxel carried 3 mm there and back has travelled 6 mm, while its distance from the start is 0.
    let lit: &[(u16, f64, Option<u16>)] = &[(0, 1.0, Some(1))];
    let reach = recording(&[(0.0, lit), (0.003, lit), (0.0, lit)]);
    let trials = taxel_trials(&reach, &any_force()).unwrap();
    assert_eq!(motions_mm(&trials[0]), [0.0, 3.0, 6.0]);
}
