//! An evaluation as text.

use underbrush_classifier::evaluate::{Accuracy, AccuracyBySamples, Evaluation, EvaluationReport, FoldBy};

use crate::output::{self, cells};

/// The whole evaluation.
pub(super) fn of(results: &EvaluationReport) -> String {
    let mut text = evaluation(&results.evaluation);
    if let Some(folds) = results.folds {
        let by = match folds.by {
            FoldBy::Reach => "by whole reaches",
            FoldBy::Position => "by position; trials of one reach may be in different folds",
        };
        text += &format!("\n{} folds {by}", folds.count);
    }
    let predictions = &results.evaluation.predictions;
    let shortest = predictions.iter().map(|prediction| prediction.samples).min().unwrap_or(1);
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
    match &results.by_samples_of_all {
        Some(series) => {
            text += "\nThe same over all contacts, including short ones; only the trials above are used for fitting:\n";
            text += &by_samples(series);
        }
        None if results.by_samples.is_some() && shortest > 1 => {
            text += "\nFor the accuracy over all contacts, give trials of any length and choose with --min-samples which are used \
                     for fitting.\n";
        }
        None => {}
    }
    text
}

fn percent(fraction: f64) -> String {
    format!("{:.1}", 100.0 * fraction)
}

fn maybe(fraction: Option<f64>) -> String {
    fraction.map_or("-".into(), percent)
}

/// An accuracy, balanced accuracy and baseline in one cell.
fn three(accuracy: f64, balanced: Option<f64>, baseline: f64) -> String {
    format!("{} ({}, {})", percent(accuracy), maybe(balanced), percent(baseline))
}

fn by_samples(series: &[AccuracyBySamples]) -> String {
    let part = |part: Option<Accuracy>| {
        part.map_or("-".into(), |own| three(own.accuracy, own.balanced_accuracy, own.majority_baseline))
    };
    let row =
        |point: &AccuracyBySamples| {
            let interval = point.interval_by_reach;
            let lasting = point.accuracy_of_lasting.zip(point.majority_baseline_of_lasting);
            let mut row = vec![
                point.samples.map_or("all".into(), |samples| samples.to_string()),
                three(point.accuracy, point.balanced_accuracy, point.majority_baseline),
                interval.map_or("-".into(), |ends| format!("{}-{}", percent(ends.low), percent(ends.high))),
            ];
            if let Some(split) = point.by_touch {
                row.extend([part(split.touched), part(split.untouched)]);
            }
            row.push(point.lasting.to_string());
            row.push(lasting.map_or("-".into(), |(accuracy, baseline)| {
                three(accuracy, point.balanced_accuracy_of_lasting, baseline)
            }));
            row
        };
    let mut header = vec!["samples", "accuracy % *", "95 % by reach"];
    if series.iter().any(|point| point.by_touch.is_some()) {
        header.extend(["touched *", "never touched *"]);
    }
    header.extend(["trials that last", "accuracy of these *"]);
    format!("{}* in brackets: balanced accuracy, majority baseline\n", output::table(&header, series.iter().map(row)))
}

fn evaluation(evaluation: &Evaluation) -> String {
    let matrix = &evaluation.confusion;
    let mut header = vec!["truth \\ verdict"];
    header.extend(matrix.verdict.iter().map(String::as_str));
    let rows = matrix.truth.iter().zip(&matrix.count);
    let rows =
        rows.map(|(truth, counts)| std::iter::once(truth.clone()).chain(counts.iter().map(usize::to_string)).collect());
    let mut text = output::table(&header, rows);
    let figures = evaluation.categories.iter().map(|own| {
        let ends = format!("{}-{}", percent(own.recall_interval.low), percent(own.recall_interval.high));
        cells![own.category, own.trials, percent(own.recall), ends, maybe(own.precision), percent(own.f1)]
    });
    text += "\n";
    text += &output::table(&["category", "trials", "recall %", "95 % interval", "precision %", "F1 %"], figures);
    text += "\n";
    text += &accuracies(evaluation);
    let by_trial = evaluation.accuracy_interval_by_trial;
    text += &format!(
        "\naccuracy {} %; 95 % interval {}-{} % as if trials were independent",
        percent(evaluation.accuracy),
        percent(by_trial.low),
        percent(by_trial.high)
    );
    if let Some(by_reach) = evaluation.accuracy_interval_by_reach {
        text += &format!(", {}-{} % resampling whole reaches", percent(by_reach.low), percent(by_reach.high));
    }
    text
}

/// The accuracy over all trials and by touch, each with its baseline.
fn accuracies(evaluation: &Evaluation) -> String {
    let mut parts = vec![("all trials", evaluation.confusion.accuracy())];
    if let Some(split) = evaluation.by_touch {
        parts.extend([
            ("touched by an object", split.touched),
            ("never touched", split.untouched),
            ("not known", split.unknown),
        ]);
    }
    let rows = parts.into_iter().filter_map(|(name, part)| {
        let Accuracy { trials, accuracy, balanced_accuracy, majority_baseline, .. } = part?;
        Some(cells![name, trials, percent(accuracy), maybe(balanced_accuracy), percent(majority_baseline)])
    });
    output::table(&["judged", "trials", "accuracy %", "balanced accuracy %", "majority baseline %"], rows)
}
