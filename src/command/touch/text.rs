//! Results of touch models as text.

use underbrush_classifier::evaluate::touch_folds::TouchReport;
use underbrush_classifier::evaluate::{
    Interval, ObjectVerdicts, PatchFigures, ReachFigures, StiffnessFigures, TouchFigures, UnknownFigures, share,
};
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
    let TouchDecision { nothing_above, cost_of_uncertain, .. } = decision;
    let nothing = if *nothing_above < 1.0 {
        format!("A reading is called nothing above a probability of {nothing_above:.3}")
    } else {
        "No reading is called nothing, which takes a probability above 1".into()
    };
    let unknown = called_unknown(decision, least_unknown_share);
    format!("{nothing}, {unknown}, and a category is named above a probability of {:.3}\n", 1.0 - cost_of_uncertain)
}

/// Which objects are called unknown.
fn called_unknown(decision: &TouchDecision, least_unknown_share: Option<f64>) -> String {
    let unknown_share = decision.unknown_share;
    match least_unknown_share {
        least if unknown_share >= least.unwrap_or(1.0) => format!(
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
    }
}

fn number(value: Option<f64>) -> String {
    value.map_or("-".into(), |value| format!("{value:.3}"))
}

/// A share in per cent with its interval.
fn with_interval(share: impl Into<Option<f64>>, interval: Option<Interval>) -> String {
    let interval = interval.map(|own| format!(" ({} to {})", percent(own.low), percent(own.high)));
    percent(share) + &interval.unwrap_or_default()
}

/// The verdicts on objects at one moment.
fn then<'a>(verdicts: &'a [ObjectVerdicts], at: &str) -> Option<&'a ObjectVerdicts> {
    verdicts.iter().find(|own| own.at == at)
}

fn balanced_right(own: Option<&ObjectVerdicts>) -> String {
    own.map_or("-".into(), |own| with_interval(own.balanced_right, own.right_interval))
}

/// The figures of an evaluation, and what was judged.
pub(super) fn evaluation(report: &TouchReport, least_unknown_share: Option<f64>) -> String {
    let figures = &report.figures;
    let parts = [
        objects(figures) + &unknown(&figures.unknown),
        costs(report),
        stiffness(&figures.stiffness),
        verdicts(figures) + &by_reach(&figures.by_reach),
        patches(&figures.patches),
        contacts(figures),
        right_after(figures),
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
        .column("stiffness within half to twice % (95 %)", |own| {
            with_interval(own.within_twice, own.within_twice_interval)
        })
        .column("interval holds it % (95 %)", |own| with_interval(own.held, own.held_interval))
        .number("median of told / true", 2, |own| own.median_ratio)
        .text()
}

/// What was cross-validated, or judged by one model, and how.
fn judged(report: &TouchReport, least_unknown_share: Option<f64>) -> String {
    let reaches = report.reaches;
    if let Some(folds) = report.folds {
        let unknown = match (least_unknown_share, report.decisions.last()) {
            (Some(_), Some(own)) => format!("Each model calls {}\n", called_unknown(own, least_unknown_share)),
            _ => families(&[]),
        };
        return format!(
            "\n{unknown}{reaches} reaches in {folds} folds; each fold is judged by a model fitted to the others\n"
        );
    }
    let reaches = output::counted(reaches, "reach", "reaches");
    report.decisions.iter().map(|own| format!("{reaches}. {}", decision(own, least_unknown_share))).collect()
}

/// How well unknown objects are found, and how many known ones are called unknown, by the model's own decision.
fn unknown(own: &UnknownFigures) -> String {
    let part = |part: usize, all: usize, interval: Option<Interval>, of: &str| {
        let share = if all > 0 { format!("{:.1} %", 100.0 * part as f64 / all as f64) } else { "-".into() };
        let interval = interval.map(|own| format!(", 95 %: {} to {}", percent(own.low), percent(own.high)));
        format!("{share}{of} ({part} of {all}{})", interval.unwrap_or_default())
    };
    let area = own.roc_area_interval.map(|own| format!(" (95 %: {:.3} to {:.3})", own.low, own.high));
    format!(
        "At the end found {}, called unknown {}; by contact {} and {}; ROC area {}{}\n\
         At the peak of force found {}, called unknown {}\n",
        part(own.found_objects, own.unknown_objects, own.found_interval, " of the unknown objects"),
        part(own.false_alarm_objects, own.known_objects, own.false_alarm_interval, " of the known objects"),
        part(own.found_contacts, own.unknown_contacts, own.found_contacts_interval, ""),
        part(own.false_alarm_contacts, own.known_contacts, own.false_alarm_contacts_interval, ""),
        number(own.roc_area),
        area.unwrap_or_default(),
        part(own.found_objects_at_peak, own.unknown_objects, own.found_at_peak_interval, ""),
        part(own.false_alarm_objects_at_peak, own.known_objects, own.false_alarm_at_peak_interval, "")
    )
}

/// Verdicts on known objects at some moments.
fn objects(figures: &TouchFigures) -> String {
    let rows = Rows::of(&figures.object_verdicts)
        .column("known objects at", |own| own.at)
        .column("objects", |own| own.objects)
        .column("right %, balanced (95 %)", |own| balanced_right(Some(own)))
        .percent("right %", 1, |own| own.right)
        .percent("wrong %", 1, |own| own.wrong)
        .percent("called unknown %", 1, |own| own.called_unknown);
    let grouping = figures.grouping.map_or(String::new(), |own| {
        let (groups, objects) = (output::counted(own.groups, "group", "groups"), own.true_objects);
        let purity =
            format!("{:.1} % of the force comes from the object that each group stands for", 100.0 * own.purity);
        format!("{groups} of contacts for {objects} true objects; {purity}\n")
    });
    let flips = figures.flips.map_or(String::new(), |own| {
        let objects = output::counted(own.objects, "object", "objects");
        let interval = own.without_interval.map(|own| format!(" (95 %: {} to {})", percent(own.low), percent(own.high)));
        let (without, interval) = (percent(own.without), interval.unwrap_or_default());
        format!(
            "The verdict on an object changes {:.2} times on average, and never for {without} %{interval} of {objects}; mean cost {:.3}\n",
            own.mean_flips, own.mean_cost
        )
    });
    let verdicts = if figures.object_verdicts.is_empty() { String::new() } else { rows.text() };
    verdicts + &flips + &grouping
}

/// The verdicts on known objects at other costs of an uncertain one.
fn costs(report: &TouchReport) -> String {
    let rows = report.verdicts_by_cost.iter().filter(|own| !own.object_verdicts.is_empty());
    let rows = Rows::of(rows).column("uncertain costs", |own| {
        format!("{}{}", own.cost_of_uncertain, if own.is_own { ", as decided" } else { "" })
    });
    let rows = ["0.3 s", "end"].into_iter().fold(rows, |rows, at| {
        rows.percent(format!("{at}: named %"), 1, |own| then(&own.object_verdicts, at).map(|own| own.named))
            .column("right % (95 %)", |own| balanced_right(then(&own.object_verdicts, at)))
            .percent("wrong %", 1, |own| then(&own.object_verdicts, at).map(|own| own.wrong))
    });
    if rows.things().next().is_none() {
        return String::new();
    }
    let choice = if report.folds.is_some() {
        "These reaches were held out, so the cost may be chosen by this table"
    } else {
        "Choose it on other reaches or by cross-validation, because these test the model"
    };
    format!(
        "{}Known objects; right % is balanced. --cost-of-uncertain of evaluate, classify and replay sets the cost. {choice}\n",
        rows.text()
    )
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
        .column("right % (95 %)", |own| with_interval(own.right, own.right_interval))
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

/// The patches beside each other, if there are several: shares of known objects that are right, balanced, of unknown ones that are
/// found, and of taxel frames that are right.
fn patches(figures: &[PatchFigures]) -> String {
    let [first, _, ..] = figures else { return String::new() };
    let rows = Rows::of(figures).column("patch", |own| own.patch.as_str());
    let rows = ["0.3 s", "end"].into_iter().fold(rows, |rows, at| {
        rows.column(format!("objects at {at}"), |own| then(&own.object_verdicts, at).map_or(0, |own| own.objects))
            .column("right % (95 %)", |own| balanced_right(then(&own.object_verdicts, at)))
    });
    let rows = rows.column("unknown % (95 %)", |own| {
        let own = &own.unknown;
        with_interval(share(own.found_objects, own.unknown_objects), own.found_interval)
    });
    let headings = first.truths.iter().map(|own| format!("{} frames %", own.truth));
    rows.columns(headings, |own| own.truths.iter().map(|own| percent(own.right)).collect::<Vec<_>>()).text()
}

fn contacts(figures: &TouchFigures) -> String {
    Rows::of([figures.contacts_at_end])
        .column("touched contacts", |own| own.map_or(0, |own| own.trials))
        .column("accuracy %", |own| percent(own.map(|own| own.accuracy)))
        .column("balanced accuracy % (95 %)", |own| {
            with_interval(own.and_then(|own| own.balanced_accuracy), figures.contacts_at_end_interval)
        })
        .column("majority baseline %", |own| percent(own.map(|own| own.majority_baseline)))
        .text()
}

fn right_after(figures: &TouchFigures) -> String {
    if figures.right_after_samples.is_empty() {
        return String::new();
    }
    Rows::of(&figures.right_after_samples)
        .column("n", |own| own.samples.map_or("at the end".into(), |samples| samples.to_string()))
        .column("contacts with a right verdict standing after n samples, % (95 %)", |own| {
            with_interval(own.share, own.interval)
        })
        .text()
}

fn probabilities(figures: &TouchFigures) -> String {
    let (nothing, lost) = (percent(figures.spurious_called_nothing), percent(figures.touches_lost));
    let (calibration, brier) = (number(figures.expected_calibration_error), number(figures.brier_score));
    let of_objects = number(figures.object_calibration_error);
    format!(
        "Spurious readings called nothing: {nothing} %; true contacts lost by that: {lost} %\n\
         Expected calibration error {calibration}, Brier score {brier}; of known objects at 0.3 s: expected calibration error {of_objects}\n"
    )
}
