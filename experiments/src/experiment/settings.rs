//! Classifiers and verdict networks trained at one arm stiffness and hand speed and tested at others: the open question of
//! the follow-up study (arXiv 1409.4972).

use std::collections::BTreeSet;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use underbrush_classifier::evaluate::{evaluate, touch::TouchEvaluation};
use underbrush_classifier::touch::TouchExamples;
use underbrush_classifier::{Decision, Estimator, Evaluation, ModelError, TouchOptions, is_trained};
use underbrush_recording::{Fault, Recording, Trial};
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
    /// How well verdict networks tell contacts at the other settings apart.
    pub verdict_transfer: Vec<VerdictTransfer>,
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

/// Reaches at one setting, each with its fold, 0 or 1. Reaches with the same clutter are in the same fold at every
/// setting.
pub type FoldedReaches = Vec<(usize, Recording)>;

/// How well networks tell contacts at one setting apart: networks fitted at this setting, and networks fitted to as
/// many reaches at the scenes' own setting. The figures are balanced accuracies over touched contacts, from 0 to 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VerdictTransfer {
    /// The setting.
    pub setting: String,
    /// By networks fitted at this setting; `None` if too few contacts were touched, or a category in one fold alone.
    pub fitted_here: Option<f64>,
    /// By networks fitted at the scenes' own setting; `None` as for `fitted_here`.
    pub fitted_nominally: Option<f64>,
    /// Number of contacts.
    pub contacts: usize,
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
        let own = folds(reaches, counts);
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

/// The folds of the reaches of a campaign with `reaches` reaches of each scene, of which the first `counts` are used; `None`
/// for the others.
fn folds(reaches: &[u64], counts: &[u64]) -> Vec<Option<usize>> {
    let fold = |Job { plan, reach_index }: Job| {
        (reach_index < counts[plan]).then_some(usize::from(2 * reach_index >= counts[plan]))
    };
    jobs_of(reaches.iter().copied()).map(fold).collect()
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
        let used = folds(&reaches, &counts).into_iter().enumerate().filter_map(|(index, fold)| Some((index, fold?)));
        let nominal: FoldedReaches =
            used.map(|(index, fold)| Ok((fold, data.dataset.read_reach(index)?))).collect::<Result<_, Fault>>()?;
        let mut verdict_transfer = Vec::new();
        let mut settings = vec![Folded::new(Setting::NOMINAL, &data.trials.taxel, &reaches, &counts)];
        for setting in &experiment.file.settings {
            let campaign = training::campaign(experiment, session.seed, &counts, |scene| scene.robot = setting.robot)?;
            // Recordings need about 10 MB of memory per minute of simulated time.
            let recordings = campaign.each(session.progress, Ok)?;
            let trials = Trials::of_recordings(experiment, &counts, &recordings)?;
            settings.push(Folded::new(&setting.name, &trials.taxel, &counts, &counts));
            if experiment.file.verdicts.is_some() {
                let here = folds(&counts, &counts).into_iter().zip(recordings);
                let here = here.filter_map(|(fold, own)| Some((fold?, own))).collect();
                let options = experiment.touch_options();
                verdict_transfer.push(VerdictTransfer::of(&setting.name, &options, &here, &nominal)?);
            }
        }
        // To end the run here would cost the hours that it took.
        let labels = experiment.labels().into_iter().collect();
        let settings_left_out: Vec<String> = settings.iter().filter_map(|own| own.lack(&labels)).collect();
        settings_left_out.iter().for_each(|lack| session.progress.remark(&format!("left out: {lack}")));
        settings.retain(|own| own.lack(&labels).is_none());
        let splits = splits(experiment, &settings)?;
        Ok(ComparedSettings { splits, verdict_transfer, settings_left_out })
    };
    session.stage("Other arms and speeds", || session.kept("splits", session.seed, compared))
}

/// The categories of trials that classifiers are fitted to.
fn categories_of(trials: &[Trial]) -> BTreeSet<&str> {
    trials.iter().filter_map(|trial| trial.category.as_deref()).filter(|category| is_trained(category)).collect()
}

/// Trains every classifier at every setting on one half of the reaches and tests it at every setting on the other half.
/// This way no clutter occurs in both halves, and all classifiers are trained on the same number of reaches.
///
/// # Errors
/// If one half of a setting's reaches has no trial of some category, or fitting or scoring fails.
pub fn splits(experiment: &Experiment, settings: &[Folded]) -> Result<Vec<Split>, Fault> {
    let all = settings.iter().flat_map(|setting| &setting.folds).flat_map(|fold| categories_of(fold)).collect();
    if let Some(lack) = settings.iter().find_map(|setting| setting.lack(&all)) {
        return Err(Fault::Usage(lack));
    }
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

impl VerdictTransfer {
    /// Judges each fold of the reaches `here` by networks fitted to the other fold: once of the reaches `here`, and
    /// once of the reaches at the scenes' own setting, `nominal`.
    ///
    /// # Errors
    /// If the reaches do not fit the patch.
    pub fn of(
        setting: &str,
        options: &TouchOptions,
        here: &FoldedReaches,
        nominal: &FoldedReaches,
    ) -> Result<Self, Fault> {
        let (by_own, fitted_here) = judged(options, here, here)?;
        let (by_nominal, fitted_nominally) = judged(options, nominal, here)?;
        let contacts = by_own.max(by_nominal);
        Ok(VerdictTransfer { setting: setting.to_owned(), fitted_here, fitted_nominally, contacts })
    }
}

/// Number of contacts in each fold of `tested`, and the balanced accuracy on them of networks fitted to the other fold of
/// `fitted`; none if there is nothing to fit to, or a fold lacks a category.
fn judged(
    options: &TouchOptions,
    fitted: &FoldedReaches,
    tested: &FoldedReaches,
) -> Result<(usize, Option<f64>), Fault> {
    let mut examples = TouchExamples::new(options.clone());
    fitted.iter().try_for_each(|(_, recording)| examples.add(recording))?;
    let (mut evaluation, categories) = (TouchEvaluation::default(), examples.categories());
    for fold in 0..2 {
        let model = match examples.some(|index| fitted[index].0 != fold).fit(None) {
            Err(ModelError::NoCategories(_) | ModelError::Mismatch { .. }) => return Ok((0, None)),
            // Verdicts of models of different categories cannot be counted together.
            Ok(model) if model.categories() != categories => return Ok((0, None)),
            model => Arc::new(model?),
        };
        let tested = tested.iter().filter(|(own, _)| *own == fold).map(|(_, recording)| recording);
        evaluation.add(TouchEvaluation::of_all(&model, tested)?);
    }
    let accuracy = evaluation.accuracy(&categories, |contact| contact.at_end);
    Ok((evaluation.contacts.len(), accuracy.and_then(|own| own.balanced_accuracy)))
}
