//! Verdicts on the objects that touch the skin, on contacts, and on each taxel frame by frame, by a touch model.

use std::sync::Arc;

use serde::Serialize;
use underbrush_classifier::evaluate::touch::TouchEvaluation;
use underbrush_classifier::evaluate::{EvaluateError, ObjectVerdicts, TouchFigures, UnknownFigures};
use underbrush_classifier::touch::TouchExamples;
use underbrush_recording::{Fault, Recording};

use crate::dataset::{each_reach, jobs_from};
use crate::definition::VerdictSection;
use crate::reaches::{self, Found};
use crate::{Session, in_parallel, training};

/// Number of parts into which the reaches are divided. Each part is judged by networks fitted to the other parts.
const FOLDS: usize = 3;
/// The reaches of the mixed scene have indices from here on, so that none of them is among the test reaches, which are
/// drawn from 0.
const FIRST_INDEX: u64 = 1000;

/// The verdicts, if the experiment asks for them.
#[derive(Serialize)]
pub struct VerdictFigures {
    /// The figures.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verdicts: Option<Verdicts>,
}

/// Figures over whole reaches that were held out. Shares are from 0 to 1.
#[derive(Serialize)]
pub struct Verdicts {
    /// Verdicts on known objects at some moments, over the reaches of all folds together.
    pub held_out_objects: Vec<ObjectVerdicts>,
    /// Verdicts on known objects at some moments, over all test reaches together. Reaches with the outliers are among them if
    /// `unknown` is given.
    pub test_objects: Vec<ObjectVerdicts>,
    /// How well the objects of both outliers are found, by the model's own decision, and how often the known objects of all test
    /// reaches are taken for unknown ones. `None` without outliers, and without auxiliary scenes, because a model from none calls
    /// nothing unknown.
    pub unknown: Option<UnknownFigures>,
    /// Balanced accuracy (mean over the categories of the share that is right) over contacts of taxels that a known
    /// category truly touched, by the category that is likeliest over the whole contact.
    pub touched_balanced_accuracy: Option<f64>,
    /// Number of these contacts.
    pub contacts: usize,
    /// The share of the most frequent category among them: the accuracy of always naming it.
    pub largest_category_share: Option<f64>,
    /// Share of the contacts whose last verdict is right.
    pub right_verdict_at_end: Option<f64>,
    /// Share of the taxel frames in contact without anything pressing that are called nothing.
    pub spurious_called_nothing: Option<f64>,
    /// Share of the taxel frames with a true contact that are called nothing.
    pub touches_lost: Option<f64>,
    /// Mean difference between the probability and the frequency of the likeliest class.
    pub expected_calibration_error: Option<f64>,
    /// Mean squared error of the probabilities.
    pub brier_score: Option<f64>,
    /// As `unknown`, without the reaches of the second outlier.
    pub outlier: Option<UnknownFigures>,
    /// As `unknown`, without the reaches of the first outlier.
    pub second_outlier: Option<UnknownFigures>,
    /// Number of reaches. The networks were fitted to all of them except the held-out part.
    pub training_reaches: usize,
    /// All verdicts on the held-out reaches.
    #[serde(skip)]
    pub held_out: TouchEvaluation,
    /// The known categories.
    #[serde(skip)]
    pub categories: Vec<String>,
}

/// Fits the networks and judges reaches that were held out.
pub fn run(session: &Session) -> Result<VerdictFigures, Fault> {
    let Some(section) = &session.experiment.file.verdicts else {
        return Ok(VerdictFigures { verdicts: None });
    };
    let recordings = recordings(session, section)?;
    let tests = session.once(reaches::run)?;
    session.stage("Verdicts", || {
        let mut examples = TouchExamples::new(session.experiment.touch_options());
        recordings.iter().try_for_each(|recording| examples.add(recording))?;
        let mut all = TouchEvaluation::default();
        let folds = in_parallel(0..FOLDS, |fold| held_out(&examples, &recordings, fold))?;
        folds.into_iter().for_each(|fold| all.add(fold));
        for scene in &section.auxiliary {
            drawn(session, section, scene)?.iter().try_for_each(|recording| examples.add_auxiliary(recording))?;
        }
        let model = Arc::new(examples.fit(None)?);
        let judge = |found: &Found| TouchEvaluation::of_all(&model, &found.reaches);
        let known = tests.engineered.iter().map(|(_, found)| found).chain(&tests.general);
        let known: Vec<TouchEvaluation> = known.map(judge).collect::<Result<_, _>>()?;
        let categories = model.categories().to_vec();
        let judge_unknown = |found: &Option<Found>| -> Result<Option<TouchEvaluation>, Fault> {
            let found = found.as_ref().filter(|_| !section.auxiliary.is_empty());
            Ok(found.map(judge).transpose()?)
        };
        let (outlier, second_outlier) = (judge_unknown(&tests.outlier)?, judge_unknown(&tests.second_outlier)?);
        let beside_known = |unknown: &[&TouchEvaluation]| pooled(unknown.iter().copied().chain(&known), &categories);
        let of_outlier = |own: &Option<TouchEvaluation>| own.as_ref().map(|own| beside_known(&[own]).unknown);
        let both: Vec<&TouchEvaluation> = outlier.iter().chain(&second_outlier).collect();
        let tested = beside_known(&both);
        let figures = TouchFigures::of(&all, &categories);
        let verdicts = Verdicts {
            held_out_objects: figures.object_verdicts,
            test_objects: tested.object_verdicts,
            unknown: (!both.is_empty()).then_some(tested.unknown),
            touched_balanced_accuracy: figures.contacts_at_end.and_then(|own| own.balanced_accuracy),
            contacts: all.contacts.len(),
            largest_category_share: figures.contacts_at_end.map(|own| own.majority_baseline),
            right_verdict_at_end: figures.right_after_samples.last().map(|end| end.share),
            spurious_called_nothing: figures.spurious_called_nothing,
            touches_lost: figures.touches_lost,
            expected_calibration_error: figures.expected_calibration_error,
            brier_score: figures.brier_score,
            outlier: of_outlier(&outlier),
            second_outlier: of_outlier(&second_outlier),
            training_reaches: recordings.len(),
            held_out: all,
            categories,
        };
        Ok(VerdictFigures { verdicts: Some(verdicts) })
    })
}

/// The reaches of the training scenes, and those of the mixed scene.
fn recordings(session: &Session, section: &VerdictSection) -> Result<Vec<Recording>, Fault> {
    let data = session.once(training::run)?;
    let reaches = 0..data.dataset.episodes().len();
    let mut recordings = reaches.map(|index| data.dataset.read_reach(index)).collect::<Result<Vec<Recording>, _>>()?;
    session.stage("Mixed training reaches", || {
        recordings.extend(drawn(session, section, &section.scene)?);
        Ok(recordings)
    })
}

/// Reaches of a scene, as many as the section asks for.
fn drawn(session: &Session, section: &VerdictSection, scene: &str) -> Result<Vec<Recording>, Fault> {
    let plan = reaches::plan(session.experiment, scene, session.seed)?;
    each_reach(&[plan], &jobs_from(FIRST_INDEX, section.reaches), 0, session.progress, |_, own| Ok(own))
}

/// Judges every `FOLDS`-th recording by networks fitted to the others, which must have all categories: verdicts of models
/// of different categories cannot be counted together.
pub(crate) fn held_out(
    examples: &TouchExamples,
    recordings: &[Recording],
    fold: usize,
) -> Result<TouchEvaluation, Fault> {
    let model = Arc::new(examples.some(|index| index % FOLDS != fold).fit(None)?);
    let (left, all) = (model.categories().to_vec(), examples.categories());
    if left != all {
        let remedy = "ask for more reaches of the training scenes or of the verdicts' scene";
        return Err(EvaluateError::FewCategories { fold: fold + 1, folds: FOLDS, left, all, remedy }.into());
    }
    Ok(TouchEvaluation::of_all(&model, recordings.iter().skip(fold).step_by(FOLDS))?)
}

/// The figures of all these reaches together. Each object and each contact counts once, so sets of reaches count by their size.
pub(crate) fn pooled<'a>(parts: impl IntoIterator<Item = &'a TouchEvaluation>, categories: &[String]) -> TouchFigures {
    let mut all = TouchEvaluation::default();
    parts.into_iter().for_each(|own| all.add(own.clone()));
    TouchFigures::of(&all, categories)
}
