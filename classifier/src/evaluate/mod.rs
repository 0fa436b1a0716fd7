//! Evaluation: cross-validation, confusion matrices, figures by category with confidence intervals, ROC curves, chosen
//! thresholds, and the paper's Table I.

mod by_samples;
mod confusion;
mod cross_validation;
mod error;
mod fold;
mod frame_figures;
mod interval;
mod object_figures;
mod object_verdicts;
mod prediction;
mod roc;
mod stream;
mod tally;
mod threshold;
pub mod touch;
mod touch_contact;
mod touch_figures;
pub mod touch_folds;
mod touch_object;

pub use by_samples::{AccuracyBySamples, Compared, EvaluationReport, SAMPLE_COUNTS, accuracy_by_samples, peak_force};
pub use confusion::{Accuracy, AccuracyByTouch, CategoryFigures, ConfusionMatrix, Rates};
pub use cross_validation::{Evaluation, cross_validate, evaluate, warn_of_left_out};
use cross_validation::{across_folds, predict};
pub use error::EvaluateError;
pub use fold::{FoldBy, Folds};
pub use frame_figures::{ReachFigures, TruthFigures};
use interval::bootstrap_balanced;
pub use interval::{Interval, bootstrap_by_reach, wilson};
pub use object_figures::{FlipFigures, GroupingFigures, StiffnessFigures, UnknownFigures};
pub use object_verdicts::{CostVerdicts, ObjectVerdicts};
pub use prediction::{Prediction, Record};
pub use roc::{RocCurve, RocPoint, category_roc, outlier_roc};
pub use stream::{NOTHING, Stream, StreamContact, StreamFrame, StreamTruth, classify_stream, classify_touch_stream};
pub use tally::{Tally, mean, share};
pub use threshold::{ChosenThresholds, HeldOut, ThresholdError, ThresholdTargets, choose_thresholds};
pub use touch_figures::{PatchFigures, RightAfter, TouchFigures};
pub use touch_object::{JudgedObject, Likeliest};

#[cfg(test)]
mod tests;
