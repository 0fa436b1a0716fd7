//! Tests of a whole report on small reaches.
#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use std::collections::BTreeSet;
use std::path::Path;

use roxmltree::{Document, Node, ParsingOptions};
use underbrush_experiments::{Experiment, Results, Session, Silent};

use crate::Written;

#[path = "../../../tests/support/scenes.rs"]
#[expect(dead_code, reason = "two of the scenes are for the tests of the command line")]
mod scenes;

mod further_categories;
mod sentences;
mod unrolled_skin;

/// A small experiment with every kind of section. Six reaches of a scene are enough for two contacts of each
/// category, whatever happens in a single reach.
const EXPERIMENT: &str = r#"title = "A small experiment"
states = [5]
recipes = ["authors", "modern"]
truncations = [6]
ablation = ["trials_of_any_length"]
training = [
    { scene = "leaves.toml", label = "leaf", reaches = 6 },
    { scene = "trunks.toml", label = "trunk", reaches = 6 },
]
engineered = [
    { scene = "leaves-alone.toml", label = "leaf" },
    { scene = "none.toml", label = "trunk", max_draws = 1 },
]
general = { scene = "both.toml", reaches = 1, max_draws = 20 }
outlier = { scene = "roll.toml", reaches = 1, max_draws = 20 }
second_outlier = { scene = "roll.toml", reaches = 1, max_draws = 20 }
verdicts = { scene = "both.toml", reaches = 4 }
settings = [{ name = "twice as stiff", robot = { stiffness_scale = 2.0, hand_speed_scale = 1.0 } }]
classifiers = [
    { name = "models, force", method = "hmm", features = ["force"], states = 5 },
    { name = "models, force and motion", method = "hmm", features = ["force", "motion"], states = 5 },
    { name = "regression", method = "logistic", features = ["force", "motion"] },
]
setting_classifiers = [{ name = "regression", method = "logistic", features = ["force", "motion"] }]

[published]
best_accuracy_percent = 81.4
samples_used = 11.9
seconds_per_100_taxels = 0.83
orderings = ["taxels_over_components"]
trials = [{ by = "taxel", label = "leaf", trials = 496, reaches = 10 }]
accuracy = [
    { by = "component", features = ["force"], states = 5, percent = 61.76 },
    { by = "taxel", features = ["force"], states = 5, percent = 72.91 },
]
sections.table_one = { figure = "Table I", statement = "Taxels are classified better than components." }
"#;

const TRUNKS: &str = "\n[[objects.trunk]]\ncount = 4\n\
    place = { x_m = { uniform = [0.25, 0.50] }, y_m = { uniform = [-0.50, -0.15] } }\n";
const ROLLS: &str = "\n[[objects.foam_roll]]\ncount = 3\n\
    place = { x_m = { uniform = [0.25, 0.50] }, y_m = { uniform = [-0.50, -0.15] } }\n";
/// The experiment with its scenes.
fn experiment(folder: &Path) -> Experiment {
    let leaves = scenes::LEAVES_AT_FOREARM;
    for (name, text) in [
        ("leaves.toml", leaves.to_owned()),
        ("trunks.toml", scenes::TRUNKS_AT_FOREARM.to_owned()),
        ("leaves-alone.toml", format!("stream = \"alone\"\n{leaves}")),
        // No reach among leaves touches trunks alone.
        ("none.toml", format!("stream = \"alone\"\n{leaves}")),
        ("both.toml", format!("{leaves}{TRUNKS}")),
        ("roll.toml", format!("{}{ROLLS}", scenes::TRUNKS_AT_FOREARM)),
        ("small.toml", EXPERIMENT.to_owned()),
    ] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    Experiment::load(&folder.join("small.toml")).unwrap()
}

/// Runs the experiment and writes its report into the folder.
fn report(experiment: &Experiment, folder: &Path) -> Results {
    // With this seed, most draws for the online tests meet their requirement at once.
    let session = Session::new(experiment, (3, false, 2), folder, &Silent);
    let results = Results::of(&session).unwrap();
    std::fs::create_dir(folder.join("csv")).unwrap();
    for (path, bytes) in Written::of(&results).unwrap().files {
        std::fs::write(folder.join(path), bytes).unwrap();
    }
    results
}

/// Name, attributes and own text.
pub(crate) type Element = (String, Vec<(String, String)>, String);

/// All elements of a document, as an independent parser reads it.
pub(crate) fn elements(document: &str) -> Vec<Element> {
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let parsed = Document::parse_with_options(document, options).unwrap();
    let element = |node: Node| {
        let attributes = node.attributes().map(|own| (own.name().to_owned(), own.value().to_owned()));
        let text = node.children().filter(Node::is_text).filter_map(|own| own.text());
        (node.tag_name().name().to_owned(), attributes.collect(), text.collect())
    };
    parsed.descendants().filter(Node::is_element).map(element).collect()
}

/// Faults that no page may have: values such as NaN, and links to other sites. The only addresses are SVG namespaces.
fn faults(html: &str) -> Vec<&str> {
    let outside_svg = html.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    let bad = ["NaN", "inf %", "inf N", "http://", "https://"];
    bad.into_iter().filter(|bad| outside_svg.contains(bad)).collect()
}

/// Tests that the check of a page finds each fault that it looks for, also beside charts.
#[test]
fn the_check_of_a_page_can_fail() {
    let chart = "<svg xmlns=\"http://www.w3.org/2000/svg\"></svg>";
    assert_eq!(faults(chart), Vec::<&str>::new());
    assert_eq!(faults(&format!("<p>NaN %</p>{chart}")), ["NaN"]);
    assert_eq!(faults(&format!("{chart}<p>peak force inf N</p>")), ["inf N"]);
    assert_eq!(faults(&format!("{chart}<a href=\"http://example.org\">")), ["http://"]);
    assert_eq!(faults("<img src=\"https://example.org/a.png\">"), ["https://"]);
}

/// Tests a report of small reaches: the page is XML; every figure is an image with words; all linked files exist;
/// all CSV files parse, with equal columns in every row, and are the same bytes when everything is made again by three
/// threads, except the two files of wall times; the cells of the table lie within their intervals; and the summary has
/// the keys that other programs rely on.
#[test]
fn a_report_is_whole() {
    let (scenes, folder, again) =
        (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let experiment = experiment(scenes.path());
    let other_threads = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    let results = std::thread::scope(|scope| {
        scope.spawn(|| other_threads.install(|| drop(report(&experiment, again.path()))));
        report(&experiment, folder.path())
    });

    let html = std::fs::read_to_string(folder.path().join("index.html")).unwrap();
    let elements = elements(html.strip_prefix("<!DOCTYPE html>\n").unwrap());
    let of = |element: &str, attribute: &str| -> Vec<String> {
        let own = elements.iter().filter(|own| own.0 == element);
        let values = own.flat_map(|own| own.1.iter().filter(|(name, _)| name == attribute));
        values.map(|(_, value)| value.clone()).collect()
    };
    let charts = elements.iter().filter(|own| own.0 == "svg").count();
    assert!(charts >= 16, "{charts}");
    let pictures = of("img", "src");
    assert!(pictures.len() >= 3 && of("img", "alt").iter().all(|text| !text.is_empty()), "{pictures:?}");
    assert!(pictures.iter().all(|file| folder.path().join(file).exists()), "{pictures:?}");
    assert_eq!(of("svg", "role"), vec!["img"; charts]);
    let ids: Vec<String> = elements
        .iter()
        .flat_map(|own| own.1.iter().filter(|(name, _)| name == "id"))
        .map(|(_, value)| value.clone())
        .collect();
    assert_eq!(ids.iter().collect::<BTreeSet<_>>().len(), ids.len(), "two elements with one id: {ids:?}");
    for label in of("svg", "aria-labelledby").iter().flat_map(|labels| labels.split(' ')) {
        assert!(ids.iter().any(|id| id == label), "{label}");
    }
    let mut replayed = BTreeSet::new();
    for link in of("a", "href") {
        match link.split_once('#') {
            Some(("", section)) => assert!(ids.iter().any(|id| id == section), "{link}"),
            // The program writes the replay pages beside the report.
            Some((file, place)) => {
                assert!(place.starts_with("reach="), "{link}");
                replayed.insert(file.to_owned());
            }
            None => assert!(folder.path().join(&link).exists(), "{link}"),
        }
    }
    // Figures that show reaches link to them: moments, verdicts over time and outliers, engineered reaches, example
    // trials.
    let pages = ["replay-engineered.html", "replay-training.html", "replay.html"];
    assert_eq!(replayed, BTreeSet::from(pages.map(String::from)));
    assert_eq!(faults(&html), Vec::<&str>::new());
    // What was run: both campaigns.
    assert!(html.contains("<li>seeds 3 to 4</li>"));

    let mut with_wall_times = BTreeSet::new();
    for file in std::fs::read_dir(folder.path().join("csv")).unwrap() {
        let path = file.unwrap().path();
        let mut reader = csv::Reader::from_path(&path).unwrap();
        // The reader refuses rows whose length differs from the header's.
        reader.records().for_each(|row| drop(row.unwrap()));
        let headings = reader.headers().unwrap();
        assert_eq!(headings.iter().collect::<BTreeSet<_>>().len(), headings.len(), "{path:?}: {headings:?}");
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if std::fs::read(&path).unwrap() != std::fs::read(again.path().join("csv").join(&name)).unwrap() {
            with_wall_times.insert(name);
        }
    }
    assert_eq!(with_wall_times, BTreeSet::from(["figure_8_times.csv".to_owned(), "stage_times.csv".to_owned()]));

    let summary = serde_json::to_value(&results).unwrap();
    for key in [
        "seed",
        "table_1_peak_force",
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
        "verdicts",
        "timing",
    ] {
        assert!(!summary[key].is_null(), "{key}");
    }
    for key in ["touched_balanced_accuracy", "spurious_called_nothing", "expected_calibration_error"] {
        let share = summary["verdicts"][key].as_f64();
        assert!(share.is_some_and(|share| (0.0..=1.0).contains(&share)), "{key}: {share:?}");
    }
    // Verdicts on objects come first.
    let captions = ["Verdicts on objects of known categories", "Contacts of taxels and taxel frames"];
    let places = captions.map(|caption| html.find(caption).unwrap());
    assert!(places[0] < places[1], "{places:?}");
    let objects = summary["verdicts"]["held_out_objects"].as_array().unwrap();
    assert_eq!(
        objects.iter().map(|own| own["at"].as_str().unwrap()).collect::<Vec<_>>(),
        ["0.1 s", "0.3 s", "peak", "end"]
    );
    for own in objects {
        let all: f64 = ["right", "wrong", "uncertain"].iter().map(|key| own[*key].as_f64().unwrap()).sum();
        assert!((all - 1.0).abs() < 1e-12, "{own}");
    }
    assert!(html.contains("On the same folds the largest force alone (peak-force) is right for"));
    let table = summary["table_1"].as_array().unwrap();
    assert_eq!(table.len(), 8);
    for cell in table {
        let number = |key: &str| cell[key].as_f64().unwrap();
        assert!(number("low") <= number("accuracy") && number("accuracy") <= number("high"), "{cell}");
        for key in ["by", "features", "recipe"] {
            assert!(cell[key].is_string(), "{cell}");
        }
        assert!(number("states") >= 5.0);
        // An accuracy is never shown alone. With two categories the majority baseline is at least one half.
        assert!(number("majority_baseline") >= 50.0 && (0.0..=100.0).contains(&number("balanced_accuracy")));
    }
}
