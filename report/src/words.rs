//! What the numbers say, in words; nothing here knows what they will be.

use std::path::Path;

use crate::{tables, text};
use underbrush_experiments::campaign::{AUTHORS, MODERN};
use underbrush_experiments::data;
use underbrush_experiments::results::Results;

mod beyond;
mod online;
mod trials;

pub use beyond::{ALL_CONTACTS, LASTING_CONTACTS, ablation, classifiers, speeds, splits};
pub use online::{chosen_rule_online, roc, thresholds};
pub use trials::{baselines, campaigns, figure_5, orderings, table_1, trials, truncation, untouched};

/// For a terminal.
pub fn text(results: &Results, out: &Path) -> String {
    let reaches = &results.reaches;
    let mut words = format!(
        "{} training reaches, {:.0} s of simulated time\n{}\n{}\n\n",
        reaches.count,
        reaches.simulated_s,
        reaches.ends.text(),
        text::audit(&reaches.audit).trim_end()
    );
    let mut add = |table: &crate::drawing::Table, columns: usize| {
        let header: Vec<&str> = table.columns.iter().take(columns).map(String::as_str).collect();
        let rows: Vec<Vec<String>> = table
            .texts()
            .into_iter()
            .map(|mut row| {
                row.truncate(columns);
                row
            })
            .collect();
        words += &format!("{}\n{}\n", table.caption, text::table(&header, &rows));
    };
    add(&tables::trials_per_reach(results), 5);
    add(&tables::table_1(results, AUTHORS), 9);
    add(&tables::table_1(results, MODERN), 9);
    add(&tables::table_1_by_touch(results), 9);
    add(
        &tables::orderings("orderings", "The paper's orderings", &results.orderings),
        5,
    );
    for recipe in [AUTHORS, MODERN] {
        if let Some(table) = tables::campaigns(results, recipe) {
            add(&table, 12);
        }
    }
    if let Some(campaigns) = &results.campaigns {
        add(
            &tables::orderings("", "The paper's orderings on the mean campaign", &campaigns.orderings),
            5,
        );
    }
    add(&tables::classifiers(results), 7);
    add(&tables::classifiers_by_touch(results), 9);
    if let Some(table) = tables::campaign_classifiers(results) {
        add(&table, 10);
    }
    for classifier in results.split_classifiers() {
        add(&tables::splits_of(results, classifier), 6);
    }
    if !results.ablation.is_empty() {
        add(&tables::ablation(results), 10);
    }
    add(&tables::figure_11(results), 10);
    add(&tables::detection(results), 7);
    for (recipe, points) in &results.mean_absolute_difference_points {
        words += &format!("mean absolute difference from the paper, {recipe} recipe: {points:.1} points\n");
    }
    for (recipe, points) in results
        .campaigns
        .iter()
        .flat_map(|campaigns| &campaigns.mean_absolute_difference_points)
    {
        words += &format!("the same of the mean campaign, {recipe} recipe: {points:.1} points\n");
    }
    words += &format!("{}\n", choices(&all_seeds(results)));
    let samples = results
        .figure_9
        .mean_samples_used
        .map_or("none".into(), |mean| format!("{mean:.1}"));
    words
        + &format!(
            "samples used for a verdict (Fig. 9): {samples}, paper {}\n{:.0} s in all; report in {}",
            results.figure_9.paper,
            results.timing.wall_s,
            out.join("report/index.html").display()
        )
}

/// The run's seed, or those of all its campaigns.
pub fn all_seeds(results: &Results) -> Vec<u64> {
    let campaigns = results.campaigns.as_ref();
    campaigns.map_or(vec![results.seed], |campaigns| campaigns.seeds.clone())
}

/// That the agreement is no prediction, and whether something was chosen on these seeds.
pub fn choices(seeds: &[u64]) -> String {
    let chosen: Vec<String> = data::CHOSEN_ON
        .iter()
        .map(|(on, what)| format!("{what} on seeds {} to {}", on.start(), on.end()))
        .collect();
    let seen: Vec<String> = data::CHOSEN_ON
        .iter()
        .filter(|(on, _)| seeds.iter().any(|seed| on.contains(seed)))
        .map(|(_, what)| format!("{what} were chosen on some of these seeds"))
        .collect();
    let here = match seen.is_empty() {
        true => format!("Nothing was chosen on {}.", self::seeds(seeds)),
        false => format!("This run has {}: {}.", self::seeds(seeds), seen.join(", and ")),
    };
    format!(
        "Agreement with the paper's figures is not a prediction. Parameters that the paper leaves open were chosen with its \
         trial counts and Table I in view: {}. {here}",
        chosen.join(", ")
    )
}

/// The seeds of a run.
pub fn seeds(seeds: &[u64]) -> String {
    match seeds {
        [] => "no seed".into(),
        [one] => format!("seed {one}"),
        [first, .., last] => format!("seeds {first} to {last}"),
    }
}

/// The authors' recipe, the modern recipe.
pub fn possessive(recipe: &str) -> String {
    if recipe == AUTHORS {
        format!("{recipe}'")
    } else {
        recipe.to_owned()
    }
}
