//! An evaluation as text.

use underbrush_classifier::evaluate::{
    Accuracy, AccuracyBySamples, Compared, Evaluation, EvaluationReport, FoldBy, Interval,
};
use underbrush_report::drawing::Rows;

use crate::output::percent;

/// The whole evaluation.
pub(super) fn of(results: &EvaluationReport) -> String {
    let mut text = results.comparison.as_deref().map(comparison).unwrap_or_default();
    text += &evaluation(results);
    if let Some(folds) = results.folds {
        let by = match folds.by {
            FoldBy::Reach => "by whole reaches",
            FoldBy::Position => "by position; trials of one reach may be in different folds",
        };
        text += &format!("\n{} folds {by}", folds.count);
    }
    let shortest = results.evaluation.predictions.iter().map(|prediction| prediction.samples).min().unwrap_or(1);
    if let Some(series) = &results.by_samples {
        text += "\n\nAccuracy by samples since contact";
        text += &match shortest {
            0 | 1 => ", over all trials:\n".to_string(),
            _ => format!(
                ", of trials of {shortest} samples or more; before that, of contacts already known to last that long\n"
            ),
        };
        text += &by_samples(series);
    }
    if let Some(series) = &results.by_samples_of_all {
        text += "\nThe same over all contacts, including short ones; only the trials above are used for fitting:\n";
        text += &by_samples(series);
    }
    text
}

fn interval(ends: Interval) -> String {
    format!("{}-{}", percent(ends.low), percent(ends.high))
}

/// An accuracy, balanced accuracy and baseline in one cell.
fn three(accuracy: f64, balanced: Option<f64>, baseline: f64) -> String {
    format!("{} ({}, {})", percent(accuracy), percent(balanced), percent(baseline))
}

fn comparison(compared: &[Compared]) -> String {
    let rows = Rows::of(compared)
        .column("classifier", |own| match own.features {
            Some(features) => format!("{} ({features})", own.classifier),
            None => own.classifier.to_owned(),
        })
        .column("balanced accuracy %", |own| percent(own.accuracy.balanced_accuracy))
        .column("accuracy %", |own| percent(own.accuracy.accuracy))
        .column("95 % by reach", |own| own.interval_by_reach.map_or("-".into(), interval))
        .column("majority baseline %", |own| percent(own.accuracy.majority_baseline));
    format!("{}\nIn detail, hidden Markov models as in the paper:\n\n", rows.text())
}

fn by_samples(series: &[AccuracyBySamples]) -> String {
    let part = |part: Option<Accuracy>| {
        part.map_or("-".into(), |own| three(own.accuracy, own.balanced_accuracy, own.majority_baseline))
    };
    let is_split = series.iter().any(|point| point.by_touch.is_some());
    let rows = Rows::of(series)
        .column("samples", |own| own.samples.map_or("all".into(), |samples| samples.to_string()))
        .column("accuracy % *", |own| three(own.accuracy, own.balanced_accuracy, own.majority_baseline))
        .column("95 % by reach", |own| own.interval_by_reach.map_or("-".into(), interval))
        .when(is_split, |rows| {
            rows.column("touched *", |own| part(own.by_touch.and_then(|split| split.touched)))
                .column("never touched *", |own| part(own.by_touch.and_then(|split| split.untouched)))
        })
        .column("trials that last", |own| own.lasting)
        .column("accuracy of these *", |own| {
            let lasting = own.accuracy_of_lasting.zip(own.majority_baseline_of_lasting);
            lasting
                .map_or("-".into(), |(accuracy, baseline)| three(accuracy, own.balanced_accuracy_of_lasting, baseline))
        });
    format!("{}* in brackets: balanced accuracy, majority baseline\n", rows.text())
}

fn evaluation(results: &EvaluationReport) -> String {
    let evaluation = &results.evaluation;
    let matrix = &evaluation.confusion;
    let mut text = Rows::of(matrix.truth.iter().zip(&matrix.count))
        .column("truth \\ verdict", |(truth, _)| truth.as_str())
        .columns(&matrix.verdict, |(_, counts)| counts.iter().copied())
        .text();
    text += "\n";
    text += &Rows::of(&evaluation.categories)
        .column("category", |own| own.category.as_str())
        .column("trials", |own| own.trials)
        .column("recall %", |own| percent(own.recall))
        .column("95 % interval", |own| interval(own.recall_interval))
        .column("precision %", |own| percent(own.precision))
        .column("F1 %", |own| percent(own.f1))
        .text();
    text += "\n";
    text += &accuracies(evaluation, results.baseline.as_ref());
    let (accuracy, by_trial) = (percent(evaluation.accuracy), interval(evaluation.accuracy_interval_by_trial));
    text += &format!("\naccuracy {accuracy} %; 95 % interval {by_trial} % as if trials were independent");
    if let Some(by_reach) = evaluation.accuracy_interval_by_reach {
        text += &format!(", {} % resampling whole reaches", interval(by_reach));
    }
    text
}

/// The accuracy over all trials and by touch, each with its majority baseline, and that of the largest force alone.
fn accuracies(evaluation: &Evaluation, baseline: Option<&Compared>) -> String {
    let mut parts = vec![("all trials", evaluation.confusion.accuracy())];
    if let Some(split) = evaluation.by_touch {
        parts.extend([
            ("touched by an object", split.touched),
            ("never touched", split.untouched),
            ("not known", split.unknown),
        ]);
    }
    parts.extend(baseline.map(|own| ("all trials, by peak-force", Some(own.accuracy))));
    Rows::of(parts.into_iter().filter_map(|(name, part)| Some((name, part?))))
        .column("judged", |(name, _)| name)
        .column("trials", |(_, own)| own.trials)
        .column("accuracy %", |(_, own)| percent(own.accuracy))
        .column("balanced accuracy %", |(_, own)| percent(own.balanced_accuracy))
        .column("majority baseline %", |(_, own)| percent(own.majority_baseline))
        .text()
}
