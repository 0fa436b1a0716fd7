//! Campaigns of the paper's size: reaches, trials, Table I.

use std::path::Path;
use std::sync::Mutex;

use serde::{Deserialize, Serialize};
use underbrush_classifier::evaluate::{Folds, Interval, TableOneCell, TableOneUnit, table_one};
use underbrush_classifier::feature::FeatureSet;
use underbrush_classifier::recipe::Recipe;
use underbrush_classifier::trial::{TrialError, component_trials, taxel_trials};
use underbrush_recording::disk::Dataset;
use underbrush_recording::{Recording, Trial};
use underbrush_sim::scene::Scene;

use super::data::{self, TRAINING};
use crate::dataset::{Campaign, PROGRAM_VERSION};
use crate::failure::Failure;
use crate::{output, progress};

/// Trials of a whole campaign, reach by reach.
#[derive(Default)]
pub struct Trials {
    pub component: Vec<Trial>,
    pub taxel: Vec<Trial>,
}

/// A cell of Table I with the name of its recipe.
pub type RecipeCell = (&'static str, TableOneCell);

/// What a campaign comes to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measurement {
    pub trials_per_reach: Vec<TrialsPerReach>,
    /// Twelve cells a recipe.
    pub table_1: Vec<Cell>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialsPerReach {
    pub by: TableOneUnit,
    pub category: String,
    pub trials: usize,
    pub per_reach: f64,
    pub paper: f64,
}

/// A cell of Table I, all figures in per cent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell {
    pub by: TableOneUnit,
    pub features: FeatureSet,
    pub states: usize,
    pub recipe: String,
    pub accuracy: f64,
    /// Ends of the 95 % interval that resamples whole reaches.
    pub low: f64,
    pub high: f64,
    pub paper: f64,
}

pub const AUTHORS: &str = "authors";
pub const MODERN: &str = "modern";

/// The two recipes in which Table I is made: how the report calls them, and what they are.
pub fn recipes() -> [(&'static str, Recipe); 2] {
    [(AUTHORS, Recipe::authors()), (MODERN, Recipe::modern())]
}

pub fn campaign(seed: u64, quick: bool) -> Result<Campaign, Failure> {
    let scene = |training: &data::Training| {
        let (path, text) = training.scene;
        let reaches = if quick {
            training.quick_reaches
        } else {
            training.reaches
        };
        Ok((Scene::parse(path, text.into())?, reaches))
    };
    Ok(Campaign {
        scenes: TRAINING.iter().map(scene).collect::<Result<_, Failure>>()?,
        seed,
        controller: data::CONTROLLER.map(str::to_owned),
        shard: None,
    })
}

impl Trials {
    pub fn cut(recording: &Recording) -> Result<Self, TrialError> {
        let options = data::trial_options();
        let plain = |found: Vec<underbrush_classifier::trial::ContactTrial>| {
            found.into_iter().map(|contact| contact.trial).collect()
        };
        Ok(Trials {
            component: plain(component_trials(recording, &options)?),
            taxel: plain(taxel_trials(recording, &options)?),
        })
    }

    /// Appends the trials of the reach at a place of the campaign, numbered on.
    pub fn append(&mut self, place: usize, other: Trials) {
        for (all, more) in [(&mut self.component, other.component), (&mut self.taxel, other.taxel)] {
            for trial in more {
                let number = all.len() as u64;
                all.push(Trial {
                    trial: number,
                    reach: Some(place as u64),
                    ..trial
                });
            }
        }
    }

    /// The trials of a data set.
    pub fn of_dataset(dataset: &Dataset) -> Result<Self, Failure> {
        let bar = progress::bar(dataset.episodes().len() as u64, "reaches read");
        let mut trials = Trials::default();
        for episode in 0..dataset.episodes().len() {
            trials.append(episode, Trials::cut(&dataset.read_reach(episode)?)?);
            bar.inc(1);
        }
        bar.finish_and_clear();
        Ok(trials)
    }

    /// Runs a campaign and keeps its trials alone: frames of twenty campaigns would fill a disk.
    fn of_campaign(campaign: &Campaign) -> Result<Self, Failure> {
        let cut: Mutex<Vec<(usize, Trials)>> = Mutex::default();
        campaign.run(|place, recording| {
            let own = Trials::cut(&recording)?;
            if let Ok(mut cut) = cut.lock() {
                cut.push((place, own));
            }
            Ok::<(), TrialError>(())
        })?;
        let mut cut = cut.into_inner().unwrap_or_default();
        cut.sort_by_key(|(place, _)| *place);
        let mut trials = Trials::default();
        cut.into_iter().for_each(|(place, own)| trials.append(place, own));
        Ok(trials)
    }

    fn of(&self, by: TableOneUnit) -> &[Trial] {
        match by {
            TableOneUnit::Component => &self.component,
            TableOneUnit::Taxel => &self.taxel,
        }
    }

    /// Trials per reach, and Table I in both recipes, with the evaluations behind each cell.
    pub fn measure(&self, quick: bool) -> Result<(Measurement, Vec<RecipeCell>), Failure> {
        let mut trials_per_reach = Vec::new();
        for place in 0..2 {
            for training in &TRAINING {
                let (by, paper) = training.paper_trials_per_reach[place];
                let category = training.category.name();
                let own = |trial: &&Trial| trial.category.as_deref() == Some(category);
                let trials = self.of(by).iter().filter(own).count();
                let reaches = if quick {
                    training.quick_reaches
                } else {
                    training.reaches
                };
                trials_per_reach.push(TrialsPerReach {
                    by,
                    category: category.into(),
                    trials,
                    per_reach: trials as f64 / reaches as f64,
                    paper,
                });
            }
        }
        let mut cells = Vec::new();
        for (name, recipe) in recipes() {
            let found = table_one(&self.component, &self.taxel, &recipe, Folds::paper())?;
            cells.extend(found.into_iter().map(|cell| (name, cell)));
        }
        let table_1 = cells.iter().map(|(name, cell)| Cell::new(name, cell)).collect();
        Ok((
            Measurement {
                trials_per_reach,
                table_1,
            },
            cells,
        ))
    }
}

impl Cell {
    fn new(recipe: &str, cell: &TableOneCell) -> Self {
        let evaluation = &cell.evaluation;
        let Interval { low, high } = evaluation
            .accuracy_interval_by_reach
            .unwrap_or(evaluation.accuracy_interval_by_trial);
        Cell {
            by: cell.unit,
            features: cell.features,
            states: cell.states,
            recipe: recipe.into(),
            accuracy: 100.0 * evaluation.accuracy,
            low: 100.0 * low,
            high: 100.0 * high,
            paper: cell.paper_accuracy_percent,
        }
    }
}

/// A campaign's result as it is kept, with what it was made by.
#[derive(Serialize, Deserialize)]
struct Kept {
    program: String,
    /// Hash of the sources that decide trials, models and figures.
    analysis: String,
    seed: u64,
    quick: bool,
    measurement: Measurement,
}

/// The measurement of the campaign of a seed: as kept by this build, or made now and kept.
pub fn measured(out: &Path, seed: u64, quick: bool) -> Result<Measurement, Failure> {
    let path = out.join("campaigns").join(format!("seed-{seed}.json"));
    let kept = std::fs::read(&path)
        .ok()
        .and_then(|bytes| serde_json::from_slice::<Kept>(&bytes).ok())
        .filter(|kept| {
            kept.program == PROGRAM_VERSION
                && kept.analysis == env!("UNDERBRUSH_ANALYSIS_SOURCES")
                && (kept.seed, kept.quick) == (seed, quick)
        });
    if let Some(kept) = kept {
        return Ok(kept.measurement);
    }
    let (measurement, _) = Trials::of_campaign(&campaign(seed, quick)?)?.measure(quick)?;
    let kept = Kept {
        program: PROGRAM_VERSION.into(),
        analysis: env!("UNDERBRUSH_ANALYSIS_SOURCES").into(),
        seed,
        quick,
        measurement,
    };
    let bytes = serde_json::to_vec_pretty(&kept).map_err(|error| Failure::run(error.to_string()))?;
    output::write_file(&path, &bytes)?;
    Ok(kept.measurement)
}
