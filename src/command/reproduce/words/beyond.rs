//! What the numbers say beyond the paper's own tables and figures.

use underbrush_classifier::decision::Rule;

use super::super::ablation::AS_IS;
use super::super::classifiers::PAPER_BEST;
use super::super::results::Results;
use super::super::splits::Split;
use super::super::thresholds::Thresholds;

/// What thresholds were chosen, and what they do on held-out trials.
pub fn thresholds(thresholds: &Thresholds) -> String {
    let chosen = match &thresholds.chosen {
        Ok(chosen) => chosen,
        Err(why) => return format!("No thresholds could be chosen from the training data: {why}."),
    };
    let rule = match chosen.decision.rule {
        Rule::OutlierBand {
            uncertain_below,
            category_above,
        } => format!("uncertain below a lead of {uncertain_below:.1} nats, a category above {category_above:.1}"),
        other => format!("{other:?}"),
    };
    let rates: Vec<String> = chosen
        .false_positive_rate
        .iter()
        .map(|(category, rate)| {
            let found = chosen.true_positive_rate.get(category).copied().unwrap_or(f64::NAN);
            format!(
                "{category}: {:.1} % of its own trials found, {:.1} % of the others'",
                100.0 * found,
                100.0 * rate
            )
        })
        .collect();
    format!(
        "Chosen from {} training trials held out by reach, for a false-positive rate of {} and an outlier prior of {}: \
         {rule}. On these trials, {}; {:.1} % uncertain, {:.1} % called outliers though none is.",
        chosen.trials,
        chosen.targets.false_positive_rate,
        chosen.targets.outlier_prior,
        rates.join(", "),
        100.0 * chosen.uncertain,
        100.0 * chosen.outlier
    )
}

/// The best classifier against the paper's best figure and against the hidden Markov models on the same trials.
pub fn classifiers(results: &Results) -> String {
    let best = results
        .classifiers
        .iter()
        .max_by(|a, b| a.accuracy.total_cmp(&b.accuracy));
    let (Some(best), Some(first)) = (best, results.classifiers.first()) else {
        return "No classifier was compared.".into();
    };
    let against = match () {
        () if best.low > PAPER_BEST => "its whole interval is above",
        () if best.high < PAPER_BEST => "its whole interval is below",
        () => "its interval includes",
    };
    let one = format!(
        "The best on whole trials is {} with {:.1} % ({:.1} to {:.1}): {against} the paper's best of {PAPER_BEST} %, and it is \
         {:+.1} points from {} on the same trials and folds.",
        best.classifier,
        best.accuracy,
        best.low,
        best.high,
        best.accuracy - first.accuracy,
        first.classifier
    );
    [Some(one), of_many(results)]
        .into_iter()
        .flatten()
        .collect::<Vec<_>>()
        .join(" ")
}

/// The best classifier in the mean of many campaigns, which are independent of each other.
fn of_many(results: &Results) -> Option<String> {
    let campaigns = results.campaigns.as_ref()?;
    let best = campaigns
        .classifiers
        .iter()
        .max_by(|a, b| a.accuracy.total_cmp(&b.accuracy))?;
    let count = campaigns.seeds.len();
    let error = best.standard_deviation? / (count as f64).sqrt();
    Some(format!(
        "Over {count} campaigns {} has {:.1} % on average, {:+.1} points from the paper's best, with a standard error of \
         {error:.1} points.",
        best.classifier,
        best.accuracy,
        best.accuracy - PAPER_BEST
    ))
}

/// How each classifier fares where it learned, and elsewhere.
pub fn splits(results: &Results) -> Vec<String> {
    let mean = |splits: &[&Split]| splits.iter().map(|split| split.accuracy).sum::<f64>() / splits.len() as f64;
    let sentence = |classifier: &str| {
        let own = results.splits.iter().filter(|split| split.classifier == classifier);
        let (same, other): (Vec<&Split>, Vec<&Split>) = own.partition(|split| split.trained == split.tested);
        let lowest = other.iter().min_by(|a, b| a.accuracy.total_cmp(&b.accuracy))?;
        // Against the classifier that learned where this one is tested.
        let covered = |split: &&&Split| {
            let native = same.iter().find(|native| native.tested == split.tested);
            native.is_some_and(|native| (native.low..=native.high).contains(&split.accuracy))
        };
        Some(format!(
            "{classifier}: {:.1} % on average at the setting that was learned, {:.1} % at others ({:+.1} points); {} of {} \
             others are within the interval of what learned at that setting itself. Lowest: learned at {}, tested at {}, \
             {:.1} % ({:.1} to {:.1}).",
            mean(&same),
            mean(&other),
            mean(&other) - mean(&same),
            other.iter().filter(covered).count(),
            other.len(),
            lowest.trained,
            lowest.tested,
            lowest.accuracy,
            lowest.low,
            lowest.high
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
