//! Verdict networks that were fitted at one arm stiffness and hand speed and judge reaches at another.

use std::sync::Arc;

use serde::{Deserialize, Serialize};
use underbrush_classifier::ModelError;
use underbrush_classifier::evaluate::touch::TouchEvaluation;
use underbrush_classifier::touch::{TouchExamples, TouchOptions};
use underbrush_recording::{Fault, Recording};

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
    for (_, recording) in fitted {
        examples.add(recording)?;
    }
    let (mut evaluation, categories) = (TouchEvaluation::default(), examples.categories());
    for fold in 0..2 {
        let model = match examples.some(|index| fitted[index].0 != fold).fit(None) {
            Err(ModelError::NoCategories { .. } | ModelError::Mismatch { .. }) => return Ok((0, None)),
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
