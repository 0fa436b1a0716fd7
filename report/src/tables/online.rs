//! Tables of verdicts while the arm moves: Figs. 8 to 11 and 15.

use crate::drawing::{Cell, Table};

use underbrush_experiments::online::{Online, Shares};
use underbrush_experiments::results::Results;
use underbrush_recording::Category;

/// Fig. 8, frame by frame: of all tables this one and `stages` alone hold wall times, which no two runs share.
pub fn figure_8_times(online: &Online) -> Table {
    let columns = ["time_s", "taxels_in_contact", "seconds_per_100_taxels"];
    let mut table = Table::new("figure_8_times", "Fig. 8", &columns);
    if let Some(reach) = online.shown() {
        for (frame, seconds) in reach.stream.frames.iter().zip(&reach.stream.seconds) {
            let per_100 = (frame.in_contact > 0).then(|| 100.0 * seconds / frame.in_contact as f64);
            table.rows.push(vec![
                Cell::Number(frame.time_s, 2),
                frame.in_contact.into(),
                Cell::optional(per_100, 9),
            ]);
        }
    }
    table
}

/// Figs. 9 and 10, frame by frame.
pub fn figures_9_and_10(online: &Online) -> Table {
    let columns = [
        "time_s",
        "taxels_in_contact",
        "mean_samples_used",
        "mean_samples_since_contact",
        "correct",
        "misclassified",
        "uncertain",
        "without_truth",
    ];
    let mut table = Table::new("figures_9_10", "Figs. 9 and 10", &columns);
    for frame in online.shown().iter().flat_map(|reach| &reach.stream.frames) {
        table.rows.push(vec![
            Cell::Number(frame.time_s, 2),
            frame.in_contact.into(),
            Cell::Number(frame.mean_samples_used, 2),
            Cell::Number(frame.mean_samples_since_contact, 2),
            frame.tally.correct.into(),
            frame.tally.misclassified.into(),
            frame.tally.uncertain.into(),
            frame.tally.unknown.into(),
        ]);
    }
    table
}

pub fn figure_11(results: &Results) -> Table {
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
    let caption = "Fig. 11: verdicts on the taxels in contact, all frames of each engineered reach";
    let mut table = Table::new("figure_11", caption, &columns);
    for (place, reach) in results.figure_11.iter().enumerate() {
        let share = |of: fn(&Shares) -> f64| Cell::optional(reach.shares.as_ref().map(of), 1);
        table.rows.push(vec![
            (place + 1).into(),
            reach.scene.as_str().into(),
            reach.category.into(),
            reach
                .reach_index
                .map_or(Cell::Missing, |index| Cell::Count(index as usize)),
            share(|shares| shares.correct_percent),
            share(|shares| shares.misclassified_percent),
            share(|shares| shares.uncertain_percent),
            reach
                .shares
                .as_ref()
                .map_or(Cell::Missing, |shares| shares.taxel_frames.into()),
            Cell::optional(reach.untouched_percent, 1),
            Cell::optional(reach.mean_samples_used, 1),
        ]);
    }
    table
}

/// Fig. 15, frame by frame, of all outlier reaches.
pub fn figure_15(online: &Online) -> Table {
    let columns = [
        "reach_index",
        "time_s",
        "leaf",
        "trunk",
        "uncertain",
        "outlier",
        "without_truth",
        "touches_leaf",
        "touches_trunk",
        "touches_block",
        "touches_outlier",
    ];
    let mut table = Table::new("figure_15", "Fig. 15", &columns);
    for reach in &online.outlier {
        for frame in &reach.stream.frames {
            let mut row = vec![Cell::Count(reach.reach_index as usize), Cell::Number(frame.time_s, 2)];
            row.extend(frame.by_verdict.iter().map(|count| Cell::Count(*count)));
            row.push(frame.tally.unknown.into());
            let built_in = frame.touched.iter().take(Category::BUILT_IN.len());
            row.extend(built_in.map(|touched| Cell::Count(usize::from(*touched))));
            table.rows.push(row);
        }
    }
    table
}

pub fn detection(results: &Results) -> Table {
    let columns = [
        "thresholds",
        "truth",
        "taxel frames",
        "leaf / %",
        "trunk / %",
        "uncertain / %",
        "outlier / %",
    ];
    let caption = "Verdicts by what truly presses, all frames of the outlier reaches";
    let mut table = Table::new("outlier_detection", caption, &columns);
    for row in &results.figure_15.detection {
        table.rows.push(vec![
            row.rule.as_str().into(),
            row.truth.into(),
            row.taxel_frames.into(),
            Cell::Number(row.leaf_percent, 1),
            Cell::Number(row.trunk_percent, 1),
            Cell::Number(row.uncertain_percent, 1),
            Cell::Number(row.outlier_percent, 1),
        ]);
    }
    table
}
