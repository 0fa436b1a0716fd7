use std::collections::BTreeMap;

use underbrush_recording::{ObjectRecord, Recording};

use super::*;
use crate::hmm::{GaussianHmm, HmmParameters};
use crate::hmm_classifier::HmmClassifier;
use crate::trial::tests::{Drawn, recording};
use crate::{Decision, FeatureSet, OnlineOptions, Rule};

/// Models of leaf (mean 0.5 N) and trunk (3 N), both with one state and variance 1 N². A sample of 0.5 N or of 3 N then
/// adds (3 − 0.5)² / 2 = 3.125 nats to the margin.
fn models() -> HmmClassifier {
    let model = |mean_n: f64| {
        let parameters = HmmParameters {
            initial: vec![1.0],
            transition: vec![vec![1.0]],
            mean: vec![vec![mean_n]],
            covariance: vec![vec![vec![1.0]]],
        };
        GaussianHmm::new(parameters).unwrap()
    };
    let models = BTreeMap::from([("leaf".to_owned(), model(0.5)), ("trunk".to_owned(), model(3.0))]);
    HmmClassifier::new(FeatureSet::FORCE, models).unwrap()
}

fn options(rule: Rule) -> OnlineOptions {
    OnlineOptions { patch: None, threshold_n: 0.0, decision: Decision::new(rule) }
}

/// Six frames: taxel 2 touches the leaf (object 0) lightly, taxel 7 the trunk (object 1) lightly, taxel 9 the trunk
/// firmly with a break in frame 4, and taxel 11 senses a large force without an object.
fn reach() -> Recording {
    let full = [(2, 0.5, Some(0)), (7, 0.5, Some(1)), (9, 3.0, Some(1)), (11, 3.0, None)];
    let broken = [full[0], full[1], full[3]];
    let frames: Vec<Drawn> = (0..6).map(|k| (0.0, if k == 4 { &broken[..] } else { &full[..] })).collect();
    recording(&frames)
}

/// Tests the counts with argmax on a reach that can be counted by hand: one leaf right, one lightly touched trunk
/// wrong, one firmly touched trunk right except in the frame of its break, and one taxel without truth.
#[test]
fn verdicts_are_tallied_by_truth() {
    let stream = classify_stream(&models(), &reach(), &options(Rule::Argmax), StreamTruth::Object).unwrap();
    assert_eq!(stream.total(), Tally { right: 6 + 5, wrong: 6, ..Tally::default() });
    // Without truth, nothing would be right.
    assert_eq!(stream.tally_of(None), Tally { wrong: 6, ..Tally::default() });
    assert_eq!(stream.frames[4].without_truth(), 1);
    assert_eq!(stream.verdicts, ["leaf", "trunk", "uncertain", "outlier"]);
    let expected = [vec![6, 0, 0, 0], vec![6, 5, 0, 0], vec![0; 4], vec![0; 4], vec![0, 6, 0, 0]];
    assert_eq!(stream.taxel_frames, expected);
    assert_eq!(stream.frames[4].by_verdict, [2, 1, 0, 0]);
    assert!(stream.frames.iter().all(|frame| frame.touched == [true, true, false, false]));
    assert_eq!(stream.seconds.len(), 6);
}

/// Tests when each contact of [`reach`] is judged rightly for the first time. A sample adds 3.125 nats to the margin,
/// so a margin of 5 takes two samples. A break begins a new contact, and contacts without an object are left out.
#[test]
fn the_first_right_verdict_of_each_contact_is_found() {
    let rule = Rule::UncertainBelow { margin: 5.0 };
    let stream = classify_stream(&models(), &reach(), &options(rule), StreamTruth::Object).unwrap();
    let contact = |truth, first_right| StreamContact { truth, first_right };
    let expected = [
        contact(Category::LEAF, Some(2)),
        contact(Category::TRUNK, None),
        contact(Category::TRUNK, Some(2)),
        contact(Category::TRUNK, None),
    ];
    assert_eq!(stream.contacts, expected);
}

/// Tests that the tally of one category is its row of the matrix, and that the rows of all categories add up to the
/// total.
#[test]
fn a_category_has_a_tally_of_its_own() {
    let rule = Rule::UncertainBelow { margin: 5.0 };
    let stream = classify_stream(&models(), &reach(), &options(rule), StreamTruth::Object).unwrap();
    let [leaf, trunk] = [Category::LEAF, Category::TRUNK].map(|truth| stream.tally_of(Some(truth)));
    // In their first samples taxel 2, taxel 7 and both contacts of taxel 9 are uncertain.
    let tally = |right, wrong, uncertain| Tally { right, wrong, uncertain, ..Tally::default() };
    assert_eq!(leaf, tally(5, 0, 1));
    assert_eq!(trunk, tally(3, 5, 3));
    assert_eq!(stream.tally_of(Some(Category::OUTLIER)), Tally::default());
    assert_eq!(Tally::sum([leaf, trunk]), stream.total());
}

/// Tests StreamTruth::Environment: in a trunk-only environment, trunk is the truth even for the taxel without an
/// object.
#[test]
fn an_environment_is_everyones_truth() {
    let truth = StreamTruth::Environment(Category::TRUNK);
    let stream = classify_stream(&models(), &reach(), &options(Rule::Argmax), truth).unwrap();
    assert_eq!(stream.total(), Tally { right: 5 + 6, wrong: 12, ..Tally::default() });
    assert_eq!(stream.tally_of(None), Tally::default());
}

/// Tests the quantity of Fig. 9: with a required margin of 10 nats and 3.125 nats per sample, a verdict needs 4
/// samples. It is 0 before that and stays 4 afterwards, while the samples since contact increase. A new contact starts
/// again at 0.
#[test]
fn samples_used_are_those_at_the_verdict() {
    let rule = Rule::UncertainBelow { margin: 10.0 };
    let stream = classify_stream(&models(), &reach(), &options(rule), StreamTruth::Object).unwrap();
    let used: Vec<f64> = stream.frames.iter().map(|frame| frame.mean_samples_used).collect();
    assert_eq!(used, [0.0, 0.0, 0.0, 4.0, 4.0, 3.0]);
    let since: Vec<f64> = stream.frames.iter().map(|frame| frame.mean_samples_since_contact).collect();
    assert_eq!(since, [1.0, 2.0, 3.0, 4.0, 5.0, (6.0 * 3.0 + 1.0) / 4.0]);
    assert_eq!(stream.mean_samples_used(), Some((4.0 + 4.0 + 3.0) / 6.0));
    assert_eq!(stream.frames[5].tally.uncertain, 1);
}

/// Tests that, for a category without a model, outlier is the right verdict and a known category is wrong, and that a
/// known category called outlier is wrong.
#[test]
fn a_foreign_object_is_rightly_an_outlier() {
    let mut recording = reach();
    recording.objects[1] =
        ObjectRecord { kind: "foam_roll".into(), category: Category::OUTLIER, ..recording.objects[1].clone() };
    let rule = Rule::OutlierBand { uncertain_below: 0.0, category_above: 10.0 };
    let stream = classify_stream(&models(), &recording, &options(rule), StreamTruth::Object).unwrap();
    // Margins grow by 3.125 nats per sample: outlier after samples 1 to 3, then a category.
    assert_eq!(stream.taxel_frames[0], [3, 0, 0, 3]);
    assert_eq!(stream.taxel_frames[3], [3, 1, 0, 3 + 3 + 1]);
    assert_eq!(stream.total(), Tally { right: 3 + 7, wrong: 3 + 4, unknown: 3 + 7, ..Tally::default() });
}

/// Tests that the same verdicts are right in a stream and for a whole trial, for each category and verdict. A block
/// called outlier was once right in a stream and wrong as a trial.
#[test]
fn right_in_a_stream_is_right_as_a_trial() {
    let verdicts =
        [Verdict::Category("leaf".into()), Verdict::Category("trunk".into()), Verdict::Uncertain, Verdict::Outlier];
    let categories = ["leaf".to_owned(), "trunk".to_owned()];
    let mut right = Vec::new();
    for truth in Category::BUILT_IN {
        for verdict in &verdicts {
            let mut counts = vec![0; 4];
            counts[verdict.index(&categories).unwrap()] = 1;
            let stream = Stream {
                truths: vec![truth],
                verdicts: ["leaf", "trunk", "uncertain", "outlier"].map(str::to_owned).to_vec(),
                taxel_frames: vec![counts, vec![0; 4]],
                ..Stream::default()
            };
            let prediction = crate::evaluate::Prediction {
                trial: 0,
                reach: None,
                category: truth.name().into(),
                fold: 0,
                samples: 1,
                touched: None,
                scores: vec![],
                verdict: verdict.clone(),
            };
            let is_right = prediction.record(&categories).is_right(&categories);
            let tally = stream.tally_of(Some(truth));
            assert_eq!(tally.right == 1, is_right, "{truth:?} called {}", verdict.name());
            if is_right {
                right.push((truth, verdict.name()));
            }
        }
    }
    let expected = [(Category::LEAF, "leaf"), (Category::TRUNK, "trunk"), (Category::OUTLIER, "outlier")];
    assert_eq!(right, expected);
}

/// Tests that a reach without contact does not divide zero by zero.
#[test]
fn no_contact_has_no_means() {
    let nothing: &[(u16, f64, Option<u16>)] = &[];
    let empty = recording(&[(0.0, nothing); 3]);
    let stream = classify_stream(&models(), &empty, &options(Rule::Argmax), StreamTruth::Object).unwrap();
    assert_eq!(stream.mean_samples_used(), None);
    assert_eq!(stream.seconds_per_100_taxels(), None);
    assert_eq!(stream.frames[2].mean_samples_used, 0.0);
}
