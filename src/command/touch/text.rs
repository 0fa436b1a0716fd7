//! Results of touch models as text.

use underbrush_classifier::evaluate::touch_folds::TouchReport;
use underbrush_classifier::evaluate::{Interval, ReachFigures, StiffnessFigures, TouchFigures, UnknownFigures};
use underbrush_classifier::touch::{TouchDecision, TouchRows};
use underbrush_report::drawing::Rows;

use crate::output::{self, percent};

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

/// When each verdict is given, by a model that needs this unknown share to call anything unknown; `None` if none is enough.
pub(super) fn decision(decision: &TouchDecision, least_unknown_share: Option<f64>) -> String {
    let TouchDecision { nothing_above, unknown_share, cost_of_uncertain } = decision;
    let nothing = if *nothing_above < 1.0 {
        format!("A reading is called nothing above a probability of {nothing_above:.3}")
    } else {
        "No reading is called nothing, which takes a probability above 1".into()
    };
    let unknown = match least_unknown_share {
        least if *unknown_share >= least.unwrap_or(1.0) => format!(
            "an object unknown if at most {:.2} % of the known objects are as unusual, or a fifth of that in its first 0.6 s",
            100.0 * unknown_share
        ),
        None => "no object unknown, because no auxiliary sets were trained on".into(),
        Some(least) => {
            let least = (1000.0 * least).ceil() / 1000.0;
            format!(
                "no object unknown, because with these training data that takes an --unknown-share of {least} or more"
            )
        }
    };
    format!("{nothing}, {unknown}, and a category is named above a probability of {:.3}\n", 1.0 - cost_of_uncertain)
}

fn number(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:.3}"))
}

/// The figures of an evaluation, and what was judged.
pub(super) fn evaluation(report: &TouchReport, least_unknown_share: Option<f64>) -> String {
    let figures = &report.figures;
    let parts = [
        objects(figures) + &unknown(&figures.unknown),
        stiffness(&figures.stiffness),
        verdicts(figures) + &by_reach(&figures.by_reach),
        contacts(figures),
        first_right(figures),
        probabilities(figures),
    ];
    parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("\n")
        + &judged(report, least_unknown_share)
}

/// How well the stiffness of objects is told.
fn stiffness(figures: &[StiffnessFigures]) -> String {
    if figures.is_empty() {
        return String::new();
    }
    Rows::of(figures)
        .column("gave way under 3 N or more", |own| own.truth.as_str())
        .column("objects", |own| own.objects)
        .percent("stiffness within half to twice %", 0, |own| own.within_twice)
        .percent("interval holds it %", 0, |own| own.held)
        .number("median of told / true", 2, |own| own.median_ratio)
        .text()
}

/// What was cross-validated, or judged by one model, and how.
fn judged(report: &TouchReport, least_unknown_share: Option<f64>) -> String {
    let reaches = report.reaches;
    if let Some(folds) = report.folds {
        let unknown = families(&[]);
        return format!(
            "\n{unknown}{reaches} reaches in {folds} folds; each fold is judged by a model fitted to the others\n"
        );
    }
    let reaches = output::counted(reaches, "reach", "reaches");
    report.decisions.iter().map(|own| format!("{reaches}. {}", decision(own, least_unknown_share))).collect()
}

/// How well unknown objects are found, by the model's own decision.
fn unknown(own: &UnknownFigures) -> String {
    let objects = |part: usize, all: usize, interval: Option<Interval>| {
        let share = if all > 0 { format!("{:.1} %", 100.0 * part as f64 / all as f64) } else { "-".into() };
        let interval = interval.map(|own| format!(", 95 %: {:.1} to {:.1}", 100.0 * own.low, 100.0 * own.high));
        format!("{share} ({part} of {all}{})", interval.unwrap_or_default())
    };
    format!(
        "Unknown objects: {} found at the end, {} at the peak of force; by contact {}\n\
         Known objects: {} called unknown; by contact {}. ROC area of unknown against known objects {}\n",
        objects(own.found_objects, own.unknown_objects, own.found_interval),
        objects(own.found_objects_at_peak, own.unknown_objects, None),
        objects(own.found_contacts, own.unknown_contacts, own.found_contacts_interval),
        objects(own.false_alarm_objects, own.known_objects, own.false_alarm_interval),
        objects(own.false_alarm_contacts, own.known_contacts, own.false_alarm_contacts_interval),
        number(own.roc_area)
    )
}

/// Verdicts on known objects at some moments.
fn objects(figures: &TouchFigures) -> String {
    let rows = Rows::of(&figures.object_verdicts)
        .column("known objects at", |own| own.at)
        .column("objects", |own| own.objects)
        .percent("right %, balanced", 1, |own| own.balanced_right)
        .percent("right %", 1, |own| own.right)
        .percent("wrong %", 1, |own| own.wrong)
        .percent("called unknown %", 1, |own| own.called_unknown);
    let grouping = figures.grouping.map_or(String::new(), |own| {
        let (groups, objects) = (output::counted(own.groups, "group", "groups"), own.true_objects);
        let purity =
            format!("{:.1} % of the force comes from the object that each group stands for", 100.0 * own.purity);
        format!("{groups} of contacts for {objects} true objects; {purity}\n")
    });
    if figures.object_verdicts.is_empty() { grouping } else { rows.text() + &grouping }
}

/// The families of unknown objects that a model was trained on.
pub(super) fn families(families: &[&str]) -> String {
    match families {
        [] => "Trained without --auxiliary, so nothing is called unknown: objects of other categories are taken for known \
               ones\n"
            .into(),
        _ => format!("Finds unknown objects like those of {}\n", families.join(", ")),
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
    let reaches = output::counted(own.reaches, "reach", "reaches");
    let (wrong, unknown) = (percent(own.wrong_category), percent(own.called_unknown));
    format!(
        "Of the taxel frames of a reach that a known category presses on, on average over {reaches}: {wrong} % called another \
         category, {unknown} % called unknown\n"
    )
}

fn contacts(figures: &TouchFigures) -> String {
    Rows::of([("whole contact", figures.contacts_at_end), ("first 10 samples", figures.contacts_after_tenth_second)])
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
    let (nothing, lost) = (percent(figures.spurious_called_nothing), percent(figures.touches_lost));
    let (calibration, brier) = (number(figures.expected_calibration_error), number(figures.brier_score));
    format!(
        "Spurious readings called nothing: {nothing} %; true contacts lost by that: {lost} %\n\
         Expected calibration error {calibration}, Brier score {brier}\n"
    )
}
