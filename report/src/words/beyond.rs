//! What the numbers say beyond the paper's own tables and figures.

use underbrush_classifier::evaluate::AccuracyBySamples;

use underbrush_experiments::ablation::AS_IS;
use underbrush_experiments::accuracy::Spread;
use underbrush_experiments::classifiers::{
    LOGISTIC_REGION, LOGISTIC_TAXEL, MARKOV_FORCE, MARKOV_FORCE_AND_MOTION, PAPER_BEST,
};
use underbrush_experiments::results::Results;
use underbrush_experiments::splits::Split;

pub const LASTING_CONTACTS: &str = "20 samples or more";
pub const ALL_CONTACTS: &str = "all";

/// The best classifier against the paper's best figure, and the classifiers that see the same against each other.
pub fn classifiers(results: &Results) -> String {
    let accuracies: Vec<(&str, f64)> = results
        .classifiers
        .iter()
        .map(|own| (own.classifier, own.accuracy.accuracy))
        .collect();
    let best = results
        .classifiers
        .iter()
        .max_by(|a, b| a.accuracy.accuracy.total_cmp(&b.accuracy.accuracy));
    let Some(best) = best else {
        return "No classifier was compared.".into();
    };
    let own = &best.accuracy;
    let against = match () {
        () if own.low > PAPER_BEST => "its whole interval is above",
        () if own.high < PAPER_BEST => "its whole interval is below",
        () => "its interval includes",
    };
    let one = format!(
        "The best on whole trials is {} with {:.1} % ({:.1} to {:.1}, balanced {:.1} %, majority baseline {:.1} %): \
         {against} the paper's best of {PAPER_BEST} %. {}",
        best.classifier,
        own.accuracy,
        own.low,
        own.high,
        own.balanced_accuracy,
        own.majority_baseline,
        like_with_like(&accuracies)
    );
    [Some(one), of_many(results)]
        .into_iter()
        .flatten()
        .collect::<Vec<_>>()
        .join(" ")
}

/// Sets those against each other that see the same, and says what more is worth.
fn like_with_like(accuracies: &[(&str, f64)]) -> String {
    let of = |name: &str| {
        let own = accuracies.iter().find(|(own, _)| *own == name);
        own.map_or(f64::NAN, |(_, accuracy)| *accuracy)
    };
    let (force, motion) = (of(MARKOV_FORCE), of(MARKOV_FORCE_AND_MOTION));
    let (taxel, region) = (of(LOGISTIC_TAXEL), of(LOGISTIC_REGION));
    format!(
        "Seeing the same, force and motion of one taxel, logistic regression has {taxel:.1} % and the hidden Markov models \
         {motion:.1} % ({:+.1} points). Seeing force alone, the hidden Markov models have {force:.1} %. The contact region \
         changes logistic regression by {:+.1} points, to {region:.1} %.",
        taxel - motion,
        region - taxel
    )
}

/// The best classifier in the mean of many campaigns, which are independent of each other.
fn of_many(results: &Results) -> Option<String> {
    let campaigns = results.campaigns.as_ref()?;
    let best = campaigns
        .classifiers
        .iter()
        .max_by(|a, b| a.figures.accuracy.mean.total_cmp(&b.figures.accuracy.mean))?;
    let count = campaigns.seeds.len();
    let Spread {
        mean,
        standard_deviation,
        ..
    } = best.figures.accuracy;
    let error = standard_deviation? / (count as f64).sqrt();
    let means: Vec<(&str, f64)> = campaigns
        .classifiers
        .iter()
        .map(|own| (own.classifier.as_str(), own.figures.accuracy.mean))
        .collect();
    Some(format!(
        "Over {count} campaigns {} has {mean:.1} % on average (balanced {:.1} %, majority baseline {:.1} %), {:+.1} points \
         from the paper's best, with a standard error of {error:.1} points. {}",
        best.classifier,
        best.figures.balanced_accuracy.mean,
        best.figures.majority_baseline.mean,
        mean - PAPER_BEST,
        like_with_like(&means)
    ))
}

/// How far accuracy after a few samples depends on knowing that a contact goes on.
pub fn speeds(results: &Results) -> String {
    let after = |points: &[AccuracyBySamples], samples| {
        let own = points.iter().find(|point| point.samples == samples);
        own.map_or(f64::NAN, |point| 100.0 * point.accuracy)
    };
    let counts = |points: &[AccuracyBySamples]| points.last().map_or(0, |point| point.lasting);
    let Some(first) = results.speeds.first() else {
        return "No classifier was compared.".into();
    };
    let rows: Vec<String> = results
        .speeds
        .iter()
        .map(|speed| {
            let (lasting, all) = (&speed.lasting_contacts, &speed.all_contacts);
            format!(
                "{}: {:.1} % and {:.1} % after 12 samples, {:.1} % and {:.1} % at the end",
                speed.classifier,
                after(lasting, Some(12)),
                after(all, Some(12)),
                after(lasting, None),
                after(all, None)
            )
        })
        .collect();
    format!(
        "{} contacts last 20 samples or more, of {} in all. Accuracy on the longer ones and on all: {}.",
        counts(&first.lasting_contacts),
        counts(&first.all_contacts),
        rows.join("; ")
    )
}

/// How each classifier fares where it learned, and elsewhere.
pub fn splits(results: &Results) -> Vec<String> {
    let sum = |splits: &[&Split]| splits.iter().map(|split| split.accuracy.accuracy).sum::<f64>();
    let mean = |splits: &[&Split]| sum(splits) / splits.len() as f64;
    let sentence = |classifier: &str| {
        let own = results.splits.iter().filter(|split| split.classifier == classifier);
        let (same, other): (Vec<&Split>, Vec<&Split>) = own.partition(|split| split.trained == split.tested);
        let lowest = other
            .iter()
            .min_by(|a, b| a.accuracy.accuracy.total_cmp(&b.accuracy.accuracy))?;
        // Against the classifier that learned where this one is tested.
        let covered = |split: &&&Split| {
            let native = same.iter().find(|native| native.tested == split.tested);
            native.is_some_and(|native| (native.accuracy.low..=native.accuracy.high).contains(&split.accuracy.accuracy))
        };
        Some(format!(
            "{classifier}: {:.1} % on average at the setting that was learned, {:.1} % at others ({:+.1} points); {} of {} \
             others are within the interval of what learned at that setting itself. Lowest: learned at {}, tested at {}, \
             {:.1} % ({:.1} to {:.1}, majority baseline {:.1} %).",
            mean(&same),
            mean(&other),
            mean(&other) - mean(&same),
            other.iter().filter(covered).count(),
            other.len(),
            lowest.trained,
            lowest.tested,
            lowest.accuracy.accuracy,
            lowest.accuracy.low,
            lowest.accuracy.high,
            lowest.accuracy.majority_baseline
        ))
    };
    results.split_classifiers().into_iter().filter_map(sentence).collect()
}

/// What the changes do to the distance from the paper.
pub fn ablation(results: &Results) -> String {
    let (as_is, changed): (Vec<_>, Vec<_>) = results.ablation.iter().partition(|row| row.change == AS_IS);
    let Some(as_is) = as_is.first() else {
        return "Left out of a quick run, which has too few reaches to be compared with the paper's.".into();
    };
    let own = as_is.mean_absolute_difference_points;
    let rows: Vec<String> = changed
        .iter()
        .map(|row| {
            let moved = row.mean_absolute_difference_points - own;
            format!(
                "{}: {:.1} points ({moved:+.1}), {} of {} orderings hold",
                row.change, row.mean_absolute_difference_points, row.orderings_holding, row.orderings
            )
        })
        .collect();
    let nearer = changed
        .iter()
        .filter(|row| row.mean_absolute_difference_points < own)
        .count();
    format!(
        "As it is, the twelve cells differ from the paper's by {own:.1} points on average, and {} of {} orderings hold. With \
         one thing changed, {}. Of the {} changes {nearer} come nearer to the paper than what is used here. This is one \
         campaign; how far chance alone moves a cell is told by the intervals of Table I.",
        as_is.orderings_holding,
        as_is.orderings,
        rows.join("; "),
        changed.len()
    )
}
