//! Results of touch models as text.

use underbrush_classifier::evaluate::{Accuracy, OutlierFigures, ReachFigures, TouchFigures};
use underbrush_classifier::touch::{FeatureWorth, TouchDecision, TouchRows};

use crate::output::{self, cells};

/// What a model was fitted to.
pub(super) fn rows(rows: &TouchRows) -> String {
    let taxels = [
        ("taxels, touched".to_owned(), rows.touched_taxels),
        ("taxels, nothing on them".to_owned(), rows.untouched_taxels),
    ];
    let regions = rows.regions.iter().map(|(category, count)| (format!("regions, {category}"), *count));
    let cells = taxels.into_iter().chain(regions).map(|(name, count)| cells![name, count]);
    format!(
        "Classifier touch\n{}From {}. Probabilities are calibrated on reaches that were held out: in {} parts, each \
         judged by networks fitted to the others\n",
        output::table(&["rows", "count"], cells),
        output::counted(rows.reaches, "reach", "reaches"),
        rows.held_out_parts
    )
}

/// When each verdict is given.
pub(super) fn decision(decision: &TouchDecision) -> String {
    let TouchDecision { nothing_above, unknown_share, cost_of_uncertain } = decision;
    format!(
        "A reading is called nothing above a probability of {nothing_above:.3}, a contact unknown if at most {:.2} % of known \
         contacts are as unusual, and a category is named above a probability of {:.3}\n",
        100.0 * unknown_share,
        1.0 - cost_of_uncertain
    )
}

fn percent(share: Option<f64>) -> String {
    share.map_or("-".into(), |share| format!("{:.1}", 100.0 * share))
}

fn number(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:.3}"))
}

/// The figures of an evaluation.
pub(super) fn evaluation(figures: &TouchFigures) -> String {
    let parts = [
        verdicts(figures) + &by_reach(&figures.by_reach),
        contacts(figures),
        first_right(figures),
        probabilities(figures),
    ];
    parts.join("\n") + &outliers(figures.outliers)
}

/// What was judged by one model, and how.
pub(super) fn reaches(reaches: usize, own: &TouchDecision) -> String {
    format!("{}. {}", output::counted(reaches, "reach", "reaches"), decision(own))
}

/// How many features of each network are shown; the JSON has all.
const FEATURES_SHOWN: usize = 6;

/// What the most valuable features of each network are worth.
pub(super) fn feature_worth(worth: &[FeatureWorth]) -> String {
    let mut rows = Vec::new();
    for (index, own) in worth.iter().enumerate() {
        let rank = worth[..index].iter().filter(|other| other.network == own.network).count();
        if rank < FEATURES_SHOWN {
            let (rise, fall) = (own.log_loss_rise_nats, 100.0 * own.balanced_accuracy_fall);
            rows.push(cells![own.network, own.feature, format!("{rise:.4}"), format!("{fall:.2}")]);
        }
    }
    let header = ["network", "feature", "rise of log loss if shuffled / nats", "fall of balanced accuracy / %"];
    "\n".to_owned() + &output::table(&header, rows)
}

/// What was cross-validated.
pub(super) fn folds(reaches: usize, folds: usize) -> String {
    format!("{reaches} reaches in {folds} folds; each fold is judged by a model fitted to the others\n")
}

fn outliers(outliers: Option<OutlierFigures>) -> String {
    match outliers {
        None => {
            "Nothing of an unknown category touched the patch, so how well outliers are found is not measured\n".into()
        }
        Some(own) => format!(
            "Outliers: ROC area {:.3}; {:.1} % of {} taxel frames found at 5 % false alarms\n",
            own.roc_area,
            100.0 * own.found_at_5_percent,
            own.taxel_frames
        ),
    }
}

fn verdicts(figures: &TouchFigures) -> String {
    let rows = figures.truths.iter().map(|own| {
        let [right, wrong, uncertain, unknown] = [own.right, own.wrong, own.uncertain, own.called_unknown].map(percent);
        cells![own.truth, own.taxel_frames, right, wrong, uncertain, unknown]
    });
    let header = ["truth", "taxel frames", "right %", "wrong %", "uncertain %", "called unknown %"];
    output::table(&header, rows)
}

fn by_reach(own: &ReachFigures) -> String {
    format!(
        "Of the taxel frames of a reach that a known category presses on, on average over {}: {} % called another \
         category, {} % called unknown\n",
        output::counted(own.reaches, "reach", "reaches"),
        percent(own.wrong_category),
        percent(own.called_unknown)
    )
}

fn contacts(figures: &TouchFigures) -> String {
    let row = |(name, accuracy): (&str, Option<Accuracy>)| {
        let balanced = percent(accuracy.and_then(|own| own.balanced_accuracy));
        let [right, baseline] =
            [accuracy.map(|own| own.accuracy), accuracy.map(|own| own.majority_baseline)].map(percent);
        cells![name, accuracy.map_or(0, |own| own.trials), right, balanced, baseline]
    };
    let parts =
        [("whole contact", figures.contacts_at_end), ("first 0.1 s (10 samples)", figures.contacts_after_tenth_second)];
    let header = ["touched contacts by", "contacts", "accuracy %", "balanced accuracy %", "majority baseline %"];
    output::table(&header, parts.map(row))
}

fn first_right(figures: &TouchFigures) -> String {
    if figures.first_right_verdict.is_empty() {
        return String::new();
    }
    let rows = figures.first_right_verdict.iter().map(|own| {
        let samples = own.samples.map_or("whole contact".into(), |samples| samples.to_string());
        vec![samples, percent(Some(own.share))]
    });
    let mut text = output::table(&["samples", "contacts with a right verdict by then, %"], rows);
    if let Some(median) = figures.median_samples_until_right {
        text += &format!("Where there is a right verdict, the first comes after {median} samples (median)\n");
    }
    text
}

fn probabilities(figures: &TouchFigures) -> String {
    format!(
        "Spurious readings called nothing: {} %; true contacts lost by that: {} %\n\
         Expected calibration error {}, Brier score {}\n",
        percent(figures.spurious_called_nothing),
        percent(figures.touches_lost),
        number(figures.expected_calibration_error),
        number(figures.brier_score)
    )
}
