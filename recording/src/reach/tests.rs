use super::*;
use crate::Patch;

fn recording(contacts: Vec<Contact>) -> Recording {
    let patch = |name: &str| Patch { name: name.into(), link: format!("{name}_link"), grid: None, taxels: Vec::new() };
    Recording {
        scene: String::new(),
        controller: String::new(),
        seed: 0,
        reach_index: 0,
        rate_hz: 100.0,
        joint_names: Vec::new(),
        layout: SkinLayout { patches: vec![patch("forearm"), patch("flipper")] },
        objects: Vec::new(),
        bodies: vec![],
        goals: Vec::new(),
        contacts,
        map: Vec::new(),
        frames: Vec::new(),
        audit: Audit::default(),
    }
}

fn contact(patch: Option<u16>, object: u16, [first_frame, last_frame]: [u32; 2], peak_force_n: f64) -> Contact {
    Contact {
        link: "a link".into(),
        patch,
        object,
        first_frame,
        last_frame,
        peak_force_n,
        mean_force_n: peak_force_n / 2.0,
    }
}

/// Tests that frames with true contact are counted by patch, each frame once, without contacts on bare links and
/// contacts without force.
#[test]
fn only_true_contact_counts() {
    let recording = recording(vec![
        contact(Some(0), 0, [10, 19], 1.0),
        contact(Some(0), 1, [15, 24], 2.0),
        contact(Some(0), 2, [16, 17], 2.0),
        contact(Some(0), 0, [40, 40], 0.5),
        contact(Some(1), 0, [3, 5], 0.0),
        contact(None, 0, [0, 99], 30.0),
    ]);
    let frames = recording.touched_frames();
    // 10 to 24 and 40.
    assert_eq!((frames["forearm"], frames["flipper"]), (16, 0));
}

/// Tests the forces of all contacts and of those with one category: the largest peak, and the mean over the frames of
/// all contacts. Without contacts both are 0.
#[test]
fn forces_are_summed_up_by_category() {
    let object = |category| ObjectRecord {
        kind: String::new(),
        category,
        position_world: DVec3::ZERO,
        parameters: BTreeMap::new(),
    };
    let recording = Recording {
        objects: vec![object(Category::LEAF), object(Category::TRUNK)],
        ..recording(vec![
            // Means of 1 N over 10 frames, 2 N over 30 and 8 N over 10.
            contact(Some(0), 0, [0, 9], 2.0),
            contact(Some(1), 0, [0, 29], 4.0),
            contact(None, 1, [40, 49], 16.0),
        ])
    };
    let forces = |contacts, peak_n, mean_n| ContactForces { contacts, peak_n, mean_n };
    assert_eq!(recording.contact_forces(None), forces(3, 16.0, 150.0 / 50.0));
    assert_eq!(recording.contact_forces(Some(Category::LEAF)), forces(2, 4.0, 70.0 / 40.0));
    assert_eq!(recording.contact_forces(Some(Category::TRUNK)), forces(1, 16.0, 8.0));
    assert_eq!(recording.contact_forces(Some(Category::OUTLIER)), ContactForces::default());
}
