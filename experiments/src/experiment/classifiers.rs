//! Other classifiers on the same trials, and how fast each of them decides.

use serde::{Deserialize, Serialize};
use underbrush_classifier::evaluate::{AccuracyBySamples, FoldBy, Folds, accuracy_by_samples, cross_validate};
use underbrush_classifier::{Decision, Estimator};
use underbrush_recording::{Fault, Trial};

use crate::definition::{ClassifierEntry, Experiment};
use crate::{Accuracy, Session, in_parallel, training};

/// All classifiers of the experiment, in the order of its file.
#[derive(Serialize)]
pub struct ComparedClassifiers {
    /// Their accuracies on whole trials.
    pub classifiers: Vec<Compared>,
    /// Their accuracies after increasing numbers of samples; none in a quick run.
    pub speeds: Vec<Speed>,
}

/// One classifier on whole taxel trials, cross-validated in two folds of whole reaches, in one campaign or in
/// many.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Compared<F = Accuracy> {
    /// Its name.
    pub classifier: String,
    /// Its figures.
    #[serde(flatten)]
    pub figures: F,
}

/// Accuracy of one classifier by samples since contact, as fractions.
#[derive(Serialize)]
pub struct Speed {
    /// Its name.
    pub classifier: String,
    /// On the trials of the cross-validation table, all of which have a minimum number of samples. Online, it is not
    /// known during a contact whether it will last that long.
    pub lasting_contacts: Vec<AccuracyBySamples>,
    /// On all contacts, including the shorter ones, as they occur online.
    pub all_contacts: Vec<AccuracyBySamples>,
}

/// Folds of whole reaches. This is stricter than the paper's folds by position, which can put trials of one contact on
/// both sides.
const FOLDS: Folds = Folds { count: 2, by: FoldBy::Reach };

/// Compares all classifiers.
pub fn run(session: &Session) -> Result<ComparedClassifiers, Fault> {
    let data = session.once(training::run)?;
    let experiment = session.experiment;
    if experiment.file.classifiers.is_empty() {
        return Ok(ComparedClassifiers { classifiers: Vec::new(), speeds: Vec::new() });
    }
    let classifiers = session.stage("Other classifiers", || compare(experiment, &data.trials.taxel))?;
    if session.quick {
        return Ok(ComparedClassifiers { classifiers, speeds: Vec::new() });
    }
    let (lasting, all) = (data.trials.taxel.as_slice(), data.contacts.as_slice());
    let min_samples = experiment.file.trials.min_samples;
    let speeds = session.stage("How fast classifiers decide", || {
        each(experiment, |entry, estimator| {
            Ok(Speed {
                classifier: entry.name.clone(),
                lasting_contacts: accuracy_by_samples(lasting, estimator, FOLDS, 1)?,
                all_contacts: accuracy_by_samples(all, estimator, FOLDS, min_samples)?,
            })
        })
    })?;
    Ok(ComparedClassifiers { classifiers, speeds })
}

/// Cross-validates all classifiers on whole trials.
pub fn compare(experiment: &Experiment, taxel_trials: &[Trial]) -> Result<Vec<Compared>, Fault> {
    each(experiment, |entry, estimator| {
        let evaluation = cross_validate(taxel_trials, estimator, FOLDS, &Decision::argmax())?;
        Ok(Compared { classifier: entry.name.clone(), figures: Accuracy::of(&evaluation) })
    })
}

/// Applies a function to each classifier, in parallel.
fn each<T: Send>(
    experiment: &Experiment,
    work: impl Fn(&ClassifierEntry, &dyn Estimator) -> Result<T, Fault> + Sync,
) -> Result<Vec<T>, Fault> {
    let recipe = experiment.main_recipe();
    in_parallel(&experiment.file.classifiers, |entry| work(entry, entry.estimator(&recipe).as_ref()))
}
