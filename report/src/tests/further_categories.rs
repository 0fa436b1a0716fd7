//! Tests that a category that is not the paper's appears in everything that shows categories.

use std::collections::{BTreeMap, BTreeSet};

use underbrush_classifier::decision::Verdict;
use underbrush_classifier::evaluate::{Stream, StreamFrame};
use underbrush_experiments::experiment::example_trials::{self, Example};
use underbrush_experiments::frame_verdicts::{Classified, Online};
use underbrush_recording::{Category, FRAME_PERIOD_S, Grid, Sample, Trial};

use super::elements;
use crate::CategoryLooks;
use crate::section::moments::skin_map;
use crate::section::{example_trials as trial_section, outliers};

const REED: Category = Category::new("reed", 4).unwrap();
const LABELS: [&str; 3] = ["leaf", "trunk", "reed"];

fn looks() -> CategoryLooks {
    CategoryLooks::of(LABELS)
}

/// An outlier reach of two frames: first a trunk and a foam block press, then a reed. In both frames, two taxels are
/// called reeds.
fn reach(truths: Vec<Category>) -> Classified {
    let verdicts = ["leaf", "reed", "trunk", "uncertain", "outlier"].map(str::to_owned).to_vec();
    let frame = |index: usize, pressing: &[Category]| StreamFrame {
        time_s: index as f64 * FRAME_PERIOD_S,
        in_contact: 2,
        by_verdict: vec![0, 2, 0, 0, 0],
        touched: truths.iter().map(|truth| pressing.contains(truth)).collect(),
        ..StreamFrame::default()
    };
    let frames = vec![frame(0, &[Category::TRUNK, Category::BLOCK]), frame(1, &[REED])];
    Classified {
        reach_index: 3,
        stream: Stream {
            taxel_frames: vec![vec![0; verdicts.len()]; truths.len() + 1],
            truths,
            verdicts,
            frames,
            ..Stream::default()
        },
    }
}

fn with_reed() -> Vec<Category> {
    Category::BUILT_IN.into_iter().chain([REED]).collect()
}

fn texts(svg: &str) -> Vec<String> {
    let texts = elements(svg).into_iter().filter(|own| own.0 == "text");
    texts.map(|own| own.2).collect()
}

/// Whether anything in a drawing has this colour as an attribute.
fn has(svg: &str, colour: &str) -> bool {
    let values = elements(svg).into_iter().flat_map(|own| own.1);
    values.into_iter().any(|(_, value)| value == colour)
}

/// Tests that the chart of an outlier reach has a strip for a further category that presses, in its own colour, and one
/// for each label and for outliers, but none for foam blocks; and that without the further category the strips are the
/// paper's.
#[test]
fn the_outlier_chart_has_a_strip_for_it() {
    let strips = |truths, labels: &[&str]| -> Vec<String> {
        let svg = outliers::reach_chart(&reach(truths), labels, &looks());
        let known = ["outlier", "reed", "trunk", "leaf", "block"];
        let texts = texts(&svg).into_iter().filter(|text| known.contains(&text.as_str()));
        // In the document, the strips come after the legend.
        texts.skip(labels.len() + usize::from(!labels.contains(&"reed")) + 1).collect()
    };
    assert_eq!(strips(with_reed(), &LABELS), ["outlier", "reed", "trunk", "leaf"]);
    assert_eq!(strips(with_reed(), &["leaf", "trunk"]), ["outlier", "reed", "trunk", "leaf"]);
    let paper = strips(Category::BUILT_IN.to_vec(), &["leaf", "trunk"]);
    assert_eq!(paper, ["outlier", "trunk", "leaf"]);
    let svg = outliers::reach_chart(&reach(with_reed()), &LABELS, &looks());
    assert!(has(&svg, looks().look("reed").colour), "{svg}");
}

/// Tests that the table of frames has a column for touches of a further category, even if only a later reach has it,
/// and a column of its own for verdicts on it.
#[test]
fn the_table_of_frames_has_a_column_for_it() {
    let online = Online {
        engineered: Vec::new(),
        general: Vec::new(),
        general_drawn: 0,
        outlier: vec![reach(Category::BUILT_IN.to_vec()), reach(with_reed())],
        outlier_by_chosen: None,
        outlier_drawn: 2,
    };
    let table = outliers::frames_table(&online);
    let column = |name: &str| {
        let place = table.columns.iter().position(|column| column == name).unwrap();
        table.texts().into_iter().map(move |row| row[place].clone()).collect::<Vec<_>>()
    };
    assert_eq!(column("touches_reed"), ["0", "0", "0", "1"]);
    assert_eq!(column("touches_trunk"), ["1", "0", "1", "0"]);
    assert_eq!(column("reed"), ["2"; 4]);
    assert_eq!(column("trunk"), ["0"; 4]);
}

/// Tests that the skin map marks a further category in its own colour and names it in the legend, and that the legend
/// takes more rows if one is too short.
#[test]
fn the_skin_map_names_it() {
    let grid = |columns| Grid { rows: 2, columns, wraps: true };
    let verdicts = BTreeMap::from([(1, Verdict::Category("reed".into()))]);
    let draw = |columns, labels: &[&str]| {
        skin_map("any", ("sleeve", grid(columns)), (labels, &looks()), &verdicts, &BTreeSet::from([1]))
    };
    let svg = draw(30, &LABELS);
    let legend = ["leaf", "trunk", "reed", "outlier", "uncertain", "untouched"];
    let words = texts(&svg);
    assert_eq!(words[1..7], legend, "{words:?}");
    // One mark in the legend, one on the taxel.
    let reed = looks().look("reed").colour;
    let marks = |svg: &str| svg.matches(&format!("fill=\"{reed}\"")).count();
    assert_eq!(marks(&svg), 2);
    let rows = |svg: &str| ["y=\"40\"", "y=\"62\"", "y=\"84\""].map(|row| svg.matches(row).count());
    assert_eq!(rows(&svg), [6, 0, 0]);
    assert_eq!(rows(&draw(12, &LABELS)), [3, 2, 1]);
    assert_eq!(rows(&draw(24, &["leaf", "trunk"])), [5, 0, 0]);
}

/// Tests that the curves of example trials are in the categories' own styles.
#[test]
fn the_trial_figure_draws_it_in_its_own_style() {
    let sample = |time_s| Sample { time_s, force_n: 1.0, ..Sample::default() };
    let example = |label: &str| Example {
        category: label.into(),
        trial: 0,
        taxel: None,
        samples: 2,
        peak_force_n: 1.0,
        motion_m: 0.0,
        data: Trial {
            trial: 0,
            category: Some(label.into()),
            reach: None,
            patch: None,
            taxel: None,
            samples: [0.0, 1.0].map(sample).to_vec(),
        },
    };
    let outcome = example_trials::ExampleTrials { figure_5: LABELS.map(example).into(), figure_5_medians: Vec::new() };
    let force = &trial_section::charts(&outcome, &looks())[0];
    for label in LABELS {
        assert!(texts(force).iter().any(|text| text == label), "{label}");
        assert!(has(force, looks().look(label).colour), "{label}");
    }
}
