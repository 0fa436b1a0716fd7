use std::fmt::Write;

use underbrush_recording::{Category, Contact, ContactPoint, Frame, GoalRecord, ObjectRecord, Outcome, Recording};
use underbrush_sim::reach::{ReachError, ReachPlan};

use super::*;
use crate::progress::{Counter, Silent};

/// What a frozen scene draws first with seed 1: objects with their properties, and goals.
fn drawn(path: &str) -> (ReachPlan, String) {
    let scene = frozen::scene(path).unwrap();
    let arm = frozen::arms(std::slice::from_ref(&scene)).unwrap().remove(&scene.name);
    let plan = ReachPlan::with_arm(scene, arm, None, 1).unwrap();
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
    let settings = frozen::SETTINGS.iter().map(|(_, path)| path);
    let (of_version_1, of_version_2) = frozen::VERDICTS_SCENES.split_at(5);
    let of_version_1: Vec<&str> = of_version_1.iter().chain(settings).copied().collect();
    for (paths, expected) in [(&of_version_1[..], "3530b0f2084a2140"), (of_version_2, "d933f87860539561")] {
        let mut text = String::new();
        for path in paths {
            let (plan, drawn) = drawn(path);
            let (file, controller) = (&plan.scene.file, plan.controller_name());
            // These options came after the hash was taken, and are off here. At that time one option switched all of them off.
            let later = "model: Paper, gain_spread_share: 0.0, drift_n: 0.0, drift_time_s: 60.0, bandwidth_hz: inf,";
            let sensor =
                format!("{:?}", file.sensor).replace(later, "perfect: false,").replace("response: TotalForce, ", "");
            writeln!(text, "{path} {:?} {sensor} {controller:?}\n{drawn}", file.physics).unwrap();
        }
        assert_eq!(blake3::hash(text.as_bytes()).to_hex()[..16], *expected, "{text}");
    }
}

/// Tests that all settings except the one with another arm have the same clutter and goals.
#[test]
fn settings_differ_in_nothing_but_arm_speed_and_sensor() {
    let (_, usual) = drawn(frozen::SETTINGS[0].1);
    for (name, path) in frozen::SETTINGS {
        assert_eq!(drawn(path).1 == usual, *name != frozen::OTHER_ARM, "{name}");
    }
}

fn blind(own: Option<MakeController>) -> Entry {
    Entry::Reaching(EnteredController { kind: Some(ControllerKind::Blind), own, verdicts: None })
}

fn touch_model() -> JudgedModel {
    JudgedModel::load(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../suites/touch.json"))).unwrap()
}

/// Tests that audit seeds depend on the track and on what is judged, and that none is a seed that someone would choose.
#[test]
fn audit_seeds_follow_from_what_is_judged() {
    let mut seeds: Vec<u64> = Vec::new();
    for track in ["verdicts", "transfer", "reaching"] {
        seeds.extend(["", "0123", "0124"].map(|judged| frozen::halves(track, 1, judged, "")[1].1));
    }
    assert!(seeds.iter().all(|seed| (1 << 52..1 << 53).contains(seed)), "{seeds:?}");
    let count = seeds.len();
    seeds.sort_unstable();
    seeds.dedup();
    assert_eq!(seeds.len(), count);
}

/// Tests that both halves have the same scenes and numbers of reaches and differ in their seeds, which no other set has.
#[test]
fn halves_differ_in_their_seeds_only() {
    let entries = [Entry::Verdicts(Box::new(touch_model())), Entry::Transfer(Box::new(touch_model())), blind(None)];
    for entry in entries {
        let sets = entry.sets(false).unwrap();
        // A touch model can say that nothing touches a taxel, so nothing is fitted.
        let (public, audit) = sets.split_at(sets.len() / 2);
        assert_eq!(public.len(), audit.len());
        for (public, audit) in public.iter().zip(audit) {
            let scenes = |set: &TestSet| {
                let own = set.campaign.scenes.iter();
                own.map(|(scene, reaches)| (scene.name.clone(), *reaches)).collect::<Vec<_>>()
            };
            assert_eq!(scenes(public), scenes(audit));
            assert_ne!(public.campaign.seed, audit.campaign.seed);
            assert!(public.name.contains("public") && audit.name.contains("audit"), "{} {}", public.name, audit.name);
        }
        assert!(audit.iter().all(|set| set.campaign.seed == audit[0].campaign.seed));
    }
}

/// Tests that a model's answers do not depend on the truth that a recording holds beside what is sensed.
#[test]
fn a_model_is_shown_what_is_sensed_only() {
    let plan = ReachPlan::new(frozen::scene("mixed").unwrap(), None, 3).unwrap();
    let mut recording = plan.run(0, &mut |_| {}).unwrap();
    recording.frames.truncate(600);
    // The same classes of objects at other indices, and everything else that is true is spoilt.
    let mut spoilt = recording.clone();
    let count = spoilt.objects.len();
    spoilt.objects.extend(recording.objects.clone());
    for frame in &mut spoilt.frames {
        frame.contact_force_world.fill(glam::DVec3::NAN);
        frame.contact_points.clear();
        for reading in &mut frame.taxels {
            reading.true_normal_force_n *= 1000.0;
            reading.true_shear_force_n = [f64::NAN; 2];
            reading.object = reading.object.map(|object| object + count as u16);
        }
    }
    let [found, expected] = [&spoilt, &recording].map(|own| touch_model().judge(own).unwrap());
    assert_eq!((&found.objects, &found.frames), (&expected.objects, &expected.frames));
    assert!(found.objects.iter().all(|own| !own.as_ref().unwrap().is_empty()));
}

/// Tests that a controller that is told the true categories is not judged.
#[test]
fn the_truth_is_refused() {
    let verdicts = Some(VerdictControl::truth());
    let own = EnteredController { kind: Some(ControllerKind::Cody2013), own: None, verdicts };
    let Err(error) = Entry::Reaching(own).sets(true) else { panic!("the truth is not refused") };
    assert!(error.to_string().contains("verdicts: found truth"), "{error}");
}

/// Tests that a row of version 1 is read with everything that it says.
#[test]
fn a_row_of_version_1_is_read() {
    let moment = r#"{ "samples": null, "leaf_or_trunk": { "value": 0.5, "interval": null } }"#;
    let text = format!(
        r#"{{ "benchmark": "incidental-contact-1", "track": "verdicts", "complete": true,
            "entry": {{ "name": "touch", "classifier": "touch", "model_blake3": "0123" }},
            "program_version": "0.1.0", "analysis_sources": "45", "engine": "rapier3d",
            "sets": [{{ "name": "verdicts", "seed": 910000, "data_blake3": "67",
                "scenes": [{{ "name": "leaf", "reaches": 40, "blake3": "89" }}] }}],
            "figures": {{ "verdicts": {{ "contacts": {{ "leaf": 7 }}, "moments": [{moment}] }} }} }}"#
    );
    let row: BenchmarkRow = serde_json::from_str(&text).unwrap();
    let TrackFigures::Earlier(figures) = &row.figures else { panic!("{row:?}") };
    assert_eq!(figures["verdicts"]["moments"][0]["leaf_or_trunk"]["value"], 0.5);
    assert_eq!(serde_json::to_value(&row).unwrap(), serde_json::from_str::<serde_json::Value>(&text).unwrap());
}

/// Tests that a row is not written over the row of another model or of version 1, and that this is found before anything is simulated.
/// A row of the same model, and a file that is no row, are replaced.
#[test]
fn the_row_of_another_model_stays() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("quick-rows/reaching-blind.json");
    files::write(&file, br#"{ "entry": { "name": "blind", "model_blake3": "0123" } }"#).unwrap();
    let Err(Fault::Input(error)) = blind(None).run(folder.path(), true, &Silent) else {
        panic!("the row is not refused");
    };
    assert!(error.file == file && error.found.contains("0123"), "{error}");
    // Another name of a model's file would not help a controller.
    assert_eq!(error.remedy, "move that row elsewhere");
    assert!(!folder.path().join("quick-sets").exists());
    let of_model = |model: Option<&str>| EntryRecord {
        name: "blind".into(),
        classifier: None,
        model_blake3: model.map(str::to_owned),
    };
    assert!(of_model(Some("4567")).check_earlier_row(&file).is_err());
    of_model(Some("0123")).check_earlier_row(&file).unwrap();
    of_model(None).check_earlier_row(&folder.path().join("none.json")).unwrap();
    files::write(&file, br#"{ "benchmark": "incidental-contact-1", "entry": { "name": "blind" } }"#).unwrap();
    assert!(of_model(None).check_earlier_row(&file).unwrap_err().found.contains("incidental-contact-1"));
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
    let touching = |object: u16, frames: u32, peak_force_n: f64, mean_force_n: f64| Contact {
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
    // A frame of a goal in which these objects press on a link, N.
    let frame = |goal_index: u16, pressing: &[(u16, f32)]| {
        let point = |(object, force_n): &(u16, f32)| ContactPoint {
            link: 3,
            patch: Some(0),
            object: Some(*object),
            body: 0,
            position_world: glam::Vec3::ZERO,
            normal_world: glam::Vec3::X,
            force_world: glam::Vec3::X * *force_n,
            moment_world: glam::Vec3::ZERO,
            slip_world: glam::Vec3::ZERO,
            depth_m: 0.0,
            area_m2: 0.0,
        };
        Frame { goal_index, contact_points: pressing.iter().map(point).collect(), ..Frame::blank(1) }
    };
    let reach = |goals: Vec<GoalRecord>, contacts: Vec<Contact>, frames: Vec<Frame>| {
        let recording = Recording { objects: objects.to_vec(), goals, contacts, frames, ..Recording::default() };
        reaching::Reach::of(3, &recording)
    };
    let reaches = [
        reach(
            vec![goal(Outcome::Reached, 2.0), goal(Outcome::Stuck, 4.0)],
            vec![touching(0, 100, 3.0, 0.5), touching(1, 10, 8.0, 2.0), touching(1, 10, 6.0, 2.0)],
            // Two parts of one trunk press with 6 N in all.
            vec![frame(0, &[(1, 4.0), (1, 2.0)]), frame(1, &[(1, 1.0)])],
        ),
        reach(
            vec![goal(Outcome::Reached, 3.0)],
            vec![touching(0, 50, 1.0, 0.2)],
            vec![frame(0, &[(0, 8.0), (1, 4.9)]), frame(1, &[(1, 9.0)])],
        ),
    ];
    let found = reaching::figures(&reaches);
    let near = |estimate: Estimate, expected: f64| (estimate.value.unwrap() - expected).abs() < 1e-12;
    // Three goals each, of which the second reach tried one.
    assert_eq!((found.reaches, found.goals, found.largest_on_trunk_n), (2, 6, 8.0));
    assert!(near(found.reached, 2.0 / 6.0));
    assert!(near(found.reached_gently, 1.0 / 6.0));
    assert!(near(found.seconds_for_each, 9.0 / 2.0));
    assert!(near(found.trunk_peak_n, (8.0 + 0.0) / 2.0));
    // 1 s at 0.5 N, and 0.5 s at 0.2 N.
    assert!(near(found.leaf_impulse_n_s, (0.5 + 0.1) / 2.0));
}

/// Ends everything at once.
struct Stopped;

impl Progress for Stopped {
    fn stage(&self, _: &str) {}

    fn remark(&self, _: &str) {}

    fn count(&self, _: &str, _: u64, _: u64) -> Box<dyn Counter> {
        Box::new(Silent)
    }

    fn is_stopped(&self) -> bool {
        true
    }
}

/// Tests that reaches are read in their order, and that the user can end a run while figures are made of them.
#[test]
fn figures_can_be_ended() {
    let folder = tempfile::tempdir().unwrap();
    let text = "summary = \"A trunk\"\n[goals]\ncount = 1\n[[objects.trunk]]\ncount = 1\n";
    let campaign = Campaign::new(vec![Scene::parse("trunk.toml", text.into()).unwrap()], 3, 1).unwrap();
    let set = campaign.write(&folder.path().join("set"), false, &Silent).unwrap().dataset();
    let read = each_episode(&set, &Silent, |place, reach| Ok((place as u64, reach.reach_index))).unwrap();
    assert_eq!(read, [(0, 0), (1, 1), (2, 2)]);
    let sets = ["one", "other"].map(|name| (name.to_owned(), Dataset::open(folder.path().join("set")).unwrap()));
    assert!(blind(None).figures(&sets, &Silent).is_ok());
    let stopped = blind(None).figures(&sets, &Stopped).err().unwrap();
    assert_eq!(stopped.to_string(), Fault::from(ReachError::Stopped).to_string());
}

/// Tests that the user can end a campaign while its reaches are drawn, before anything is written.
#[test]
fn draws_can_be_ended() {
    let folder = tempfile::tempdir().unwrap();
    let text = "summary = \"A trunk\"\n[goals]\ncount = 1\n[[objects.trunk]]\ncount = 1\n";
    let campaign = Campaign::new(vec![Scene::parse("trunk.toml", text.into()).unwrap()], 3, 1).unwrap();
    let out = folder.path().join("set");
    let stopped = campaign.write(&out, false, &Stopped).err().unwrap();
    assert_eq!((stopped.to_string(), out.exists()), (Fault::from(ReachError::Stopped).to_string(), false));
}
