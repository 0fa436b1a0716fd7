//! `underbrush reproduce`: the paper's data, models, tables and figures, and a report that shows them beside the
//! published ones.

use std::path::{Path, PathBuf};

use clap::Args;
use underbrush_classifier::Model;
use underbrush_classifier::decision::Decision;
use underbrush_experiments::analysis::{Analysis, Data};
use underbrush_experiments::campaign::{self, Trials};
use underbrush_experiments::dataset::Written;
use underbrush_experiments::measurement::OneOfMany;
use underbrush_experiments::results::{self, Campaigns, Timing};
use underbrush_experiments::timing::Stages;
use underbrush_experiments::{ExperimentError, ablation, audit, data, kept, plan, reaches, snapshot, splits};
use underbrush_experiments::{Progress, online};
use underbrush_recording::disk::{Dataset, write_trials};
use underbrush_report::{page, words};

use crate::failure::Failure;
use crate::progress::Shown;
use crate::{interrupt, output};

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
    ///
    /// The default, 100, is the first of the seeds that the README reports. Nothing was chosen on them: creep, strays and
    /// the contact threshold were chosen with Table I in view on seeds 1000 to 5005, patience and the number of goals on
    /// seeds 0 to 2.
    #[arg(long, default_value_t = data::DEFAULT_SEED, value_name = "N")]
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

/// Runs everything and prints the tables.
pub fn run(options: Options, json: bool) -> Result<(), Failure> {
    let Options { out, quick, seed, .. } = &options;
    let (quick, seed) = (*quick, *seed);
    let mut stages = Stages::begin(&Shown);
    plan::Plan::new(seed, quick).settle(out, options.fresh)?;
    let command = if options.fresh {
        "the same command without --fresh"
    } else {
        "the same command"
    };
    interrupt::hint(format!(
        "what is finished is kept in {}; run {command} to go on (it needs no --resume)",
        out.display()
    ));

    let dataset = stages.run("Training reaches", || make_or_reuse(out, seed, quick))?;
    output::remarks(audit::warnings(dataset.episodes(), dataset.layout()));
    let contacts = stages.run("Trials", || {
        Trials::of_dataset(&dataset, &data::any_length_options(), &Shown)
    })?;
    let trials = contacts.lasting(data::trial_options().min_samples);
    write_trials(out.join("trials-component.parquet"), trials.component.iter().cloned())?;
    write_trials(out.join("trials-taxel.parquet"), trials.taxel.iter().cloned())?;
    let data = Data {
        seed,
        quick,
        reaches: results::Reaches::of(dataset.episodes(), dataset.layout()),
        trials,
        contacts: contacts.taxel,
        tested: stages.run("Engineered, general and outlier reaches", || {
            reaches::draw(&out.join("reaches"), seed, quick, &Shown)
        })?,
    };
    let Analysis {
        mut results,
        models,
        online,
        thresholds,
    } = Analysis::of(&data, &mut stages)?;
    output::write_file(
        &out.join("model.json"),
        Model::new(Box::new(models.clone())).save_string()?.as_bytes(),
    )?;

    let moments = stages.run("A moment of a general and of an outlier reach", || {
        let take = |scene, reach, rule| snapshot::take(&models, reach, &reaches::plan(scene, seed)?, rule);
        Ok([
            take(data::MIXED, online.shown(), online::uncertain_rule())?,
            take(data::OUTLIER, online.outlier.first(), Decision::paper().rule)?,
        ])
    })?;
    results.splits = stages.run("Other arms and speeds", || {
        kept::result(&campaign::kept_file(out, "splits", seed), (seed, quick), &Shown, || {
            splits::run(seed, quick, &data.trials.taxel, &Shown)
        })
    })?;
    if !quick {
        results.ablation = stages.run("What each part of reality is worth", || {
            kept::result(
                &campaign::kept_file(out, "ablation", seed),
                (seed, quick),
                &Shown,
                || ablation::run(seed, &dataset, &results.measurement, &Shown),
            )
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
    for file in page::files(&results, &online, &thresholds, &moments) {
        output::write_file(&out.join("report").join(file.path), file.text.as_bytes())?;
    }
    output::result(json, &results, || words::text(&results, out))
}

/// Makes the training data, goes on with an interrupted set, or takes the finished one.
fn make_or_reuse(out: &Path, seed: u64, quick: bool) -> Result<Dataset, ExperimentError> {
    let (campaign, folder) = (campaign::campaign(seed, quick)?, out.join("dataset"));
    match Dataset::open(&folder) {
        Ok(dataset) if campaign.has_made(&dataset)? => {
            Shown.remark(&format!("  taken from {}", folder.display()));
            Ok(dataset)
        }
        _ => match campaign.write(&folder, true, &Shown)? {
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
) -> Result<Option<Campaigns>, ExperimentError> {
    let bar = Shown.count("further campaigns", count - 1, 0);
    let mut measured = vec![(seed, first)];
    for number in 1..count {
        let seed = seed.wrapping_add(number);
        measured.push((seed, campaign::measured(out, seed, quick, &Shown)?));
        bar.advance();
    }
    Campaigns::of(&measured)
}
