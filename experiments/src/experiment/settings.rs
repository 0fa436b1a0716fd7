//! Classifiers trained at one arm stiffness and hand speed and tested at others: the open question of
//! the follow-up study (arXiv 1409.4972).

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use underbrush_classifier::evaluate::evaluate;
use underbrush_classifier::{Decision, Estimator, Evaluation, is_trained};
use underbrush_recording::{Fault, Trial};
use underbrush_sim::campaign::Job;

use crate::dataset::jobs_of;
use crate::definition::Setting;
use crate::training::{self, Trials};
use crate::{Accuracy, Experiment, Session, in_parallel};

/// Every classifier, trained and tested at every pair of settings.
#[derive(Default, Serialize, Deserialize)]
pub struct ComparedSettings {
    /// By classifier, then by the setting of training, then by the setting of testing.
    pub splits: Vec<Split>,
    /// Why settings are missing from the splits, a sentence for each.
    pub settings_left_out: Vec<String>,
}

/// The accuracy of a classifier that was trained at one setting and tested at another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Split {
    /// The classifier.
    pub classifier: String,
    /// The setting of training.
    pub trained: String,
    /// The setting of testing.
    pub tested: String,
    /// The accuracy.
    #[serde(flatten)]
    pub accuracy: Accuracy,
}

/// Taxel trials of one setting, in two folds of whole reaches.
pub struct Folded {
    /// Name of the setting.
    pub name: String,
    /// The folds.
    pub folds: [Vec<Trial>; 2],
}

impl Folded {
    /// Takes the first `counts` reaches of each scene from a campaign with `reaches` reaches of each scene, and puts
    /// half of them into each fold. The reaches are the same at every setting: they have the same clutter and goals.
    pub fn new(name: &str, taxel_trials: &[Trial], reaches: &[u64], counts: &[u64]) -> Self {
        let fold = |Job { plan, reach_index }: Job| {
            (reach_index < counts[plan]).then_some(usize::from(2 * reach_index >= counts[plan]))
        };
        let own: Vec<Option<usize>> = jobs_of(reaches.iter().copied()).map(fold).collect();
        let fold = |trial: &&Trial| *own.get(trial.reach? as usize)?;
        let folds = [0, 1].map(|half| taxel_trials.iter().filter(|trial| fold(trial) == Some(half)).cloned().collect());
        Folded { name: name.into(), folds }
    }

    /// What is missing if a half has no trial of some of these categories. A classifier would be tested on a category that it was not
    /// fitted to.
    pub fn lack(&self, categories: &BTreeSet<&str>) -> Option<String> {
        let missing = self.folds.iter().find_map(|fold| categories.difference(&categories_of(fold)).next().copied())?;
        Some(format!(
            "setting {}: one half of its reaches has no trial of {missing} that is long enough, so a classifier fitted to it would \
             not know {missing}; give the training scenes more setting_reaches",
            self.name
        ))
    }
}

/// Runs the training scenes at the other settings, and tests the classifiers of each setting at every setting.
pub fn run(session: &Session) -> Result<ComparedSettings, Fault> {
    let data = session.once(training::run)?;
    let experiment = session.experiment;
    if experiment.file.settings.is_empty() || experiment.file.setting_classifiers.is_empty() {
        return Ok(ComparedSettings::default());
    }
    let counts: Vec<u64> = experiment.file.training.iter().map(|own| own.setting_reaches()).collect();
    let compared = || {
        let reaches = training::reaches(experiment);
        let mut settings = vec![Folded::new(Setting::NOMINAL, &data.trials.taxel, &reaches, &counts)];
        for setting in &experiment.file.settings {
            let campaign = training::campaign(experiment, session.seed, &counts, |scene| scene.robot = setting.robot)?;
            let trials = Trials::of_campaign(experiment, &campaign, session.progress)?;
            settings.push(Folded::new(&setting.name, &trials.taxel, &counts, &counts));
        }
        // To end the run here would cost the hours that it took.
        let labels = experiment.labels().into_iter().collect();
        let settings_left_out: Vec<String> = settings.iter().filter_map(|own| own.lack(&labels)).collect();
        settings_left_out.iter().for_each(|lack| session.progress.remark(&format!("left out: {lack}")));
        settings.retain(|own| own.lack(&labels).is_none());
        let splits = splits(experiment, &settings)?;
        Ok(ComparedSettings { splits, settings_left_out })
    };
    session.stage("Other arms and speeds", || session.kept("splits", session.seed, compared))
}

/// The categories of trials that classifiers are fitted to.
fn categories_of(trials: &[Trial]) -> BTreeSet<&str> {
    trials.iter().filter_map(|trial| trial.category.as_deref()).filter(|category| is_trained(category)).collect()
}

/// Trains every classifier at every setting on one half of the reaches and tests it at every setting on the other half.
/// This way no clutter occurs in both halves, and all classifiers are trained on the same number of reaches. No setting may
/// [`Folded::lack`] a category.
///
/// # Errors
/// If fitting or scoring fails.
pub fn splits(experiment: &Experiment, settings: &[Folded]) -> Result<Vec<Split>, Fault> {
    let recipe = experiment.main_recipe();
    let entries = experiment.file.setting_classifiers.iter();
    let all: Vec<(&str, Box<dyn Estimator>)> =
        entries.map(|entry| (entry.name.as_str(), entry.estimator(&recipe))).collect();
    let cases: Vec<_> =
        all.iter().flat_map(|classifier| settings.iter().map(move |trained| (classifier, trained))).collect();
    let row = |((classifier, estimator), trained): &(&(&str, Box<dyn Estimator>), &Folded)| {
        let (mut predictions, mut categories) = (vec![Vec::new(); settings.len()], Vec::new());
        for fold in 0..2 {
            let fitted = estimator.fit(&trained.folds[1 - fold].iter().collect::<Vec<_>>())?;
            categories = fitted.categories();
            for (tested, predictions) in settings.iter().zip(&mut predictions) {
                let evaluation = evaluate(fitted.as_ref(), &tested.folds[fold], &Decision::argmax())?;
                predictions.extend(evaluation.predictions);
            }
        }
        let split = |(tested, predictions): (&Folded, Vec<_>)| {
            Ok(Split {
                classifier: (*classifier).into(),
                trained: trained.name.clone(),
                tested: tested.name.clone(),
                accuracy: Accuracy::of(&Evaluation::of(predictions, &categories, Vec::new())?),
            })
        };
        settings.iter().zip(predictions).map(split).collect()
    };
    let rows: Vec<Vec<Split>> = in_parallel(&cases, row)?;
    Ok(rows.into_iter().flatten().collect())
}
