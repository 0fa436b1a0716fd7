use std::sync::Arc;

use underbrush_recording::{Category, TaxelReading};

use super::*;
use crate::any_model::OnlineModel;
use crate::error::ModelError;
use crate::evaluate::classify_touch_stream;
use crate::evaluate::touch::TouchEvaluation;
use crate::touch::{TouchClassifier, TouchDecision, TouchExamples, TouchModel, TouchOptions, TouchVerdict};

fn examples() -> TouchExamples {
    let mut examples = TouchExamples::new(TouchOptions::default());
    for recording in reaches() {
        examples.add(&recording).unwrap();
    }
    examples
}

/// Tests the errors for a single reach, and for reaches in which nothing known touches the skin, in all of them or in
/// all but one.
#[test]
fn too_little_to_fit_to_is_refused() {
    let mut examples = TouchExamples::new(TouchOptions::default());
    examples.add(&reaches()[0]).unwrap();
    assert!(
        matches!(examples.fit(None), Err(ModelError::Mismatch { found, .. }) if found.starts_with("1 reach to fit to"))
    );
    let mut examples = TouchExamples::new(TouchOptions::default());
    for _ in 0..3 {
        examples.add(&presses(0, STIFFNESS_N_PER_M[0], 0.0, 0.06)).unwrap();
    }
    assert_eq!(examples.fit(None), Err(ModelError::NoCategories(3)));
    examples.add(&reaches()[0]).unwrap();
    let error = examples.fit(None).unwrap_err().to_string();
    assert!(error.contains("touches the skin in one of 4 recordings; allowed: 2"), "{error}");
}

/// Tests that the networks that judge held-out reaches are fitted to rows even if each category is in one reach only,
/// and that reaches of each category go to the folds in turn if there are several.
#[test]
fn both_folds_have_rows() {
    assert_eq!(examples().folds(), [0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1]);
    assert_eq!(examples().some(|index| index < 2).folds(), [0, 1]);
}

/// Tests that soft, stiff and spurious readings are told apart in a new reach, and that the model is the same for
/// any number of threads.
#[test]
fn springs_are_told_apart() {
    let model = examples().fit(None).unwrap();
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(alone.install(|| examples().fit(None).unwrap()), model);
    let model = Arc::new(model);
    assert_eq!(model.categories(), ["leaf", "trunk"]);
    let mut evaluation = TouchEvaluation::default();
    for (object, depth_m) in [(0, 0.035), (1, 0.0025)] {
        let reach = presses(object, 1.15 * STIFFNESS_N_PER_M[usize::from(object)], depth_m, 0.06);
        evaluation.add(TouchEvaluation::of(&model, &reach).unwrap());
    }
    let [nothing, leaf, trunk, other] = evaluation.tallies[..] else {
        panic!("{} truths", evaluation.tallies.len());
    };
    for tally in [nothing, leaf, trunk] {
        assert!(tally.right as f64 > 0.9 * tally.total() as f64, "{tally:?}");
    }
    assert_eq!(other.total(), 0);
    let accuracy = evaluation.accuracy(model.categories()).unwrap();
    assert_eq!(accuracy.balanced_accuracy, Some(1.0));
}

/// Tests that a soft contact is not called stiff because of the stiff one beside it, which counts as the same object.
#[test]
fn contacts_of_one_object_are_told_apart() {
    let mut reach = presses(0, STIFFNESS_N_PER_M[0], 0.035, 0.06);
    for frame in &mut reach.frames {
        let depth_m = frame.patch_pose_world[0].position.z.max(0.0);
        let spurious = frame.taxels.iter_mut().find(|reading| reading.object.is_none()).unwrap();
        spurious.sensed_force_n = STIFFNESS_N_PER_M[1] * depth_m;
        (spurious.true_normal_force_n, spurious.object) = (spurious.sensed_force_n, Some(1));
    }
    let mut classifier = TouchClassifier::new(Arc::new(examples().fit(None).unwrap()), &reach.layout).unwrap();
    let mut frames = 0;
    for frame in &reach.frames {
        classifier.update(frame).unwrap();
        let [soft, stiff] = classifier.regions() else { continue };
        assert_eq!(soft.object, stiff.object);
        assert_eq!(classifier.objects()[0].touch, TouchVerdict::Category(1));
        assert_ne!(soft.touch, TouchVerdict::Category(1));
        assert_eq!(stiff.touch, TouchVerdict::Category(1));
        frames += 1;
    }
    assert!(frames > 50, "{frames}");
}

/// Tests that the verdicts on a reach that is judged for a suite are those of the evaluation, counted by truth, that the
/// spurious taxel is counted separately, and that the objects are those of the evaluation.
#[test]
fn streams_count_what_evaluations_count() {
    let model = Arc::new(examples().fit(None).unwrap());
    let reach = presses(0, 33.0, 0.035, 0.06);
    let evaluation = TouchEvaluation::of(&model, &reach).unwrap();
    let (stream, objects) = classify_touch_stream(&model, &reach).unwrap();
    assert_eq!(objects, evaluation.objects);
    assert_eq!(stream.verdicts, ["leaf", "trunk", "uncertain", "outlier", "nothing"]);
    let leaf = stream.tally_of(Some(Category::LEAF));
    assert_eq!(leaf, evaluation.tallies[1]);
    assert!(leaf.right > 100);
    // Taxel 16 reads a force in all 200 frames, and nothing presses on it.
    let without_truth = stream.tally_of(None);
    assert_eq!(without_truth, evaluation.tallies[0]);
    assert!(without_truth.total() == 200 && without_truth.nothing > 180, "{without_truth:?}");
}

/// Tests that a stream counts the verdicts on all patches that the model judges.
#[test]
fn streams_count_all_judged_patches() {
    let model = Arc::new(examples().fit(None).unwrap());
    let one = presses(0, 33.0, 0.035, 0.06);
    let mut two = one.clone();
    let further = underbrush_recording::Patch { name: "further".into(), ..one.layout.patches[0].clone() };
    two.layout.patches.push(further);
    for frame in &mut two.frames {
        frame.patch_pose_world.push(frame.patch_pose_world[0]);
        frame.taxels.extend(frame.taxels.clone().into_iter().map(|reading| TaxelReading { patch: 1, ..reading }));
    }
    let count = |reach: &Recording| {
        let (stream, _) = classify_touch_stream(&model, reach).unwrap();
        let leaf = stream.tally_of(Some(Category::LEAF));
        assert_eq!(leaf, TouchEvaluation::of(&model, reach).unwrap().tallies[1]);
        (leaf.total(), stream.tally_of(None).total(), stream.contacts.len())
    };
    let (own, both) = (count(&one), count(&two));
    assert!(own.0 > 100);
    assert_eq!(both, (2 * own.0, 2 * own.1, 2 * own.2));
}

/// Tests that nothing is allocated for a frame once as many contacts were seen before.
#[test]
fn verdicts_allocate_nothing() {
    let reach = presses(0, 30.0, 0.03, 0.05);
    let model = Arc::new(examples().fit(None).unwrap());
    let mut classifier = TouchClassifier::new(model, &reach.layout).unwrap();
    let mut verdicts = 0;
    for frame in &reach.frames[..60] {
        classifier.update(frame).unwrap();
    }
    let allocations = allocation_counter::measure(|| {
        for frame in &reach.frames[60..] {
            classifier.update(frame).unwrap();
            verdicts += classifier.taxels().len();
        }
    });
    assert!(verdicts > 200, "{verdicts}");
    assert_eq!(allocations.count_total, 0);
}

/// Tests that a model that is read back equals the model that was written, and that damaged files are refused with the
/// place of the damage.
#[test]
fn files_are_exact_and_checked() {
    let model = examples().fit(None).unwrap();
    let text = model.save_string().unwrap();
    assert_eq!(TouchModel::from_json("touch.json", &text).unwrap(), model);
    for (from, to, place) in [
        ("underbrush-touch/1", "underbrush-touch/9", "format"),
        ("\"leaf\"", "\"zebra\"", "categories"),
        ("\"threshold_n\"", "\"threshold\"", "options"),
        ("\"unknown_share\": 0.05", "\"unknown_share\": 2", "decision.unknown_share"),
        ("\"sharpness\": ", "\"sharpness\": -", "touched"),
        ("\"mean\": [", "\"mean\": [ 0.0,", "touched"),
    ] {
        let broken = text.replacen(from, to, 1);
        assert_ne!(broken, text, "{from}");
        let error = TouchModel::from_json("touch.json", &broken).unwrap_err().to_string();
        assert!(error.contains("touch.json") && error.contains(place), "{error}");
    }
}

/// Tests that a file names what it is before the megabytes of trees, which once came first.
#[test]
fn keys_of_a_file_are_in_order() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../suites/touch.json");
    let text = TouchModel::from_json(path, &std::fs::read_to_string(path).unwrap()).unwrap().save_string().unwrap();
    let keys = text.lines().filter_map(|line| line.strip_prefix("  \"")?.split_once('"'));
    let keys: Vec<&str> = keys.map(|(key, _)| key).collect();
    let first = ["format", "categories", "options", "decision", "provenance"];
    let last = ["touched", "category", "of_objects", "unknown_objects", "stiffness", "blake3"];
    assert_eq!(keys, [&first[..], &last[..]].concat());
}

/// Tests the rule: unknown comes first, then the likeliest category, if the expected cost of an error is below the cost
/// of an uncertain verdict.
#[test]
fn verdicts_follow_the_costs() {
    let decision = TouchDecision { unknown_share: 0.05, cost_of_uncertain: 0.2, ..TouchDecision::default() };
    let of_region = |probabilities: [f64; 2], share_beyond| decision.of_region(&probabilities, share_beyond, 300);
    assert_eq!(of_region([0.1, 0.9], 0.04), TouchVerdict::Unknown);
    assert_eq!(of_region([0.1, 0.9], 0.06), TouchVerdict::Category(1));
    assert_eq!(of_region([0.3, 0.7], 0.06), TouchVerdict::Uncertain);
}

/// Tests that until an object was felt in 60 samples, a fifth of the share is the limit.
#[test]
fn early_objects_must_be_more_unlike() {
    let decision = TouchDecision { unknown_share: 0.05, ..TouchDecision::default() };
    for (samples, share_beyond, expected) in [
        (59, 0.009, TouchVerdict::Unknown),
        (59, 0.011, TouchVerdict::Category(1)),
        (60, 0.049, TouchVerdict::Unknown),
        (60, 0.051, TouchVerdict::Category(1)),
    ] {
        assert_eq!(decision.of_region(&[0.1, 0.9], share_beyond, samples), expected, "{samples}, {share_beyond}");
    }
}

/// Tests that a patch is refused for a model of all patches, with that reason.
#[test]
fn a_model_of_all_patches_takes_no_patch() {
    let error = OnlineModel::of_touch(examples().fit(None).unwrap(), Some("forearm")).unwrap_err().to_string();
    assert!(error.contains("judges all patches of a skin"), "{error}");
}
