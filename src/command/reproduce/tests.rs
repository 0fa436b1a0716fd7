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

use super::ablation::Ablated;
use super::campaign::Measurement;
use super::reaches::Found;
use super::*;

fn plan(name: &str, text: &str) -> ReachPlan {
    let scene = Scene::parse(name, text.into()).unwrap();
    ReachPlan::new(scene, None, 5).unwrap()
}

fn reaches(name: &str, text: &str) -> Vec<Recording> {
    let plan = plan(name, text);
    // Enough for two contacts of each category at least, whatever the physics makes of a single reach.
    let run = |index| plan.run(index, &mut |_, _, _| {}).unwrap();
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
    let mut trials = Trials::default();
    for (place, recording) in leaves.iter().chain(&trunks).enumerate() {
        trials.append(place, Trials::cut(recording, &data::trial_options()).unwrap());
    }
    Data {
        seed: 0,
        quick: true,
        reaches: results::Reaches::of(&[]),
        trials,
        tested: TestReaches {
            engineered: vec![
                (Category::Leaf, found("leaves", &leaves[..1])),
                (Category::Trunk, found("none", &[])),
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
    } = Analysis::of(data, &mut Stages::begin()).unwrap();
    let Measurement {
        trials_per_reach,
        table_1,
    } = results.measurement.clone();
    let one = OneOfMany::new(results.measurement.clone(), &results.classifiers);
    results.campaigns = Campaigns::of(vec![0, 1], &[one.clone(), one]);
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
    page::write(folder, &results, &online, &thresholds, &moments).unwrap();
    results
}

/// Names and attributes of all elements, as a foreign parser reads them.
fn elements(document: &str) -> Vec<(String, Vec<(String, String)>)> {
    let start = |event: Result<XmlEvent, _>| match event.unwrap() {
        XmlEvent::StartElement { name, attributes, .. } => {
            let attributes = attributes.into_iter().map(|own| (own.name.local_name, own.value));
            Some((name.local_name, attributes.collect()))
        }
        _ => None,
    };
    EventReader::from_str(document).into_iter().filter_map(start).collect()
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
        let own = elements.iter().filter(|(name, _)| name == element);
        let values = own.flat_map(|(_, attributes)| attributes.iter().filter(|(name, _)| name == attribute));
        values.map(|(_, value)| value.clone()).collect()
    };
    // The view into a close-up is an image within an image.
    let within = |attributes: &[(String, String)]| attributes.iter().any(|(name, _)| name == "x");
    let images = elements
        .iter()
        .filter(|(name, attributes)| name == "svg" && !within(attributes));
    let charts = images.count();
    assert!(charts >= 22, "{charts}");
    assert_eq!(of("svg", "role"), vec!["img"; charts]);
    let ids: Vec<String> = elements
        .iter()
        .flat_map(|(_, attributes)| attributes.iter().filter(|(name, _)| name == "id"))
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
    assert!(
        !html.contains("NaN") && !html.contains("http://") || html.matches("http://").count() == charts,
        "links out"
    );

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
        "classifiers",
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
    }
}

#[test]
fn only_the_same_plan_goes_on() {
    // Pins: results of another seed, of another size and of no known plan are refused by name; the same plan goes on;
    // --fresh removes what reproduce makes, and nothing else.
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path();
    let refused = |plan: plan::Plan| plan.settle(out, false).unwrap_err().report().to_string();
    plan::Plan::new(3, true).settle(out, false).unwrap();
    plan::Plan::new(3, true).settle(out, false).unwrap();
    assert!(refused(plan::Plan::new(4, true)).contains("seed was 3, now 4"));
    assert!(refused(plan::Plan::new(3, false)).contains("quick was true, now false"));
    std::fs::create_dir(out.join("reaches")).unwrap();
    std::fs::write(out.join("reaches/mixed.json"), "{}").unwrap();
    std::fs::write(out.join("notes.txt"), "mine").unwrap();
    plan::Plan::new(4, true).settle(out, true).unwrap();
    assert!(!out.join("reaches").exists() && out.join("notes.txt").exists());
    plan::Plan::new(4, true).settle(out, false).unwrap();
    std::fs::remove_file(out.join("plan.json")).unwrap();
    plan::Plan::new(4, true).settle(out, false).unwrap();
    std::fs::remove_file(out.join("plan.json")).unwrap();
    std::fs::create_dir(out.join("dataset")).unwrap();
    assert!(refused(plan::Plan::new(4, true)).contains("--fresh"));
}

#[test]
fn orderings_are_found_as_they_are() {
    // Pins the three statements on tables made for it: the paper's own Table I breaks "10 and 20 over 5" nowhere and
    // the others nowhere; a table turned upside down breaks all of them everywhere.
    let table = |sign: f64| -> Vec<_> {
        let cells = underbrush_classifier::evaluate::TABLE_ONE_PAPER.into_iter();
        cells
            .map(|(unit, features, states, paper)| ("authors".to_owned(), unit, features, states, sign * paper))
            .collect()
    };
    let found = comparison::orderings(&table(1.0));
    let counts: Vec<(bool, usize, usize)> = found
        .iter()
        .map(|own| (own.holds, own.pairs_holding, own.pairs))
        .collect();
    assert_eq!(counts, [(true, 6, 6), (true, 6, 6), (true, 8, 8)]);
    let found = comparison::orderings(&table(-1.0));
    let counts: Vec<(bool, usize, usize)> = found
        .iter()
        .map(|own| (own.holds, own.pairs_holding, own.pairs))
        .collect();
    assert_eq!(counts, [(false, 0, 6), (false, 0, 6), (false, 0, 8)]);
}

#[test]
fn campaigns_have_mean_and_spread() {
    // Pins mean, sample standard deviation and range of three campaigns against numbers worked out by hand.
    let measurement = |accuracy: f64| OneOfMany {
        measurement: Measurement {
            trials_per_reach: Vec::new(),
            table_1: vec![campaign::Cell {
                by: TableOneUnit::Taxel,
                features: FeatureSet::Force,
                states: 10,
                recipe: "authors".into(),
                accuracy,
                low: 0.0,
                high: 100.0,
                paper: 80.24,
            }],
        },
        classifiers: vec![("some".into(), accuracy + 1.0)],
    };
    let found = Campaigns::of(vec![0, 1, 2], &[70.0, 74.0, 84.0].map(measurement)).unwrap();
    let cell = &found.table_1[0];
    assert_eq!((cell.accuracy, cell.least, cell.most), (76.0, 70.0, 84.0));
    // Deviations −6, −2, 8: (36 + 4 + 64) / 2 = 52.
    assert!((cell.standard_deviation.unwrap() - 52.0_f64.sqrt()).abs() < 1e-12);
    assert!((found.mean_absolute_difference_points["authors"] - 4.24).abs() < 1e-9);
    let some = &found.classifiers[0];
    assert_eq!((some.accuracy, some.least, some.most), (77.0, 71.0, 85.0));
    assert!((some.standard_deviation.unwrap() - 52.0_f64.sqrt()).abs() < 1e-12);
    assert!(
        Campaigns::of(vec![0], &[measurement(70.0)]).unwrap().table_1[0]
            .standard_deviation
            .is_none()
    );
}

#[test]
fn settings_are_tested_on_clutter_that_was_not_learned() {
    // Pins that of a campaign of 4 + 6 reaches a setting of 3 + 4 takes the first of each scene, half of them in either
    // fold; that of two settings with the forces of leaf and trunk exchanged each is told apart where it was learned, and
    // always wrongly at the other.
    let trial = |number: u64, reach: u64, force_n: f64| {
        let sample = |index: u32| {
            let force_n = force_n + 0.01 * f64::from((index * 7 + number as u32 * 3) % 11);
            underbrush_recording::Sample {
                time_s: f64::from(index) / 100.0,
                force_n,
                motion_m: Some(0.0),
                region: Some(underbrush_recording::Region {
                    taxels: 1,
                    largest_force_n: force_n,
                    force_sum_n: force_n,
                }),
            }
        };
        underbrush_recording::Trial {
            trial: number,
            category: Some(if reach < 4 { "leaf" } else { "trunk" }.into()),
            reach: Some(reach),
            patch: Some("forearm".into()),
            taxel: Some(0),
            samples: (0..30).map(sample).collect(),
        }
    };
    let trials = |leaf_n: f64, trunk_n: f64| -> Vec<underbrush_recording::Trial> {
        let numbers = 0..40_u64;
        let force = |reach: u64| if reach < 4 { leaf_n } else { trunk_n };
        numbers
            .map(|number| trial(number, number % 10, force(number % 10)))
            .collect()
    };
    let setting = |name, trials: &[underbrush_recording::Trial]| splits::Setting::new(name, trials, [4, 6], [3, 4]);
    let apart = setting("apart", &trials(0.5, 2.0));
    let reaches = |fold: &[underbrush_recording::Trial]| -> BTreeSet<u64> {
        fold.iter().filter_map(|trial| trial.reach).collect()
    };
    assert_eq!(reaches(&apart.folds[0]), BTreeSet::from([0, 1, 4, 5]));
    assert_eq!(reaches(&apart.folds[1]), BTreeSet::from([2, 6, 7]));

    let swapped = setting("swapped", &trials(2.0, 0.5));
    let learners = 2;
    let found = splits::splits(&[apart, swapped]).unwrap();
    let accuracies: Vec<f64> = found.iter().map(|split| split.accuracy).collect();
    assert_eq!(accuracies, [100.0, 0.0, 0.0, 100.0].repeat(learners));
    assert!(found.iter().all(|split| split.trials == 28 && split.low == split.high));
}

#[test]
fn the_papers_own_table_is_no_distance_from_itself() {
    // Pins the row of an ablation on the paper's own Table I, and on the same moved by 2 points up and down in turn.
    let table = |shift: f64| {
        let cells = underbrush_classifier::evaluate::TABLE_ONE_PAPER
            .into_iter()
            .zip([1.0, -1.0].into_iter().cycle());
        let cell = move |((by, features, states, paper), sign): ((TableOneUnit, FeatureSet, usize, f64), f64)| {
            campaign::Cell {
                by,
                features,
                states,
                recipe: "authors".into(),
                accuracy: paper + sign * shift,
                low: 0.0,
                high: 100.0,
                paper,
            }
        };
        Ablated::new("any", cells.map(cell), Vec::new())
    };
    let own = table(0.0);
    assert_eq!(own.mean_absolute_difference_points, 0.0);
    assert_eq!(
        (own.orderings_holding, own.orderings, own.pairs_holding, own.pairs),
        (3, 3, 20, 20)
    );
    // (61.76 + 72.22 + 70.75 + 54.41 + 55.55 + 58.50) / 6 and the same of the taxels.
    assert!((own.component_accuracy - 62.198_333).abs() < 1e-5 && (own.taxel_accuracy - 75.036_667).abs() < 1e-5);
    assert!((table(2.0).mean_absolute_difference_points - 2.0).abs() < 1e-9);
}
