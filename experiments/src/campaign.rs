//! Campaigns of the paper's size: reaches, trials, Table I.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use underbrush_classifier::evaluate::{Folds, TableOneCell, TableOneUnit, table_one};
use underbrush_classifier::recipe::Recipe;
use underbrush_classifier::trial::{ContactTrial, TrialError, TrialOptions, component_trials, taxel_trials};
use underbrush_recording::disk::Dataset;
use underbrush_recording::{Recording, Trial};
use underbrush_sim::scene::{Scene, SceneFile};

use crate::data::{self, TRAINING};
use crate::dataset::Campaign;
use crate::error::ExperimentError;
use crate::measurement::{Cell, Measurement, OneOfMany, TrialsPerReach};
use crate::progress::Progress;
use crate::{classifiers, kept};

/// Trials of a whole campaign, reach by reach.
#[derive(Default)]
pub struct Trials {
    pub component: Vec<Trial>,
    pub taxel: Vec<Trial>,
}

/// A cell of Table I with the name of its recipe.
pub type RecipeCell = (&'static str, TableOneCell);

pub const AUTHORS: &str = "authors";
pub const MODERN: &str = "modern";

/// The two recipes in which Table I is made: how the report calls them, and what they are.
pub fn recipes() -> [(&'static str, Recipe); 2] {
    [(AUTHORS, Recipe::authors()), (MODERN, Recipe::modern())]
}

/// Reaches of each training scene.
pub fn reaches(quick: bool) -> [u64; 2] {
    TRAINING.map(|training| {
        if quick {
            training.quick_reaches
        } else {
            training.reaches
        }
    })
}

pub fn campaign(seed: u64, quick: bool) -> Result<Campaign, ExperimentError> {
    changed_campaign(seed, reaches(quick), |_| {})
}

/// So many reaches of each training scene with something changed. A data set would not tell of the change, as it stores
/// the scene's text: only for [`Trials::of_campaign`].
pub fn changed_campaign(
    seed: u64,
    reaches: [u64; 2],
    change: impl Fn(&mut SceneFile),
) -> Result<Campaign, ExperimentError> {
    let scene = |(training, reaches): (&data::Training, u64)| {
        let (path, text) = training.scene;
        let mut scene = Scene::parse(path, text.into())?;
        change(&mut scene.file);
        Ok((scene, reaches))
    };
    let scenes = TRAINING.iter().zip(reaches).map(scene);
    Ok(Campaign {
        scenes: scenes.collect::<Result<_, ExperimentError>>()?,
        arms: BTreeMap::new(),
        seed,
        controller: data::CONTROLLER,
        shard: None,
    })
}

impl Trials {
    pub fn cut(recording: &Recording, options: &TrialOptions) -> Result<Self, TrialError> {
        let plain = |found: Vec<ContactTrial>| found.into_iter().map(|contact| contact.trial).collect();
        Ok(Trials {
            component: plain(component_trials(recording, options)?),
            taxel: plain(taxel_trials(recording, options)?),
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
    pub fn of_dataset(
        dataset: &Dataset,
        options: &TrialOptions,
        progress: &dyn Progress,
    ) -> Result<Self, ExperimentError> {
        let count = progress.count("reaches read", dataset.episodes().len() as u64, 0);
        let mut trials = Trials::default();
        for episode in 0..dataset.episodes().len() {
            trials.append(episode, Trials::cut(&dataset.read_reach(episode)?, options)?);
            count.advance();
        }
        Ok(trials)
    }

    /// Runs a campaign and keeps its trials alone: frames of twenty campaigns would fill a disk.
    pub fn of_campaign(campaign: &Campaign, progress: &dyn Progress) -> Result<Self, ExperimentError> {
        let options = data::trial_options();
        let cut: Mutex<Vec<(usize, Trials)>> = Mutex::default();
        campaign.run(progress, |place, recording| {
            let own = Trials::cut(&recording, &options)?;
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

    /// Those of at least so many samples, numbered anew: the same as cut with [`TrialOptions::min_samples`].
    pub fn lasting(&self, min_samples: usize) -> Self {
        let long = |trial: &&Trial| trial.samples.len() >= min_samples;
        let renumbered = |trials: &[Trial]| {
            let own = trials.iter().filter(long).zip(0..);
            own.map(|(trial, number)| Trial {
                trial: number,
                ..trial.clone()
            })
            .collect()
        };
        Trials {
            component: renumbered(&self.component),
            taxel: renumbered(&self.taxel),
        }
    }

    fn of(&self, by: TableOneUnit) -> &[Trial] {
        match by {
            TableOneUnit::Component => &self.component,
            TableOneUnit::Taxel => &self.taxel,
        }
    }

    /// Trials per reach of a campaign of so many reaches of each scene.
    pub fn per_reach(&self, reaches: [u64; 2]) -> Vec<TrialsPerReach> {
        let mut rows = Vec::new();
        for place in 0..2 {
            for (training, reaches) in TRAINING.iter().zip(reaches) {
                let (by, paper) = training.paper_trials_per_reach[place];
                let category = training.category.name();
                let own = |trial: &&Trial| trial.category.as_deref() == Some(category);
                let trials = self.of(by).iter().filter(own).count();
                let untouched = |trial: &&Trial| trial.touched() == Some(false);
                rows.push(TrialsPerReach {
                    by,
                    category: category.into(),
                    trials,
                    untouched: self.of(by).iter().filter(own).filter(untouched).count(),
                    per_reach: trials as f64 / reaches as f64,
                    paper,
                });
            }
        }
        rows
    }

    /// Table I in one recipe, as numbers and with the evaluations behind them.
    pub fn table_1(
        &self,
        name: &'static str,
        recipe: &Recipe,
    ) -> Result<(Vec<Cell>, Vec<RecipeCell>), ExperimentError> {
        let found = table_one(&self.component, &self.taxel, recipe, Folds::paper())?;
        let cells = found.iter().map(|cell| Cell::new(name, cell)).collect();
        Ok((cells, found.into_iter().map(|cell| (name, cell)).collect()))
    }

    /// Trials per reach, and Table I in both recipes, with the evaluations behind each cell.
    pub fn measure(&self, quick: bool) -> Result<(Measurement, Vec<RecipeCell>), ExperimentError> {
        let (mut table_1, mut evaluated) = (Vec::new(), Vec::new());
        for (name, recipe) in recipes() {
            let (cells, found) = self.table_1(name, &recipe)?;
            table_1.extend(cells);
            evaluated.extend(found);
        }
        let measurement = Measurement {
            trials_per_reach: self.per_reach(reaches(quick)),
            table_1,
        };
        Ok((measurement, evaluated))
    }
}

/// The campaign of a seed, as kept or made now.
pub fn measured(out: &Path, seed: u64, quick: bool, progress: &dyn Progress) -> Result<OneOfMany, ExperimentError> {
    kept::result(&kept_file(out, "seed", seed), (seed, quick), progress, || {
        let trials = Trials::of_campaign(&campaign(seed, quick)?, progress)?;
        let classifiers = classifiers::run(&trials.taxel)?;
        Ok(OneOfMany::new(trials.measure(quick)?.0, &classifiers))
    })
}

/// Where a result of a seed is kept.
pub fn kept_file(out: &Path, name: &str, seed: u64) -> PathBuf {
    out.join("campaigns").join(format!("{name}-{seed}.json"))
}
