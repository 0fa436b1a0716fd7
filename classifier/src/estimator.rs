//! The interface of everything that is fitted to trials: the hidden Markov models, the baselines, and any other
//! classifier to compare with them.
//!
//! An [`Estimator`] holds the options of a classifier. Fitting it to trials gives a [`Classifier`], which scores
//! trials, scores contacts while they last ([`Classifier::online_scorer`]) and is saved in a model file. A
//! [`ClassifierKind`] is an entry in the list of classifiers, [`crate::registry::CLASSIFIERS`].

use std::any::Any;
use std::collections::BTreeMap;
use std::fmt::Debug;

use schemars::{Schema, SchemaGenerator};
use serde_json::Value;
use underbrush_recording::{Category, InputError, Sample, Trial, stop};

use crate::stream_feature::after;
use crate::{Document, FeatureSet, ModelError, SampleFault, TrainingHistory};

/// Options of a classifier that can be fitted to labelled trials.
pub trait Estimator: Sync {
    /// Fits a classifier to these trials. The result is bit for bit the same for any number of threads.
    ///
    /// Trials without a category, blocks and outliers are skipped ([`is_trained`]).
    ///
    /// # Errors
    /// [`ModelError`] if an option is outside its range, no trial has a category, or a trial lacks a feature.
    fn fit(&self, trials: &[&Trial]) -> Result<Box<dyn Classifier>, ModelError>;
}

/// Scores categories from the samples of a contact.
pub trait Classifier: Any + Debug + Send + Sync {
    /// Name of the kind of classifier, as in the list and in model files.
    fn name(&self) -> &'static str;

    /// The features of each sample.
    fn features(&self) -> FeatureSet;

    /// The categories in alphabetical order: the order of all scores.
    fn categories(&self) -> Vec<String>;

    /// A scorer for up to this many contacts at once, sample by sample.
    fn online_scorer(&self, contacts: usize) -> Box<dyn OnlineScorer>;

    /// The entries of this classifier's model file besides format, name, decision and provenance, by key.
    fn file_entries(&self) -> Vec<(&'static str, Value)>;

    /// The scores after the first k samples of the trial, for each k in `counts`: one row per count, with one score per
    /// category. A score is a log-likelihood, or a log-posterior under equal priors, in nats, so priors can be added
    /// and differences are margins. The counts must be ascending and at least 1. A count greater than the trial's
    /// length means the whole trial.
    ///
    /// Later samples have no influence on a score, so scores are available while a contact lasts.
    ///
    /// # Errors
    /// [`ModelError`] if the trial is empty or lacks a feature, and the errors of [`OnlineScorer::scores`].
    fn scores_after(&self, trial: &Trial, counts: &[usize]) -> Result<Vec<Vec<f64>>, ModelError> {
        let mut scorer = self.online_scorer(1);
        scorer.begin(0);
        let scores = vec![0.0; self.categories().len()];
        let push = |(scorer, _, is_new): &mut Scored, sample: &Sample| {
            if scorer.push(0, sample)? {
                scorer.advance();
                *is_new = true;
            }
            Ok(())
        };
        after(trial, counts, (scorer, scores, false), push, |(scorer, scores, is_new)| {
            if std::mem::take(is_new) {
                scorer.scores(0, scores)?;
            }
            Ok(scores.clone())
        })
    }

    /// The scores of whole trials, one row per trial.
    ///
    /// # Errors
    /// As [`Classifier::scores_after`].
    fn scores_of_all(&self, trials: &[&Trial]) -> Result<Vec<Vec<f64>>, ModelError> {
        let of_trial = |trial: &&Trial| {
            stop::check();
            let mut scores = self.scores_after(trial, &[trial.samples.len()])?;
            Ok(scores.pop().unwrap_or_default())
        };
        trials.iter().map(of_trial).collect()
    }

    /// The training report of each category, for classifiers that are trained iteratively.
    fn training(&self) -> Option<&BTreeMap<String, TrainingHistory>> {
        None
    }
}

/// A contact that is scored: its scorer, its last scores, and whether a sample has changed them since.
type Scored = (Box<dyn OnlineScorer>, Vec<f64>, bool);

/// Scores several contacts at once, sample by sample: [`OnlineScorer::begin`] a contact, [`OnlineScorer::push`] its
/// samples, [`OnlineScorer::advance`] after the samples of one frame, then read the [`OnlineScorer::scores`].
///
/// After k samples of a contact its scores equal [`Classifier::scores_after`] k samples of a trial, bit for bit.
pub trait OnlineScorer: Debug + Send {
    /// Restarts a contact; its earlier samples are forgotten. Contacts are numbered from 0.
    ///
    /// # Panics
    /// If `contact` is not below the number of contacts. The other methods panic in the same case.
    fn begin(&mut self, contact: usize);

    /// Takes in the next sample of a contact. Returns `false` if the sample has no influence, as after a fixed window.
    /// The scores then stay as they were and need not be read again.
    ///
    /// # Errors
    /// [`SampleFault`] if the sample lacks a feature or has a number that is not finite.
    fn push(&mut self, contact: usize, sample: &Sample) -> Result<bool, SampleFault>;

    /// Processes the samples pushed since the last call.
    fn advance(&mut self);

    /// Writes the scores of a contact, one per category, in nats. Valid after [`OnlineScorer::advance`], if the
    /// contact's last sample had an influence.
    ///
    /// # Errors
    /// [`ModelError`] if the classifier runs a network from a file, and the network fails.
    fn scores(&self, contact: usize, scores: &mut [f64]) -> Result<(), ModelError>;
}

/// Scores one contact, for classifiers that treat each contact by itself. [`Independent`] makes an [`OnlineScorer`]
/// from it.
pub trait ContactScorer: Clone + Debug + Send + 'static {
    /// As [`OnlineScorer::push`].
    ///
    /// # Errors
    /// As [`OnlineScorer::push`].
    fn push(&mut self, sample: &Sample) -> Result<bool, SampleFault>;

    /// As [`OnlineScorer::scores`].
    ///
    /// # Errors
    /// As [`OnlineScorer::scores`].
    fn scores(&self, scores: &mut [f64]) -> Result<(), ModelError>;
}

/// Contacts that are scored independently of each other.
#[derive(Clone, Debug)]
pub struct Independent<S> {
    fresh: S,
    contacts: Vec<S>,
}

impl<S: ContactScorer> Independent<S> {
    /// This many contacts, each of which starts as a copy of `fresh`.
    pub fn new(fresh: S, contacts: usize) -> Self {
        let contacts = vec![fresh.clone(); contacts];
        Independent { fresh, contacts }
    }
}

impl<S: ContactScorer> OnlineScorer for Independent<S> {
    fn begin(&mut self, contact: usize) {
        self.contacts[contact].clone_from(&self.fresh);
    }

    fn push(&mut self, contact: usize, sample: &Sample) -> Result<bool, SampleFault> {
        self.contacts[contact].push(sample)
    }

    fn advance(&mut self) {}

    fn scores(&self, contact: usize, scores: &mut [f64]) -> Result<(), ModelError> {
        self.contacts[contact].scores(scores)
    }
}

/// One entry in the list of classifiers ([`crate::registry::CLASSIFIERS`]).
#[derive(Debug)]
pub struct ClassifierKind {
    /// Name on the command line and in model files.
    pub name: &'static str,
    /// Further names that are accepted.
    pub aliases: &'static [&'static str],
    /// One line for the help.
    pub summary: &'static str,
    /// Whether it differs from another classifier in the list only by its features. It is left out where a user names features.
    pub is_by_features: bool,
    /// The default options, with these features if any are given.
    pub estimator: fn(Option<FeatureSet>) -> Box<dyn Estimator>,
    /// Reads and checks what [`Classifier::file_entries`] of this kind wrote.
    pub load: fn(&Document) -> Result<Box<dyn Classifier>, InputError>,
    /// The JSON Schema of what `load` reads.
    pub schema: fn(&mut SchemaGenerator) -> Schema,
}

impl ClassifierKind {
    /// All names that are accepted, the usual one first.
    pub fn names(&self) -> impl Iterator<Item = &'static str> {
        [self.name].into_iter().chain(self.aliases.iter().copied())
    }
}

/// Whether classifiers are trained on a category: on any except [`Category::BLOCK`] and [`Category::OUTLIER`].
pub fn is_trained(category: &str) -> bool {
    !matches!(Category::from_name(category), Some(Category::BLOCK | Category::OUTLIER))
}

/// The trials of each category that classifiers are fitted to, in the order of the table.
///
/// # Errors
/// [`ModelError::NoCategories`] if there are none.
pub fn trials_by_category<'a>(
    trials: impl IntoIterator<Item = &'a Trial>,
) -> Result<BTreeMap<String, Vec<&'a Trial>>, ModelError> {
    let mut by_category: BTreeMap<String, Vec<&Trial>> = BTreeMap::new();
    let mut count = 0;
    for trial in trials {
        count += 1;
        if let Some(category) = trial.category.as_deref().filter(|category| is_trained(category)) {
            by_category.entry(category.to_owned()).or_default().push(trial);
        }
    }
    if by_category.is_empty() { Err(ModelError::NoCategories(count)) } else { Ok(by_category) }
}
