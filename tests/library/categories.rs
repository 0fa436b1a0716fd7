//! A category that is not built in, on its way from a reach to verdicts. How an object brings one is tested beside the
//! list of objects, in `sim/src/object/tests/mod.rs`.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use underbrush_classifier::decision::{Decision, Verdict};
use underbrush_classifier::evaluate::{StreamTruth, classify_stream};
use underbrush_classifier::online::OnlineOptions;
use underbrush_classifier::recipe::Recipe;
use underbrush_classifier::trial::{TrialOptions, taxel_trials};
use underbrush_classifier::{Classifier, HmmClassifier, is_trained};
use underbrush_experiments::Silent;
use underbrush_experiments::dataset::{Campaign, Written};
use underbrush_recording::disk::{Dataset, DatasetWriter};
use underbrush_recording::{Category, Recording, Trial};
use underbrush_sim::scene::Scene;

use crate::support::scenes::{LEAVES_AT_FOREARM, TRUNKS_AT_FOREARM};

const POST: Category = Category::new("post", 9).unwrap();

/// Simulated reaches into leaves and into trunks. The category of the trunks is changed to `post`.
fn reaches(folder: &Path) -> (Dataset, Vec<Recording>) {
    let scene = |name: &str, text: &str, reaches| {
        let scene = Scene::parse(format!("{name}.toml"), text.to_owned());
        (scene.unwrap(), reaches)
    };
    let campaign = Campaign {
        scenes: vec![scene("leaves", LEAVES_AT_FOREARM, 6), scene("posts", TRUNKS_AT_FOREARM, 2)],
        arms: BTreeMap::new(),
        seed: 0,
        controller: None,
        own_controller: None,
        verdicts: None,
        shard: None,
    };
    let Written::New(set) = campaign.write(folder, false, &Silent).unwrap() else { panic!("nothing was there before") };
    let mut recordings: Vec<Recording> = (0..8).map(|index| set.read_reach(index).unwrap()).collect();
    let objects = recordings.iter_mut().flat_map(|recording| &mut recording.objects);
    for object in objects.filter(|object| object.category == Category::TRUNK) {
        object.category = POST;
    }
    (set, recordings)
}

/// Tests that reaches with a further category are written to a data set and read back, that trials are cut and models
/// trained under its name, and that online verdicts are counted under it.
#[test]
fn a_further_category_goes_from_a_reach_to_verdicts() {
    let folder = tempfile::tempdir().unwrap();
    let (simulated, recordings) = reaches(&folder.path().join("simulated"));
    let mut plan = simulated.plan().clone();
    plan.categories = vec![POST];
    let writer = DatasetWriter::create(folder.path().join("posts"), plan, false).unwrap();
    for (position, recording) in recordings.iter().enumerate() {
        writer.stage(position, recording).unwrap();
    }
    let set = writer.finish().unwrap();
    let read: Vec<Recording> = (0..8).map(|index| set.read_reach(index).unwrap()).collect();
    assert!(read == recordings, "read back as written");

    let cut = |recording: &Recording| taxel_trials(recording, &TrialOptions::default()).unwrap();
    let trials: Vec<Trial> = read.iter().flat_map(cut).map(|found| found.trial).collect();
    let categories: BTreeSet<&str> = trials.iter().filter_map(|trial| trial.category.as_deref()).collect();
    assert!(categories.contains("leaf") && categories.contains("post"), "{categories:?}");
    assert!(!categories.contains("trunk") && is_trained("post"));

    let models = HmmClassifier::train(&trials, &Recipe { states: 3, ..Recipe::modern() }).unwrap();
    assert_eq!(models.categories(), ["leaf", "post"]);
    let options =
        OnlineOptions { patch: None, threshold_n: TrialOptions::default().threshold_n, decision: Decision::argmax() };
    let (mut judged, mut named, mut touched) = (0, 0, 0);
    for recording in &read[6..] {
        let stream = classify_stream(&models, recording, &options, StreamTruth::Object).unwrap();
        let row = stream.truths.iter().position(|truth| *truth == POST).unwrap();
        let post = Verdict::Category("post".into());
        let column = stream.verdicts.iter().position(|name| name == post.name()).unwrap();
        judged += stream.taxel_frames[row].iter().sum::<usize>();
        named += stream.taxel_frames[row][column];
        touched += stream.frames.iter().filter(|frame| frame.touched[row]).count();
    }
    assert!(touched > 0 && judged > 0, "{touched} frames, {judged} taxels judged");
    assert!(named > 0, "none of {judged} was called a post");
}
