//! A whole report from a handful of small reaches.
#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use std::collections::BTreeSet;

use rayon::prelude::*;
use underbrush_recording::{Category, Recording};
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;
use xml::reader::{EventReader, XmlEvent};

#[path = "../../../tests/support/scenes.rs"]
#[expect(dead_code, reason = "two of the scenes are for the tests of the command line")]
mod scenes;

mod sentences;
mod unrolled_skin;

use std::path::Path;

use underbrush_experiments::ablation::{self, Ablated};
use underbrush_experiments::analysis::{Analysis, Data};
use underbrush_experiments::campaign::Trials;
use underbrush_experiments::measurement::{Measurement, OneOfMany};
use underbrush_experiments::reaches::{Found, TestReaches};
use underbrush_experiments::results::{self, Campaigns, Results};
use underbrush_experiments::timing::Stages;
use underbrush_experiments::{Silent, data, online, snapshot, splits};

use crate::page;

fn plan(name: &str, text: &str) -> ReachPlan {
    let scene = Scene::parse(name, text.into()).unwrap();
    ReachPlan::new(scene, None, 5).unwrap()
}

fn reaches(name: &str, text: &str) -> Vec<Recording> {
    let plan = plan(name, text);
    // Enough for two contacts of each category at least, whatever the physics makes of a single reach.
    let run = |index| plan.run(index, &mut |_, _| {}).unwrap();
    (0..8_u64).into_par_iter().map(run).collect()
}

fn found(scene: &str, reaches: &[Recording]) -> Found {
    Found {
        scene: scene.into(),
        drawn: reaches.len() as u64,
        reaches: reaches.to_vec(),
    }
}

/// Sixteen small reaches, some of which are tested on too.
fn data() -> Data {
    let [leaves, trunks] = [
        ("leaves.toml", scenes::LEAVES_AT_FOREARM),
        ("trunks.toml", scenes::TRUNKS_AT_FOREARM),
    ]
    .map(|(name, text)| reaches(name, text));
    let mut contacts = Trials::default();
    for (place, recording) in leaves.iter().chain(&trunks).enumerate() {
        contacts.append(place, Trials::cut(recording, &data::any_length_options()).unwrap());
    }
    Data {
        seed: 0,
        quick: true,
        reaches: results::Reaches::of(&[], &underbrush_recording::SkinLayout::default()),
        trials: contacts.lasting(data::trial_options().min_samples),
        contacts: contacts.taxel,
        tested: TestReaches {
            engineered: vec![
                (Category::LEAF, found("leaves", &leaves[..1])),
                (Category::TRUNK, found("none", &[])),
            ],
            mixed: found("trunks", &trunks[..1]),
            outlier: found("trunks-again", &trunks[1..]),
        },
    }
}

/// Writes a report of the data into a folder, with what would need more reaches made up from them.
fn report(data: &Data, folder: &Path) -> Results {
    let Analysis {
        mut results,
        models,
        online,
        thresholds,
    } = Analysis::of(data, &mut Stages::begin(&Silent)).unwrap();
    let Measurement {
        trials_per_reach,
        table_1,
    } = results.measurement.clone();
    let one = OneOfMany::new(results.measurement.clone(), &results.classifiers);
    results.campaigns = Campaigns::of(&[(0, one.clone()), (1, one)]).unwrap();
    let settings = ["one", "other"].map(|name| splits::Setting::new(name, &data.trials.taxel, [8, 8], [8, 8]));
    results.splits = splits::splits(&settings).unwrap();
    results.ablation = [ablation::AS_IS, "something"]
        .map(|change| Ablated::new(change, table_1.clone(), trials_per_reach.clone()))
        .to_vec();
    let moment = |name, shown| {
        let moment = snapshot::take(
            &models,
            shown,
            &plan(name, scenes::TRUNKS_AT_FOREARM),
            online::uncertain_rule(),
        )
        .unwrap();
        assert!(moment.is_some());
        moment
    };
    let moments = [
        moment("trunks.toml", online.shown()),
        moment("trunks-again.toml", online.outlier.first()),
    ];
    std::fs::create_dir(folder.join("csv")).unwrap();
    for file in page::files(&results, &online, &thresholds, &moments) {
        std::fs::write(folder.join(file.path), file.text).unwrap();
    }
    results
}

/// Name, attributes and own text.
type Element = (String, Vec<(String, String)>, String);

/// All elements of a document, as a foreign parser reads it.
fn elements(document: &str) -> Vec<Element> {
    let (mut found, mut open): (Vec<Element>, Vec<usize>) = Default::default();
    for event in EventReader::from_str(document) {
        match event.unwrap() {
            XmlEvent::StartElement { name, attributes, .. } => {
                let attributes = attributes.into_iter().map(|own| (own.name.local_name, own.value));
                open.push(found.len());
                found.push((name.local_name, attributes.collect(), String::new()));
            }
            XmlEvent::Characters(text) => found[*open.last().unwrap()].2 += &text,
            XmlEvent::EndElement { .. } => drop(open.pop()),
            _ => {}
        }
    }
    found
}

/// What no page may hold: numbers that are none, and links to other sites. The only addresses are those that name SVG.
fn faults(html: &str) -> Vec<&str> {
    let outside_svg = html.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    let bad = ["NaN", "inf %", "inf N", "http://", "https://"];
    bad.into_iter().filter(|bad| outside_svg.contains(bad)).collect()
}

/// Pins that the check of a page finds each fault that it looks for, also beside charts.
#[test]
fn the_check_of_a_page_can_fail() {
    let chart = "<svg xmlns=\"http://www.w3.org/2000/svg\"></svg>";
    assert_eq!(faults(chart), Vec::<&str>::new());
    assert_eq!(faults(&format!("<p>NaN %</p>{chart}")), ["NaN"]);
    assert_eq!(faults(&format!("{chart}<p>peak force inf N</p>")), ["inf N"]);
    assert_eq!(faults(&format!("{chart}<a href=\"http://example.org\">")), ["http://"]);
    assert_eq!(faults("<img src=\"https://example.org/a.png\">"), ["https://"]);
}

#[test]
fn a_report_is_whole() {
    // Pins, on a report of sixteen small reaches: the page is XML; every figure is an image with words; all that it links to
    // is there; all CSV files parse, with equal columns in every row, and are the same bytes when all is made again by
    // three threads, but for the two files of wall times; Table I has 24 cells within their intervals; the keys of the
    // summary that other programs rely on.
    let folder = tempfile::tempdir().unwrap();
    let data = data();
    let results = report(&data, folder.path());
    let again = tempfile::tempdir().unwrap();
    let other_threads = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    other_threads.install(|| report(&data, again.path()));

    let html = std::fs::read_to_string(folder.path().join("index.html")).unwrap();
    let elements = elements(html.strip_prefix("<!DOCTYPE html>\n").unwrap());
    let of = |element: &str, attribute: &str| -> Vec<String> {
        let own = elements.iter().filter(|own| own.0 == element);
        let values = own.flat_map(|own| own.1.iter().filter(|(name, _)| name == attribute));
        values.map(|(_, value)| value.clone()).collect()
    };
    // The view into a close-up is an image within an image.
    let within = |attributes: &[(String, String)]| attributes.iter().any(|(name, _)| name == "x");
    let images = elements
        .iter()
        .filter(|(name, attributes, _)| name == "svg" && !within(attributes));
    let charts = images.count();
    assert!(charts >= 22, "{charts}");
    assert_eq!(of("svg", "role"), vec!["img"; charts]);
    let ids: Vec<String> = elements
        .iter()
        .flat_map(|own| own.1.iter().filter(|(name, _)| name == "id"))
        .map(|(_, value)| value.clone())
        .collect();
    assert_eq!(
        ids.iter().collect::<BTreeSet<_>>().len(),
        ids.len(),
        "two elements with one id: {ids:?}"
    );
    for label in of("svg", "aria-labelledby").iter().flat_map(|labels| labels.split(' ')) {
        assert!(ids.iter().any(|id| id == label), "{label}");
    }
    for link in of("a", "href") {
        match link.strip_prefix('#') {
            Some(section) => assert!(ids.iter().any(|id| id == section), "{link}"),
            None => assert!(folder.path().join(&link).exists(), "{link}"),
        }
    }
    assert_eq!(faults(&html), Vec::<&str>::new());

    let mut with_wall_times = BTreeSet::new();
    for file in std::fs::read_dir(folder.path().join("csv")).unwrap() {
        let path = file.unwrap().path();
        let mut reader = csv::Reader::from_path(&path).unwrap();
        // The reader refuses rows of another length than the header's.
        reader.records().for_each(|row| drop(row.unwrap()));
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if std::fs::read(&path).unwrap() != std::fs::read(again.path().join("csv").join(&name)).unwrap() {
            with_wall_times.insert(name);
        }
    }
    assert_eq!(
        with_wall_times,
        BTreeSet::from(["figure_8_times.csv".to_owned(), "stage_times.csv".to_owned()])
    );

    let summary = serde_json::to_value(&results).unwrap();
    for key in [
        "seed",
        "trials_per_reach",
        "orderings",
        "campaigns",
        "figure_5",
        "figure_6",
        "figure_9",
        "figure_11",
        "figure_13",
        "figure_15",
        "roc",
        "figure_5_medians",
        "classifiers",
        "speeds",
        "splits",
        "ablation",
        "timing",
    ] {
        assert!(!summary[key].is_null(), "{key}");
    }
    let table = summary["table_1"].as_array().unwrap();
    assert_eq!(table.len(), 24);
    for cell in table {
        let number = |key: &str| cell[key].as_f64().unwrap();
        assert!(
            number("low") <= number("accuracy") && number("accuracy") <= number("high"),
            "{cell}"
        );
        for key in ["by", "features", "recipe"] {
            assert!(cell[key].is_string(), "{cell}");
        }
        assert!(number("states") >= 5.0 && number("paper") > 50.0);
        // No accuracy stands alone: two categories make the majority half at least.
        assert!(number("majority_baseline") >= 50.0 && (0.0..=100.0).contains(&number("balanced_accuracy")));
    }
}
