//! Ranges of the numbers in an experiment file.

use underbrush_classifier::recipe::STATES;
use underbrush_recording::InputError;
use underbrush_recording::limits::short;
use underbrush_sim::scene::{RobotSection, limits};

use super::file::{ClassifierEntry, ExperimentFile, Setting, ThresholdSection};
use crate::source::Source;

/// Checks the numbers of states, the thresholds and the settings.
pub fn check_limits(file: &ExperimentFile, source: &Source) -> Result<(), InputError> {
    if let Some(states) = file.states.iter().find(|states| !STATES.hold(**states as f64)) {
        let found = states.to_string();
        let field = source.field("states", &found);
        return Err(field.fault(found, format!("numbers from {STATES}")));
    }
    check_thresholds(&file.thresholds, source)?;
    for setting in &file.settings {
        check_setting(setting, source)?;
    }
    for entry in file.classifiers.iter().chain(&file.setting_classifiers) {
        check_classifier(entry, source)?;
    }
    Ok(())
}

fn check_thresholds(thresholds: &ThresholdSection, source: &Source) -> Result<(), InputError> {
    let margin = thresholds.uncertain_below_nats;
    let rate = thresholds.false_positive_rate;
    let prior = thresholds.outlier_prior;
    for (name, value, holds, allowed) in [
        ("thresholds.uncertain_below_nats", margin, margin.is_finite() && margin >= 0.0, "a finite number from 0"),
        ("thresholds.false_positive_rate", rate, rate > 0.0 && rate < 1.0, "a share over 0 and under 1"),
        ("thresholds.outlier_prior", prior, (0.0..0.5).contains(&prior), "a share from 0 and under 0.5"),
    ] {
        if !holds {
            return Err(source.number(name, value).fault(short(value), allowed));
        }
    }
    Ok(())
}

/// Checks the arm of a setting as a scene file's `[robot]`, which it replaces.
fn check_setting(setting: &Setting, source: &Source) -> Result<(), InputError> {
    // All keys are named here, so that no later one can be forgotten.
    let RobotSection { stiffness_scale, hand_speed_scale, force_limit_scale } = setting.robot;
    for (key, value, range) in [
        ("stiffness_scale", stiffness_scale, limits::STIFFNESS_SCALE),
        ("hand_speed_scale", hand_speed_scale, limits::HAND_SPEED_SCALE),
        ("force_limit_scale", force_limit_scale, limits::FORCE_LIMIT_SCALE),
    ] {
        if !range.hold(value) {
            let field = source.number(&format!("settings.robot.{key}"), value);
            return Err(field.fault(short(value), range.to_string()));
        }
    }
    Ok(())
}

/// Whether an entry describes hidden Markov models, which follow the experiment's recipe.
pub fn is_hmm(entry: &ClassifierEntry) -> bool {
    entry.method.name == "hmm"
}

fn check_classifier(entry: &ClassifierEntry, source: &Source) -> Result<(), InputError> {
    match entry.states {
        Some(states) if !STATES.hold(states as f64) || !is_hmm(entry) => {
            let found = states.to_string();
            let field = source.field("classifiers.states", &found);
            Err(field.fault(found, format!("a number from {STATES}, for hmm alone")))
        }
        _ => Ok(()),
    }
}
