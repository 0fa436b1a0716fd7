//! `underbrush reproduce`: the paper's data, models and tables, beside the published ones.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use serde::Serialize;
use underbrush_classifier::ModelSet;
use underbrush_classifier::evaluate::{Folds, Interval, TableOneCell, TableOneUnit, table_one};
use underbrush_classifier::feature::FeatureSet;
use underbrush_classifier::recipe::Recipe;
use underbrush_classifier::trial::TrialOptions;
use underbrush_recording::Trial;
use underbrush_recording::disk::{Dataset, write_trials};
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;
use underbrush_sim::snapshot::Snapshot;

use super::generate::Summary;
use crate::dataset::Campaign;
use crate::failure::Failure;
use crate::input::{self, Unit};
use crate::{output, picture, progress};

/// Options of `underbrush reproduce`.
#[derive(Args)]
pub struct Options {
    /// Folder for data set, trials, models, tables and pictures; an interrupted run there is continued
    #[arg(long, value_name = "DIR", default_value = "out/reproduce")]
    out: PathBuf,
    /// A third of the paper's reaches: 4 leaf and 8 trunk instead of 10 and 25
    #[arg(long)]
    quick: bool,
    /// Seed
    #[arg(long, default_value_t = 0, value_name = "N")]
    seed: u64,
}

/// The two training environments (paper, section IV-B), as shipped in `scenes/`.
const SCENES: [(&str, &str); 2] = [
    ("scenes/leaf.toml", include_str!("../../scenes/leaf.toml")),
    ("scenes/trunk.toml", include_str!("../../scenes/trunk.toml")),
];
/// Reaches of each: the paper's, and `--quick`'s.
const REACHES: [u64; 2] = [10, 25];
const QUICK_REACHES: [u64; 2] = [4, 8];
/// Trials per reach in the paper, leaf and trunk: sections IV-C (288 / 10 and 324 / 25) and IV-D (496 / 10, 582 / 25).
const PAPER_TRIALS_PER_REACH: [(TableOneUnit, [f64; 2]); 2] = [
    (TableOneUnit::Component, [28.8, 12.96]),
    (TableOneUnit::Taxel, [49.6, 23.28]),
];

#[derive(Serialize)]
struct Results {
    seed: u64,
    quick: bool,
    campaign: Summary,
    trials_per_reach: Vec<TrialsPerReach>,
    table_1: Vec<Cell>,
    mean_absolute_difference_points: f64,
}

#[derive(Serialize)]
struct TrialsPerReach {
    by: TableOneUnit,
    category: &'static str,
    trials: usize,
    per_reach: f64,
    paper: f64,
}

#[derive(Serialize)]
struct Cell {
    by: TableOneUnit,
    features: FeatureSet,
    states: usize,
    recipe: &'static str,
    accuracy: f64,
    low: f64,
    high: f64,
    paper: f64,
}

/// Runs everything and prints the tables.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    let start = Instant::now();
    let reaches = if options.quick { QUICK_REACHES } else { REACHES };
    let scenes: Vec<(Scene, u64)> = SCENES
        .iter()
        .zip(reaches)
        .map(|((path, text), reaches)| Ok((Scene::parse(path, (*text).into())?, reaches)))
        .collect::<Result<_, Failure>>()?;
    for (scene, _) in &scenes {
        draw_reach(scene, options.seed, &options.out)?;
    }
    output::remark(format!(
        "Simulating {} leaf and {} trunk reaches",
        reaches[0], reaches[1]
    ));
    let campaign = Campaign {
        scenes,
        seed: options.seed,
        controller: None,
        shard: None,
    };
    let dataset = make_or_reuse(&campaign, &options.out.join("dataset"))?;
    let summary = Summary::of(&dataset, start.elapsed().as_secs_f64());
    let (component, taxel) = cut_trials(&dataset)?;
    write_trials(options.out.join("trials-component.parquet"), component.iter().cloned())?;
    write_trials(options.out.join("trials-taxel.parquet"), taxel.iter().cloned())?;

    output::remark("Training and cross-validating the twelve cells of Table I");
    let recipe = Recipe::authors();
    let cells = table_one(&component, &taxel, &recipe, Folds::paper())?;
    let (models, _) = ModelSet::train(&taxel, &recipe)?;
    output::write_file(&options.out.join("model.json"), models.save_string()?.as_bytes())?;

    let results = Results {
        seed: options.seed,
        quick: options.quick,
        campaign: summary,
        trials_per_reach: trials_per_reach(&component, &taxel, reaches),
        mean_absolute_difference_points: mean_difference(&cells),
        table_1: cells.iter().map(Cell::of).collect(),
    };
    let bytes = serde_json::to_vec_pretty(&results).map_err(|error| Failure::run(error.to_string()))?;
    output::write_file(&options.out.join("summary.json"), &bytes)?;
    output::write_file(&options.out.join("table_1.csv"), table_csv(&results.table_1).as_bytes())?;
    output::result(json, &results, || {
        text(&results, start.elapsed().as_secs_f64(), &options.out)
    })
}

/// A picture of the first reach of a scene, at the moment when the skin feels most.
fn draw_reach(scene: &Scene, seed: u64, out: &Path) -> Result<(), Failure> {
    let plan = ReachPlan::new(scene.clone(), None, seed)?;
    let mut best: Option<Snapshot> = None;
    let recording = plan.run(0, &mut |world, clutter, frame| {
        if best
            .as_ref()
            .is_none_or(|best| frame.taxels.len() > best.frame.taxels.len())
        {
            best = Some(Snapshot::take(world, clutter, frame));
        }
    })?;
    let Some(snapshot) = best else { return Ok(()) };
    let caption = format!("{}: {:.1} s after the start", scene.file.summary, snapshot.frame.time_s);
    let svg = picture::draw(
        &snapshot,
        &recording.layout,
        &input::object_categories(&recording),
        &caption,
    );
    output::write_file(&out.join(format!("reach-{}.svg", scene.name)), svg.as_bytes())
}

/// Makes the data set, goes on with an interrupted one, or takes the finished one that the same plan has left.
fn make_or_reuse(campaign: &Campaign, folder: &Path) -> Result<Dataset, Failure> {
    match Dataset::open(folder) {
        Ok(dataset) if campaign.has_made(&dataset)? => Ok(dataset),
        _ => campaign.write(folder, true),
    }
}

/// Component and taxel trials of all reaches, leaf reaches first.
fn cut_trials(dataset: &Dataset) -> Result<(Vec<Trial>, Vec<Trial>), Failure> {
    let bar = progress::bar(dataset.episodes().len() as u64, "reaches read");
    let options = TrialOptions::default();
    let (mut component, mut taxel) = (Vec::new(), Vec::new());
    for episode in 0..dataset.episodes().len() {
        let recording = dataset.read_reach(episode)?;
        for (by, trials) in [(Unit::Component, &mut component), (Unit::Taxel, &mut taxel)] {
            let mut found = input::cut(&recording, by, &options, trials.len() as u64)?;
            found.iter_mut().for_each(|trial| trial.reach = Some(episode as u64));
            trials.extend(found);
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok((component, taxel))
}

fn trials_per_reach(component: &[Trial], taxel: &[Trial], reaches: [u64; 2]) -> Vec<TrialsPerReach> {
    let mut rows = Vec::new();
    for (by, paper) in PAPER_TRIALS_PER_REACH {
        let trials = if by == TableOneUnit::Component {
            component
        } else {
            taxel
        };
        for (index, category) in ["leaf", "trunk"].into_iter().enumerate() {
            let count = trials
                .iter()
                .filter(|trial| trial.category.as_deref() == Some(category))
                .count();
            rows.push(TrialsPerReach {
                by,
                category,
                trials: count,
                per_reach: count as f64 / reaches[index] as f64,
                paper: paper[index],
            });
        }
    }
    rows
}

fn mean_difference(cells: &[TableOneCell]) -> f64 {
    let difference =
        |cell: &TableOneCell| -> f64 { (100.0 * cell.evaluation.accuracy - cell.paper_accuracy_percent).abs() };
    cells.iter().map(difference).sum::<f64>() / cells.len() as f64
}

impl Cell {
    fn of(cell: &TableOneCell) -> Self {
        let evaluation = &cell.evaluation;
        let Interval { low, high } = evaluation
            .accuracy_interval_by_reach
            .unwrap_or(evaluation.accuracy_interval_by_trial);
        Cell {
            by: cell.unit,
            features: cell.features,
            states: cell.states,
            recipe: "authors",
            accuracy: 100.0 * evaluation.accuracy,
            low: 100.0 * low,
            high: 100.0 * high,
            paper: cell.paper_accuracy_percent,
        }
    }

    fn unit(&self) -> &'static str {
        match self.by {
            TableOneUnit::Component => "component",
            TableOneUnit::Taxel => "taxel",
        }
    }

    fn feature(&self) -> &'static str {
        match self.features {
            FeatureSet::Force => "force",
            FeatureSet::ForceAndMotion => "force+motion",
        }
    }
}

fn table_csv(cells: &[Cell]) -> String {
    let mut csv = String::from("by,features,states,recipe,accuracy_percent,low_percent,high_percent,paper_percent\n");
    for cell in cells {
        let _ = writeln!(
            csv,
            "{},{},{},{},{:.2},{:.2},{:.2},{:.2}",
            cell.unit(),
            cell.feature(),
            cell.states,
            cell.recipe,
            cell.accuracy,
            cell.low,
            cell.high,
            cell.paper
        );
    }
    csv
}

fn text(results: &Results, wall_s: f64, out: &Path) -> String {
    let trials: Vec<Vec<String>> = results
        .trials_per_reach
        .iter()
        .map(|row| {
            let unit = if row.by == TableOneUnit::Component {
                "component"
            } else {
                "taxel"
            };
            vec![
                format!("{unit}, {}", row.category),
                row.trials.to_string(),
                format!("{:.1}", row.per_reach),
                format!("{:.1}", row.paper),
            ]
        })
        .collect();
    let cells: Vec<Vec<String>> = results
        .table_1
        .iter()
        .map(|cell| {
            vec![
                format!("{}, {}", cell.unit(), cell.feature()),
                cell.states.to_string(),
                format!("{:.1}", cell.accuracy),
                format!("{:.0}-{:.0}", cell.low, cell.high),
                format!("{:.1}", cell.paper),
                format!("{:+.1}", cell.accuracy - cell.paper),
            ]
        })
        .collect();
    let mut text = results.campaign.text() + "\n\n";
    text += &output::table(&["trials", "count", "per reach", "paper"], &trials);
    text += "\nTable I: two-fold cross-validation accuracy in per cent, the authors' recipe\n";
    text += &output::table(
        &[
            "trials, features",
            "states",
            "here",
            "95 % by reach",
            "paper",
            "difference",
        ],
        &cells,
    );
    let _ = write!(
        text,
        "\nmean absolute difference {:.1} points; {:.0} s in all\npictures, trials, model.json, table_1.csv and \
         summary.json in {}",
        results.mean_absolute_difference_points,
        wall_s,
        out.display()
    );
    text
}
