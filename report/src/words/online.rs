//! What the numbers say about verdicts while the arm moves.

use underbrush_classifier::decision::Rule;

use underbrush_experiments::data::FAILING_UNCERTAIN_SHARE;
use underbrush_experiments::online::{CHOSEN, Detection};
use underbrush_experiments::thresholds::Thresholds;

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
        } => format!("uncertain below a margin of {uncertain_below:.1} nats, a category above {category_above:.1}"),
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
        "These thresholds were chosen from {} training trials held out by reach, for a false-positive rate of {} and an \
         outlier prior of {}: {rule}. On these trials, {}; {:.1} % are uncertain and {:.1} % are called outliers though none \
         is.",
        chosen.trials,
        chosen.targets.false_positive_rate,
        chosen.targets.outlier_prior,
        rates.join(", "),
        100.0 * chosen.uncertain,
        100.0 * chosen.outlier
    )
}

/// How many taxel frames of the outlier reaches the chosen thresholds leave undecided, and whether they fail.
pub fn chosen_rule_online(detection: &[Detection]) -> Option<String> {
    let chosen: Vec<&Detection> = detection.iter().filter(|row| row.rule.starts_with(CHOSEN)).collect();
    let frames: usize = chosen.iter().map(|row| row.taxel_frames).sum();
    if frames == 0 {
        return None;
    }
    let uncertain = chosen.iter().map(|row| row.uncertain_percent * row.taxel_frames as f64);
    let percent = uncertain.sum::<f64>() / frames as f64;
    let found =
        format!("Used frame by frame on the outlier reaches, the chosen thresholds leave {percent:.1} % uncertain");
    Some(if percent > 100.0 * FAILING_UNCERTAIN_SHARE {
        format!(
            "{found}: the rule fails there. Its thresholds are margins of whole trials, and a margin grows with every sample, so \
             a contact that still lasts seldom reaches them."
        )
    } else {
        format!("{found}.")
    })
}

/// How well the roll is found by its small margin, whatever the threshold.
pub fn roc(area: f64) -> String {
    let worth = match area {
        _ if area > 0.55 => "better than",
        _ if area < 0.45 => "worse than",
        _ => "about as good as",
    };
    format!(
        "A trial of the roll has a smaller margin than one of leaf or trunk with a probability of {area:.3}, the area under its \
         curve: {worth} chance, which is 0.5."
    )
}
