use std::fmt::Write;

use underbrush_recording::{Category, Contact as Touching, GoalRecord, ObjectRecord, Outcome};
use underbrush_sim::reach::ReachPlan;

use super::contacts::{Answer, Class, OpenContact, Pressing};
use super::*;

/// What a frozen scene draws first with seed 1: objects with their properties, and goals.
fn drawn(path: &str) -> (ReachPlan, String) {
    let scene = frozen::scene(path).unwrap();
    let arm = frozen::arms(std::slice::from_ref(&scene)).unwrap().remove(&scene.name);
    let plan = match arm {
        Some(arm) => ReachPlan::with_arm(scene, arm, None, 1).unwrap(),
        None => ReachPlan::new(scene, None, 1).unwrap(),
    };
    let (clutter, mut text) = (plan.draw(0).unwrap(), String::new());
    for record in clutter.records() {
        // Rounded, so that the last digits of a mathematical library do not matter.
        let foot = record.position_world;
        write!(text, "{} {:.6} {:.6}", record.kind, foot.x, foot.y).unwrap();
        // Leaves have it since the benchmark was published; its value is a constant.
        for (name, value) in record.parameters.iter().filter(|(name, _)| *name != "torsion_over_bending") {
            write!(text, " {name} {value:.6e}").unwrap();
        }
        writeln!(text).unwrap();
    }
    for goal in &clutter.goals {
        writeln!(text, "goal {:.6} {:.6} {:.6}", goal.x, goal.y, goal.z).unwrap();
    }
    (plan, text)
}

/// Tests that the frozen scenes draw what they drew when the benchmark was published, with the same options of physics
/// and sensor. If the defaults of scene files change later, the frozen files must state the old values.
#[test]
fn frozen_scenes_draw_what_they_drew() {
    let mut text = String::new();
    let settings = frozen::SETTINGS.iter().map(|(_, path)| path);
    for path in frozen::VERDICTS_SCENES.iter().chain(settings) {
        let (plan, drawn) = drawn(path);
        let (file, controller) = (&plan.scene.file, plan.controller_name());
        // These came later, and are off. Before them there was one that switched everything off.
        let later = "model: Paper, gain_spread_share: 0.0, drift_n: 0.0, drift_time_s: 60.0, bandwidth_hz: inf,";
        let sensor = format!("{:?}", file.sensor).replace(later, "perfect: false,");
        writeln!(text, "{path} {:?} {sensor} {controller:?}\n{drawn}", file.physics).unwrap();
    }
    assert_eq!(blake3::hash(text.as_bytes()).to_hex()[..16], *"3530b0f2084a2140", "{text}");
}

/// Tests that all settings except the one with another arm have the same clutter and goals.
#[test]
fn settings_differ_in_nothing_but_arm_speed_and_sensor() {
    let (_, usual) = drawn(frozen::SETTINGS[0].1);
    for (name, path) in frozen::SETTINGS {
        assert_eq!(drawn(path).1 == usual, *name != frozen::OTHER_ARM, "{name}");
    }
}

fn answer(likeliest: Class) -> Answer {
    Answer { likeliest, trunk: Some(likeliest == Class::Trunk), unlike: 0.0 }
}

/// Tests which frame of a contact stands for each moment, that shorter contacts keep their last answer, that answers
/// after the end of the touch are kept apart, and that the truth of a contact is what pressed most often.
#[test]
fn moments_are_those_samples_of_the_contact() {
    let mut open = OpenContact::default();
    for sample in 1..=60 {
        let likeliest = if (25..=40).contains(&sample) { Class::Trunk } else { Class::Leaf };
        // The touch ends before the reading does.
        let pressing = if sample <= 30 { Some(Category::TRUNK) } else { None };
        open.push(answer(likeliest), pressing);
    }
    let contact = open.close().unwrap();
    assert_eq!((contact.truth, contact.samples), (Class::Trunk, 60));
    let found =
        contact.moments.map(|moment| (moment.answer.likeliest, moment.while_pressed.likeliest, moment.pressing));
    let (touched, over) = (Pressing::Known(Class::Trunk), Pressing::Known(Class::Nothing));
    // After 1, 2, 3, 6 and 12 samples; after 25; and after 50, and at the end at 60.
    assert_eq!(found[..5], [(Class::Leaf, Class::Leaf, touched); 5]);
    assert_eq!(found[5], (Class::Trunk, Class::Trunk, touched));
    assert_eq!(found[6..], [(Class::Leaf, Class::Trunk, over); 4]);
}

/// Tests that a contact on which a foam block pressed most often is left out of the benchmark, and that a reading
/// without any touch is not.
#[test]
fn blocks_are_left_out_and_readings_without_a_touch_are_not() {
    let closed = |pressing: &[Option<Category>]| {
        let mut open = OpenContact::default();
        for category in pressing {
            open.push(answer(Class::Leaf), *category);
        }
        open.close().map(|contact| contact.truth)
    };
    assert_eq!(closed(&[Some(Category::BLOCK), Some(Category::BLOCK), Some(Category::LEAF)]), None);
    assert_eq!(closed(&[None, None]), Some(Class::Nothing));
    assert_eq!(closed(&[None, Some(Category::OUTLIER)]), Some(Class::Other));
}

/// Tests that a row is not written over the row of another model, and that this is found before anything is simulated.
/// A row of the same model, and a file that is no row, are replaced.
#[test]
fn the_row_of_another_model_stays() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("quick-rows/reaching-blind.json");
    files::write(&file, br#"{ "entry": { "name": "blind", "model_blake3": "0123" } }"#).unwrap();
    let entry =
        Entry::Reaching(EnteredController { kind: Some(ControllerKind::Blind), ..EnteredController::default() });
    let Err(Fault::Input(error)) = entry.run(folder.path(), true, &crate::progress::Silent) else {
        panic!("the row is not refused");
    };
    assert!(error.file == file && error.found.contains("0123"), "{error}");
    assert!(!folder.path().join("quick-sets").exists());
    let of_model = |model: Option<&str>| EntryRecord {
        name: "blind".into(),
        classifier: None,
        model_blake3: model.map(str::to_owned),
    };
    assert!(of_model(Some("4567")).check_earlier_row(&file).is_err());
    of_model(Some("0123")).check_earlier_row(&file).unwrap();
    of_model(None).check_earlier_row(&folder.path().join("none.json")).unwrap();
    files::write(&file, b"{").unwrap();
    of_model(None).check_earlier_row(&file).unwrap();
}

/// Tests the figures of two reaches against values worked out by hand.
#[test]
fn reaching_figures_are_those_worked_out_by_hand() {
    let goal = |outcome, seconds: f64| GoalRecord {
        position_world: glam::DVec3::ZERO,
        start_time_s: 1.0,
        end_time_s: 1.0 + seconds,
        outcome,
        safety_stop: None,
        given_up: None,
    };
    let touching = |object: u16, frames: u32, peak_force_n: f64, mean_force_n: f64| Touching {
        link: "forearm".into(),
        patch: Some(0),
        object,
        first_frame: 7,
        last_frame: 7 + frames - 1,
        peak_force_n,
        mean_force_n,
    };
    let objects = [Category::LEAF, Category::TRUNK].map(|category| ObjectRecord {
        kind: category.name().into(),
        category,
        position_world: glam::DVec3::ZERO,
        parameters: [].into(),
    });
    let reach = |goals: Vec<GoalRecord>, contacts: Vec<Touching>| reaching::Reach::of(3, &goals, &contacts, &objects);
    let reaches = [
        reach(
            vec![goal(Outcome::Reached, 2.0), goal(Outcome::Stuck, 4.0)],
            vec![touching(0, 100, 3.0, 0.5), touching(1, 10, 8.0, 2.0), touching(1, 10, 6.0, 2.0)],
        ),
        reach(vec![goal(Outcome::Reached, 3.0)], vec![touching(0, 50, 1.0, 0.2)]),
    ];
    let found = reaching::figures(&reaches);
    let near = |estimate: Estimate, expected: f64| (estimate.value.unwrap() - expected).abs() < 1e-12;
    // Three goals each, of which the second reach tried one.
    assert_eq!((found.reaches, found.goals, found.largest_on_trunk_n), (2, 6, 8.0));
    assert!(near(found.reached, 2.0 / 6.0));
    assert!(near(found.seconds_for_each, 9.0 / 2.0));
    assert!(near(found.trunk_peak_n, (8.0 + 0.0) / 2.0));
    // 1 s at 0.5 N, and 0.5 s at 0.2 N.
    assert!(near(found.leaf_impulse_n_s, (0.5 + 0.1) / 2.0));
}
