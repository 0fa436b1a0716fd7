//! Verdicts of a touch model, packed and sent while a reach runs.

use std::sync::{Arc, OnceLock};

use underbrush_classifier::touch::{TouchClassifier, TouchExamples, TouchModel, TouchOptions};
use underbrush_recording::{Category, Recording, TaxelReading};

use super::pack::Packed;
use super::{KNOWN, reach};
use crate::pack::{pack, pack_from};
use crate::{Judging, JudgingModel};

/// A reach in which an object of this category presses with this share of the usual force.
fn pressed_by(category: Category, share: f64, index: u64) -> Recording {
    let mut recording = reach(index, 60);
    recording.objects[0].category = category;
    for reading in recording.frames.iter_mut().flat_map(|frame| &mut frame.taxels) {
        if reading.object.is_some() {
            reading.sensed_force_n *= share;
            reading.true_normal_force_n *= share;
        }
    }
    recording
}

/// A model of weak leaves and strong trunks.
fn model() -> TouchModel {
    static MODEL: OnceLock<TouchModel> = OnceLock::new();
    let fit = || {
        let mut examples = TouchExamples::new(TouchOptions::default());
        for index in 0..12 {
            let (category, share) = match index % 2 {
                0 => (Category::LEAF, 0.1),
                _ => (Category::TRUNK, 1.0),
            };
            let share = share * (1.0 + 0.05 * index as f64);
            examples.add(&pressed_by(category, share, index)).unwrap();
        }
        examples.fit(None).unwrap()
    };
    MODEL.get_or_init(fit).clone()
}

fn judging() -> Judging {
    Judging { name: "touch.json".into(), by: JudgingModel::of_touch(model(), None).unwrap() }
}

/// Tests that the packed verdicts, probabilities and regions are those of the online classifier frame by frame, sorted
/// by taxel, and that the header says how to read them.
#[test]
fn verdicts_of_touch_models_are_packed() {
    let recording = pressed_by(Category::TRUNK, 1.1, 40);
    let packed = Packed::read(&pack(&recording, &KNOWN, Some(&judging())).unwrap());
    let header = &packed.header["reach"]["verdicts"];
    assert_eq!((&header["classifier"], &header["score_kind"]), (&"touch".into(), &"probability".into()));
    assert_eq!(header["scores"], serde_json::json!(["nothing", "leaf", "trunk"]));
    let names = ["nothing", "leaf", "trunk", "uncertain", "unknown"];
    assert_eq!(header["verdicts"], serde_json::json!(names));
    assert_eq!(header["touch"]["unknown_share"], model().decision.unknown_share);
    let features = header["features"].as_array().unwrap().len();
    let section = |name: &str| packed.section(name);
    let [starts, taxels, codes, scores, samples] =
        ["start", "taxel", "code", "score", "samples"].map(|part| section(&format!("verdict_{part}")));
    let [region_starts, contacts, beyond, of_region] =
        ["start", "contact", "share_beyond", "feature"].map(|part| section(&format!("touch_{part}")));
    let region_of = section("verdict_region");
    let mut online = TouchClassifier::new(Arc::new(model()), &recording.layout).unwrap();
    let mut several = 0;
    for (index, frame) in recording.frames.iter().enumerate() {
        online.update(frame).unwrap();
        let rows = starts[index] as usize..starts[index + 1] as usize;
        assert_eq!(rows.len(), online.taxels().len());
        assert!(taxels[rows.clone()].is_sorted_by(|a, b| a < b));
        several += usize::from(rows.len() > 1);
        for row in rows {
            let own = online.taxels().iter().find(|own| own.taxel as f64 == taxels[row]).unwrap();
            assert_eq!(names[codes[row] as usize], own.touch.name(online.model().categories()));
            assert_eq!(samples[row], own.samples as f64);
            let touched = online.probabilities(own.region).iter().map(|share| (1.0 - own.nothing) * share);
            for (place, expected) in std::iter::once(own.nothing).chain(touched).enumerate() {
                assert_eq!(scores[3 * row + place], f64::from(expected as f32));
            }
            let region = region_starts[index] as usize + region_of[row] as usize;
            assert_eq!(contacts[region], online.regions()[own.region].contact as f64);
            assert_eq!(beyond[region], f64::from(online.regions()[own.region].share_beyond as f32));
            let expected = online.patches()[0].regions()[own.region].course.features();
            let found = &of_region[features * region..][..features];
            assert_eq!(found, expected.map(|value| f64::from(value as f32)));
        }
    }
    assert_eq!(several, 1, "only one frame has two taxels");
    // Taxel 1 is pressed by a trunk until the end.
    assert_eq!(names[codes[codes.len() - 1] as usize], "trunk");
}

/// Tests that the bytes for the frames after the first eight have the verdicts and regions of these frames, with rows
/// that are counted from the first of them.
#[test]
fn what_follows_has_the_regions_of_a_touch_model() {
    let recording = pressed_by(Category::LEAF, 0.12, 41);
    let verdicts = judging().judge(&recording).unwrap();
    let whole = Packed::read(&pack_from(&recording, &KNOWN, Some(&verdicts), 0).unwrap());
    let rest = Packed::read(&pack_from(&recording, &KNOWN, Some(&verdicts), 8).unwrap());
    for (starts, rows) in [
        ("verdict_start", ["verdict_taxel", "verdict_code", "verdict_region"].as_slice()),
        ("touch_start", &["touch_contact", "touch_taxels", "touch_touched_taxels"]),
    ] {
        let first = whole.section(starts)[8];
        let expected: Vec<f64> = whole.section(starts)[8..].iter().map(|start| start - first).collect();
        assert_eq!(rest.section(starts), expected);
        for name in rows {
            assert_eq!(rest.section(name), whole.section(name)[first as usize..], "{name}");
        }
    }
    let features = rest.section("touch_feature").len();
    assert_eq!(features, 30 * rest.section("touch_contact").len());
    assert_eq!(
        rest.section("touch_feature"),
        whole.section("touch_feature")[whole.section("touch_feature").len() - features..]
    );
}

/// Tests that a second patch that feels the same far away has the same verdicts, with taxels and regions that are counted on
/// from those of the first, and with objects of its own.
#[test]
fn all_patches_have_verdicts() {
    let alone = pressed_by(Category::TRUNK, 1.1, 40);
    let mut both = alone.clone();
    let mut flipper = both.layout.patches[0].clone();
    flipper.name = "flipper".into();
    both.layout.patches.push(flipper);
    for frame in &mut both.frames {
        let mut pose = frame.patch_pose_world[0];
        pose.position.x += 10.0;
        frame.patch_pose_world.push(pose);
        let felt = frame.taxels.iter().map(|reading| TaxelReading { patch: 1, ..*reading });
        frame.taxels.extend(felt.collect::<Vec<_>>());
    }
    let taxels = alone.layout.patches[0].taxels.len() as f64;
    let [one, two] = [alone, both].map(|reach| Packed::read(&pack(&reach, &KNOWN, Some(&judging())).unwrap()));
    assert!(!one.section("verdict_code").is_empty());
    let [starts, regions] = ["verdict_start", "touch_start"].map(|name| one.section(name));
    assert_eq!(two.section("verdict_start"), starts.iter().map(|start| 2.0 * start).collect::<Vec<_>>());
    for (name, shift) in [("verdict_taxel", None), ("verdict_code", Some(0.0)), ("verdict_region", Some(f64::NAN))] {
        let own = one.section(name);
        let expected = starts.windows(2).zip(regions.windows(2)).flat_map(|(rows, regions)| {
            let rows = &own[rows[0] as usize..rows[1] as usize];
            let shift = shift.map_or(taxels, |shift: f64| if shift.is_nan() { regions[1] - regions[0] } else { shift });
            rows.iter().copied().chain(rows.iter().map(move |value| value + shift)).collect::<Vec<_>>()
        });
        assert_eq!(two.section(name), expected.collect::<Vec<_>>(), "{name}");
    }
}

/// Tests that a patch other than the one that the touch model was trained for is refused, and that a patch without a
/// grid is judged.
#[test]
fn another_patch_is_refused() {
    let error = JudgingModel::of_touch(model(), Some("hand")).unwrap_err();
    assert!(error.to_string().starts_with("patch hand: this touch model judges "), "{error}");
    let mut bare = reach(0, 20);
    bare.layout.patches[0].grid = None;
    assert!(pack(&bare, &KNOWN, Some(&judging())).is_ok());
}
