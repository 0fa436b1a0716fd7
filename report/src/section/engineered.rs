//! Online verdicts in reaches that touch one category alone (Fig. 11).

use underbrush_experiments::experiment::engineered::Outcome;
use underbrush_experiments::online::Shares;

use crate::drawing::{Axis, Cell, Chart, Dash, Layer, Shape, Style, Table};
use crate::replay_links;
use crate::report::Report;
use crate::style::{CORRECT, UNCERTAIN, WRONG};

/// Adds the section.
pub fn add(report: &mut Report, outcome: &Outcome) {
    let reaches = &outcome.figure_11;
    if reaches.is_empty() {
        return;
    }
    report.section("engineered", &format!("{} engineered reaches", reaches.len()));
    let found: Vec<&Shares> = reaches.iter().filter_map(|reach| reach.shares.as_ref()).collect();
    let drawn: u64 = reaches.iter().map(|reach| reach.drawn).sum();
    let mostly_correct = found.iter().filter(|own| own.correct_percent > own.misclassified_percent);
    report.page.paragraph(&format!(
        "Each scene is drawn until, by ground truth, the patch touches its category and nothing else, and feels it. {} of {} \
         scenes gave such a reach, in {drawn} draws. In {} of them more taxels are correct than misclassified. The truth of \
         every taxel is the category of the scene, even if nothing presses on it, as in the paper; the table gives the share \
         of such taxels as untouched.",
        found.len(),
        reaches.len(),
        mostly_correct.count()
    ));
    report.page.figure("Verdicts on all taxels in contact, over all frames of a reach.", &[chart(outcome)]);
    let found = reaches.iter().filter(|reach| reach.reach_index.is_some());
    let links: Vec<(String, String)> = found
        .enumerate()
        .map(|(place, reach)| (replay_links::reach(replay_links::ENGINEERED_FILE, place), reach.scene.clone()))
        .collect();
    report.page.links("Replay these reaches in 3-D", &links);
    let table = table(outcome);
    report.print(&table, 10);
    report.table(table);
}

fn chart(outcome: &Outcome) -> String {
    let mut description = String::from("Per cent correct, misclassified and uncertain.");
    let mut letters: Vec<String> = Vec::new();
    let mut names = Vec::new();
    let mut heights = [const { Vec::new() }; 3];
    for (place, reach) in outcome.figure_11.iter().enumerate() {
        let letter: String = reach.category.chars().take(1).flat_map(char::to_uppercase).collect();
        let meaning = format!("{letter} {} only", reach.category);
        let name = format!("{}{letter}", place + 1);
        if !letters.contains(&meaning) {
            letters.push(meaning);
        }
        let shares = reach.shares.as_ref().map_or([f64::NAN; 3], |shares| {
            [shares.correct_percent, shares.misclassified_percent, shares.uncertain_percent]
        });
        description += &match reach.shares {
            Some(_) => format!(" {name}: {:.0}, {:.0}, {:.0}.", shares[0], shares[1], shares[2]),
            None => format!(" {name}: no such reach was drawn."),
        };
        heights.iter_mut().zip(shares).for_each(|(own, share)| own.push(share));
        names.push(name);
    }
    let [correct, wrong, uncertain] = heights;
    let chart = Chart {
        name: "figure-11".into(),
        title: "Verdicts in engineered reaches".into(),
        description,
        x: Axis::names(format!("reach; {}", letters.join(", ")), names),
        y: Axis::spanning("taxels in contact / %", 0.0, 100.0),
        layers: vec![
            Layer::new("correct", Style::line(CORRECT, Dash::Solid), Shape::Bars(correct)),
            Layer::new("misclassified", Style::line(WRONG, Dash::Dashed), Shape::Bars(wrong)),
            Layer::new("uncertain", Style::line(UNCERTAIN, Dash::Dotted), Shape::Bars(uncertain)),
        ],
    };
    chart.svg()
}

fn table(outcome: &Outcome) -> Table {
    let columns = [
        "reach",
        "scene",
        "category",
        "draw",
        "correct / %",
        "misclassified / %",
        "uncertain / %",
        "taxel frames",
        "untouched / %",
        "samples used",
    ];
    let caption = "Verdicts on the taxels in contact, over all frames of each engineered reach";
    let mut table = Table::new("figure_11", caption, &columns);
    for (place, reach) in outcome.figure_11.iter().enumerate() {
        let shares = reach.shares.as_ref();
        let share = |of: fn(&Shares) -> f64| Cell::optional(shares.map(of), 1);
        let count = |count: Option<usize>| count.map_or(Cell::Missing, Cell::Count);
        table.rows.push(vec![
            (place + 1).into(),
            reach.scene.as_str().into(),
            reach.category.into(),
            count(reach.reach_index.map(|index| index as usize)),
            share(|shares| shares.correct_percent),
            share(|shares| shares.misclassified_percent),
            share(|shares| shares.uncertain_percent),
            count(shares.map(|shares| shares.taxel_frames)),
            Cell::optional(reach.untouched_percent, 1),
            Cell::optional(reach.mean_samples_used, 1),
        ]);
    }
    table
}
