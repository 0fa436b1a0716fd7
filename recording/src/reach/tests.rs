use super::*;
use crate::Patch;

fn recording(contacts: Vec<Contact>) -> Recording {
    let patch = |name: &str| Patch {
        name: name.into(),
        link: format!("{name}_link"),
        grid: None,
        taxels: Vec::new(),
    };
    Recording {
        scene: String::new(),
        controller: String::new(),
        seed: 0,
        reach_index: 0,
        rate_hz: 100.0,
        joint_names: Vec::new(),
        layout: SkinLayout {
            patches: vec![patch("forearm"), patch("flipper")],
        },
        objects: Vec::new(),
        bodies: vec![],
        goals: Vec::new(),
        contacts,
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

/// Pins that frames with true contact are counted by patch, each frame once, without contacts on bare links and
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
