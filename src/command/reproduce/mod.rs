//! `underbrush reproduce`: the paper's data, models, tables and figures, and a report that shows them beside the
//! published ones.
//!
//! `data` says which reaches; `campaign`, `reaches`, `online`, `thresholds`, `truncation`, `classifiers`,
//! `splits` and `ablation` measure, `comparison` sets
//! beside the paper; `results` holds all numbers; `tables`, `figures` and `page` only show them.

mod ablation;
mod campaign;
mod classifiers;
mod comparison;
mod data;
mod figures;
mod online;
mod page;
mod plan;
mod reaches;
mod results;
mod skin_map;
mod snapshot;
mod splits;
mod tables;
mod thresholds;
mod truncation;
mod words;

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use underbrush_classifier::ModelSet;
use underbrush_classifier::decision::Decision;
use underbrush_classifier::evaluate::{ConfusionMatrix, TableOneUnit};
use underbrush_classifier::feature::FeatureSet;
use underbrush_classifier::recipe::Recipe;
use underbrush_recording::disk::{Dataset, write_trials};

use self::campaign::{OneOfMany, RecipeCell, Trials};
use self::online::{Classified, Online, Shares};
use self::reaches::TestReaches;
use self::results::{Campaigns, Outliers, Results, Roc, SamplesUsed, Timing};
use self::thresholds::Thresholds;
use crate::dataset::{PROGRAM_VERSION, Written};
use crate::failure::Failure;
use crate::{audit, output, progress};

/// Options of `underbrush reproduce`.
#[derive(Args)]
pub struct Options {
    /// Folder for data set, trials, models, tables and report
    ///
    /// An interrupted run there is continued, and what is finished is not made again, where seed, size and the program's
    /// sources are the same. Results of another run are never mixed in: they are refused, or replaced with --fresh.
    #[arg(long, value_name = "DIR", default_value = "out/reproduce")]
    out: PathBuf,
    /// A third of the paper's reaches: 4 leaf and 8 trunk instead of 10 and 25
    #[arg(long)]
    quick: bool,
    /// Seed
    #[arg(long, default_value_t = 0, value_name = "N")]
    seed: u64,
    /// Make Table I and compare classifiers in N independent campaigns, of this seed and the next ones; mean and spread
    ///
    /// Each campaign's result is kept: more can be added later, and an interrupted run goes on after the last.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    campaigns: u64,
    /// Throw away what another run has left in the folder, and begin anew
    #[arg(long)]
    fresh: bool,
}

/// The paper's mean of Fig. 9, samples (section V-B).
const PAPER_SAMPLES_USED: f64 = 11.9;
/// The paper's computation time per 100 taxels in contact, s (section V-B, Fig. 8).
const PAPER_SECONDS_PER_100_TAXELS: f64 = 0.83;

/// Says what goes on and notes how long each stage takes.
struct Stages {
    start: Instant,
    done: Vec<(&'static str, f64)>,
}

impl Stages {
    fn begin() -> Self {
        Stages {
            start: Instant::now(),
            done: Vec::new(),
        }
    }

    fn run<T>(&mut self, what: &'static str, work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
        output::remark(what);
        let start = Instant::now();
        let result = work()?;
        self.done.push((what, start.elapsed().as_secs_f64()));
        Ok(result)
    }
}

/// Training trials and test reaches: all that the paper's experiments need.
struct Data {
    seed: u64,
    quick: bool,
    reaches: results::Reaches,
    trials: Trials,
    tested: TestReaches,
}

/// What comes of the data. What needs reaches of its own is still empty in `results`: campaigns, splits and ablation.
struct Analysis {
    results: Results,
    models: ModelSet,
    online: Online,
    thresholds: Thresholds,
}

/// Runs everything and prints the tables.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    let Options { out, quick, seed, .. } = &options;
    let (quick, seed) = (*quick, *seed);
    let mut stages = Stages::begin();
    plan::Plan::new(seed, quick).settle(out, options.fresh)?;

    let dataset = stages.run("Training reaches", || make_or_reuse(out, seed, quick))?;
    audit::warn(dataset.episodes());
    let trials = stages.run("Trials", || Trials::of_dataset(&dataset, &data::trial_options()))?;
    write_trials(out.join("trials-component.parquet"), trials.component.iter().cloned())?;
    write_trials(out.join("trials-taxel.parquet"), trials.taxel.iter().cloned())?;
    let data = Data {
        seed,
        quick,
        reaches: results::Reaches::of(dataset.episodes()),
        trials,
        tested: stages.run("Engineered, general and outlier reaches", || {
            reaches::draw(&out.join("reaches"), seed, quick)
        })?,
    };
    let Analysis {
        mut results,
        models,
        online,
        thresholds,
    } = Analysis::of(&data, &mut stages)?;
    output::write_file(&out.join("model.json"), models.save_string()?.as_bytes())?;

    let moments = stages.run("A moment of a general and of an outlier reach", || {
        let take = |scene, reach, rule| snapshot::take(&models, reach, &reaches::plan(scene, seed)?, rule);
        Ok([
            take(data::MIXED, online.shown(), online::uncertain_rule())?,
            take(data::OUTLIER, online.outlier.first(), Decision::paper().rule)?,
        ])
    })?;
    results.splits = stages.run("Other arms and speeds", || {
        campaign::kept(out, "splits", (seed, quick), || {
            splits::run(seed, quick, &data.trials.taxel)
        })
    })?;
    if !quick {
        results.ablation = stages.run("What each part of reality is worth", || {
            campaign::kept(out, "ablation", (seed, quick), || {
                ablation::run(seed, &dataset, &results.measurement)
            })
        })?;
    }
    if options.campaigns > 1 {
        results.campaigns = stages.run("Further campaigns", || {
            let first = OneOfMany::new(results.measurement.clone(), &results.classifiers);
            campaigns(out, (seed, quick), options.campaigns, first)
        })?;
    }
    results.timing = Timing::of(&stages, &online);

    let bytes = serde_json::to_vec_pretty(&results).map_err(|error| Failure::run(error.to_string()))?;
    output::write_file(&out.join("summary.json"), &bytes)?;
    page::write(&out.join("report"), &results, &online, &thresholds, &moments)?;
    output::result(json, &results, || words::text(&results, out))
}

/// Makes the training data, goes on with an interrupted set, or takes the finished one.
fn make_or_reuse(out: &Path, seed: u64, quick: bool) -> Result<Dataset, Failure> {
    let (campaign, folder) = (campaign::campaign(seed, quick)?, out.join("dataset"));
    match Dataset::open(&folder) {
        Ok(dataset) if campaign.has_made(&dataset)? => {
            output::remark(format!("  taken from {}", folder.display()));
            Ok(dataset)
        }
        _ => match campaign.write(&folder, true)? {
            Written::New(dataset) | Written::Before(dataset) => Ok(dataset),
        },
    }
}

/// The first campaign and `count` − 1 more.
fn campaigns(
    out: &Path,
    (seed, quick): (u64, bool),
    count: u64,
    first: OneOfMany,
) -> Result<Option<Campaigns>, Failure> {
    let bar = progress::bar(count - 1, "further campaigns");
    let seeds: Vec<u64> = (0..count).map(|number| seed.wrapping_add(number)).collect();
    let mut measured = vec![first];
    for seed in &seeds[1..] {
        measured.push(campaign::measured(out, *seed, quick)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(Campaigns::of(seeds, &measured))
}

impl Analysis {
    fn of(data: &Data, stages: &mut Stages) -> Result<Self, Failure> {
        let Data { trials, tested, .. } = data;
        let (measurement, cells) = stages.run("Table I, two recipes", || trials.measure(data.quick))?;
        let truncated = stages.run("Truncated trials", || truncation::run(&trials.taxel))?;
        let compared = stages.run("Other classifiers", || classifiers::run(&trials.taxel))?;
        let models = stages.run("Models", || Ok(ModelSet::train(&trials.taxel, &Recipe::authors())?.0))?;
        let thresholds = stages.run("Thresholds", || {
            thresholds::choose(&trials.taxel, &models, &tested.outlier)
        })?;
        let chosen = thresholds.chosen.as_ref().ok();
        let rule = chosen.map(|chosen| &chosen.decision);
        let online = stages.run("Online verdicts", || Online::run(&models, tested, rule))?;

        let cells_here = measurement.table_1.iter();
        let results = Results {
            program: PROGRAM_VERSION,
            seed: data.seed,
            quick: data.quick,
            reaches: data.reaches.clone(),
            mean_absolute_difference_points: comparison::mean_difference(
                cells_here.map(|cell| (cell.recipe.as_str(), cell.accuracy, cell.paper)),
            ),
            orderings: comparison::orderings_of(&measurement.table_1),
            measurement,
            campaigns: None,
            figure_5: results::examples(&trials.taxel, &trials.touched),
            figure_6: confusion(&cells, FeatureSet::Force)?,
            figure_7: confusion(&cells, FeatureSet::ForceAndMotion)?,
            figure_9: samples_used(&online),
            figure_10: online.shown().and_then(|reach| Shares::of(&reach.stream.total())),
            figure_11: online.engineered.clone(),
            figure_13: truncated,
            classifiers: compared,
            splits: Vec::new(),
            ablation: Vec::new(),
            figure_15: Outliers {
                drawn: online.outlier_drawn,
                reaches: online.outlier.len(),
                detection: online.detection.clone(),
            },
            thresholds: chosen.cloned(),
            roc: Roc {
                leaf_against_trunk_area: thresholds.category_roc.as_ref().map(|curve| curve.area),
                outlier_area: thresholds.outlier_roc.as_ref().map(|curve| curve.area),
            },
            timing: Timing::of(stages, &online),
        };
        Ok(Analysis {
            results,
            models,
            online,
            thresholds,
        })
    }
}

/// The confusion matrix of the taxels with 20 states in the authors' recipe (Figs. 6 and 7).
fn confusion(cells: &[RecipeCell], features: FeatureSet) -> Result<ConfusionMatrix, Failure> {
    let own = |(recipe, cell): &&RecipeCell| {
        *recipe == campaign::AUTHORS && (cell.unit, cell.features, cell.states) == (TableOneUnit::Taxel, features, 20)
    };
    let (_, cell) = cells
        .iter()
        .find(own)
        .ok_or_else(|| Failure::run("Table I lacks the cells of Figs. 6 and 7"))?;
    Ok(cell.evaluation.confusion.clone())
}

fn samples_used(online: &Online) -> SamplesUsed {
    let engineered = online.engineered.iter().filter_map(|reach| reach.mean_samples_used);
    let mixed = online.mixed.iter().filter_map(|reach| reach.stream.mean_samples_used());
    let all: Vec<f64> = engineered.chain(mixed).collect();
    SamplesUsed {
        mean_samples_used: online.shown().and_then(|reach| reach.stream.mean_samples_used()),
        mean_over_reaches: (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64),
        reaches: all.len(),
        paper: PAPER_SAMPLES_USED,
    }
}

/// The median over the frames with contact of the time per 100 taxels, s.
fn median_seconds(reach: &Classified) -> Option<f64> {
    let frames = reach.stream.frames.iter().zip(&reach.stream.seconds);
    let with_contact = frames.filter(|(frame, _)| frame.in_contact > 0);
    let mut seconds: Vec<f64> = with_contact
        .map(|(frame, seconds)| 100.0 * seconds / frame.in_contact as f64)
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds.get(seconds.len() / 2).copied()
}

impl Timing {
    fn of(stages: &Stages, online: &Online) -> Self {
        let processor = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
            let line = text.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        });
        Timing {
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            threads: rayon::current_num_threads(),
            processor: processor.unwrap_or_else(|| std::env::consts::ARCH.into()),
            wall_s: stages.start.elapsed().as_secs_f64(),
            stages: stages.done.clone(),
            figure_8_seconds_per_100_taxels: online.shown().and_then(|reach| reach.stream.seconds_per_100_taxels()),
            figure_8_median_seconds_per_100_taxels: online.shown().and_then(median_seconds),
            figure_8_paper_seconds_per_100_taxels: PAPER_SECONDS_PER_100_TAXELS,
        }
    }
}

#[cfg(test)]
mod tests;
