//! Results of touch models as text.

use underbrush_classifier::evaluate::{OutlierFigures, ReachFigures, TouchFigures};
use underbrush_classifier::touch::{FeatureWorth, TouchDecision, TouchRows};
use underbrush_report::drawing::Rows;

use crate::output;

/// What a model was fitted to.
pub(super) fn rows(rows: &TouchRows) -> String {
    let taxels = [
        ("taxels, touched".to_owned(), rows.touched_taxels),
        ("taxels, nothing on them".to_owned(), rows.untouched_taxels),
    ];
    let regions = rows.regions.iter().map(|(category, count)| (format!("regions, {category}"), *count));
    let counts: Vec<(String, usize)> = taxels.into_iter().chain(regions).collect();
    format!(
        "Classifier touch\n{}From {}. Probabilities are calibrated on reaches that were held out: in {} parts, each \
         judged by networks fitted to the others\n",
        Rows::of(&counts).column("rows", |own| own.0.as_str()).column("count", |own| own.1).text(),
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
    let of_network = |own: &FeatureWorth, before: &[FeatureWorth]| {
        before.iter().filter(|other| other.network == own.network).count() < FEATURES_SHOWN
    };
    let shown = worth.iter().enumerate().filter(|(index, own)| of_network(own, &worth[..*index]));
    let rows = Rows::of(shown.map(|(_, own)| own))
        .column("network", |own| own.network)
        .column("feature", |own| own.feature)
        .number("rise of log loss if shuffled / nats", 4, |own| own.log_loss_rise_nats)
        .percent("fall of balanced accuracy / %", 2, |own| own.balanced_accuracy_fall);
    format!("\n{}", rows.text())
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
    Rows::of(&figures.truths)
        .column("truth", |own| own.truth.as_str())
        .column("taxel frames", |own| own.taxel_frames)
        .column("right %", |own| percent(own.right))
        .column("wrong %", |own| percent(own.wrong))
        .column("uncertain %", |own| percent(own.uncertain))
        .column("called unknown %", |own| percent(own.called_unknown))
        .text()
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
    let parts =
        [("whole contact", figures.contacts_at_end), ("first 0.1 s (10 samples)", figures.contacts_after_tenth_second)];
    Rows::of(parts)
        .column("touched contacts by", |(name, _)| name)
        .column("contacts", |(_, own)| own.map_or(0, |own| own.trials))
        .column("accuracy %", |(_, own)| percent(own.map(|own| own.accuracy)))
        .column("balanced accuracy %", |(_, own)| percent(own.and_then(|own| own.balanced_accuracy)))
        .column("majority baseline %", |(_, own)| percent(own.map(|own| own.majority_baseline)))
        .text()
}

fn first_right(figures: &TouchFigures) -> String {
    if figures.first_right_verdict.is_empty() {
        return String::new();
    }
    let mut text = Rows::of(&figures.first_right_verdict)
        .column("samples", |own| own.samples.map_or("whole contact".into(), |samples| samples.to_string()))
        .percent("contacts with a right verdict by then, %", 1, |own| own.share)
        .text();
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
