//! Reaches from a table of contact trials, such as `underbrush import` makes of a robot's log.
//!
//! The table says which force each taxel felt at which time, and perhaps what it touched. It describes neither the arm
//! nor the positions of the taxels, so the taxels lie row by row in the order of their numbers, and nothing else is
//! shown in 3-D. It has no samples without contact either. Between contacts, frames without forces follow one another
//! at the period of the samples.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use glam::DVec3;
use underbrush_classifier::trial::TrialOptions;
use underbrush_recording::limits::{MAX_PATCHES, MAX_TAXELS};
use underbrush_recording::{
    Category, FRAME_PERIOD_S, Frame, Grid, InputError, ObjectRecord, Patch, Pose, Recording, SkinLayout, Taxel,
    TaxelReading, Trial, period_s,
};

use crate::trial_spans::{Spans, check, patch_name};
use crate::{Judging, JudgingModel};

/// Distance between neighbouring taxels, m. Choice.
const PITCH_M: f64 = 0.01;
/// The label of contacts in which nothing pressed.
const NOTHING: &str = "nothing";
/// Largest number of frames of a reach: two hours at 100 Hz. Without a limit, a gap of years between two trials would
/// fill the memory with silent frames.
const MOST_FRAMES: f64 = 720_000.0;

/// The reaches of a table, in the order of their indices.
///
/// # Errors
/// If a trial has no taxel, as one of a contact region or of a sensor without taxels; if a category has a name that a
/// recording cannot have; if there are too many patches or taxels; if a reach is too long; and if frames would change the trials.
pub fn reaches(path: &Path, trials: &[Trial]) -> Result<Vec<Recording>, InputError> {
    let layout = layout(path, trials)?;
    let objects = objects(path, trials)?;
    warn_of_weak(path, trials);
    let mut by_reach: BTreeMap<u64, Vec<&Trial>> = BTreeMap::new();
    for trial in trials {
        by_reach.entry(trial.reach.unwrap_or_default()).or_default().push(trial);
    }
    let recording = |(reach_index, trials): (u64, Vec<&Trial>)| {
        let period_s = period_s(trials.iter().copied()).unwrap_or(FRAME_PERIOD_S);
        let spans = Spans::of(&trials);
        if spans.duration_s() > MOST_FRAMES * period_s {
            let found = format!("{} s in reach {reach_index}, with a sample every {period_s} s", spans.duration_s());
            let allowed = format!("at most {MOST_FRAMES} samples from the first to the last");
            let remedy = "number the reaches in the column reach, or correct the times";
            return Err(InputError::new(path, "time_s", found, allowed, remedy));
        }
        check(path, reach_index, &trials, &spans)?;
        Ok(Recording {
            scene: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            controller: Recording::UNKNOWN_CONTROLLER.into(),
            reach_index,
            rate_hz: 1.0 / period_s,
            frames: frames(&trials, &spans, &layout, &objects, period_s),
            layout: layout.clone(),
            objects: objects.clone(),
            ..Recording::default()
        })
    };
    by_reach.into_iter().map(recording).collect()
}

/// An error unless the model needs only forces.
pub fn check_model(path: &Path, judging: &Judging) -> Result<(), InputError> {
    let found = match &judging.by {
        JudgingModel::OfTrials(model, _) => match model.classifier.features() {
            features if features.columns().iter().all(|column| *column == "force_n") => return Ok(()),
            features => format!("{} with the features {features}", judging.name),
        },
        JudgingModel::Touch(_) => format!("the touch model {}", judging.name),
    };
    let allowed = "a classifier of trials by the column force_n alone, because the replay of a table has no other channels, no \
                   motion and no neighbours of taxels";
    let remedy = "train one with --features force; to see another channel, copy it to the column force_n first";
    Err(InputError::new(path, "model", found, allowed, remedy))
}

/// Each patch with all taxels up to the largest number, and further taxels that fill its last row. Without a limit, a short table of
/// many patches would fill the memory.
fn layout(path: &Path, trials: &[Trial]) -> Result<SkinLayout, InputError> {
    let mut taxels: BTreeMap<&str, usize> = BTreeMap::new();
    for trial in trials {
        let taxel = trial.taxel.map(|taxel| taxel as usize).filter(|taxel| *taxel < MAX_TAXELS);
        let Some(taxel) = taxel else {
            let found = trial.taxel.map_or("nothing".to_owned(), |taxel| taxel.to_string());
            let allowed = format!("the number of a taxel from 0 to {}, in all trials", MAX_TAXELS - 1);
            let remedy = format!(
                "fill it in for trial {}; if the table knows no taxels, add a column taxel of zeros, and a column reach with the \
                 number of each trial",
                trial.trial
            );
            return Err(InputError::new(path, "taxel", found, allowed, remedy));
        };
        let count = taxels.entry(patch_name(trial)).or_default();
        *count = taxel.saturating_add(1).max(*count);
    }
    let (patches, all) = (taxels.len(), taxels.values().sum::<usize>());
    if patches > MAX_PATCHES || all > MAX_TAXELS {
        let allowed = format!("at most {MAX_PATCHES} patches, with {MAX_TAXELS} taxels together");
        let remedy = "correct the columns patch and taxel, or divide the table";
        return Err(InputError::new(path, "patch", format!("{patches} patches with {all} taxels"), allowed, remedy));
    }
    let patch = |(name, count): (&str, usize)| {
        let columns = (1..).find(|columns| columns * columns >= count).unwrap_or(count);
        let rows = count.div_ceil(columns);
        let taxel = |taxel: usize| Taxel {
            position_link: DVec3::new((taxel % columns) as f64, -((taxel / columns) as f64), 0.0) * PITCH_M,
            normal_link: DVec3::Z,
            tangent_link: DVec3::X,
            area_m2: PITCH_M * PITCH_M,
        };
        Patch {
            name: name.into(),
            link: name.into(),
            // Only for the map. Taxels that are neighbours here need not be neighbours on the robot, so no contact
            // region is shown.
            grid: Some(Grid { rows, columns, wraps: false }),
            taxels: (0..rows * columns).map(taxel).collect(),
        }
    };
    Ok(SkinLayout { patches: taxels.into_iter().map(patch).collect() })
}

/// One object for each category but [`NOTHING`], which has none.
fn objects(path: &Path, trials: &[Trial]) -> Result<Vec<ObjectRecord>, InputError> {
    let names = trials.iter().filter_map(|trial| trial.category.as_deref());
    let names: BTreeSet<&str> = names.filter(|name| *name != NOTHING).collect();
    let mut codes = (0..=i8::MAX).filter(|code| !Category::BUILT_IN.iter().any(|known| known.code() == *code));
    let object = |name: &str| {
        let category = Category::from_name(name).or_else(|| Category::from_file(name, codes.next()?));
        let category = category.ok_or_else(|| {
            let allowed = "at most 124 names of up to 24 lower-case letters, digits and underscores that begin with a \
                           letter, and not none, uncertain or unknown";
            InputError::new(path, "category", name, allowed, "rename the category")
        })?;
        Ok(ObjectRecord { kind: name.into(), category, position_world: DVec3::ZERO, parameters: BTreeMap::new() })
    };
    names.into_iter().map(object).collect()
}

/// Warns of trials with forces that are no contact on the page.
fn warn_of_weak(path: &Path, trials: &[Trial]) {
    let threshold_n = TrialOptions::default().threshold_n;
    let is_weak = |trial: &&Trial| trial.samples.iter().any(|sample| sample.force_n <= threshold_n);
    let (weak, all, path) = (trials.iter().filter(is_weak).count(), trials.len(), path.display());
    if weak > 0 {
        log::warn!(
            "warning: {path}: {weak} of {all} trials have forces of {threshold_n} N or less, which are no contact on the page: such \
             a trial is shown in several parts, or not at all"
        );
    }
}

/// One frame for each time at which there is a sample, and frames without forces between contacts. Times begin
/// at 0.
fn frames(
    trials: &[&Trial],
    spans: &Spans,
    layout: &SkinLayout,
    objects: &[ObjectRecord],
    period_s: f64,
) -> Vec<Frame> {
    let mut readings: Vec<(f64, TaxelReading)> = Vec::new();
    for trial in trials {
        let patch = layout.patch_index(patch_name(trial)).unwrap_or_default() as u16;
        let object = objects.iter().position(|object| Some(object.kind.as_str()) == trial.category.as_deref());
        readings.extend(trial.samples.iter().map(|sample| {
            let reading = TaxelReading {
                patch,
                taxel: trial.taxel.unwrap_or_default() as u16,
                sensed_force_n: sample.force_n,
                object: object.map(|object| object as u16),
                ..TaxelReading::default()
            };
            (sample.time_s, reading)
        }));
    }
    readings.sort_by(|(a_s, a), (b_s, b)| a_s.total_cmp(b_s).then((a.patch, a.taxel).cmp(&(b.patch, b.taxel))));
    let start_s = readings.first().map_or(0.0, |(time_s, _)| *time_s);
    let frame = |time_s: f64, taxels: Vec<TaxelReading>| Frame {
        time_s: time_s - start_s,
        // The map shows the row nearest to the hand at the top.
        end_effector_pose_world: Pose::from_position(PITCH_M * DVec3::Y),
        taxels,
        ..Frame::blank(layout.patches.len())
    };
    let mut frames = Vec::new();
    let mut groups = readings.chunk_by(|(a_s, _), (b_s, _)| a_s == b_s).peekable();
    while let Some(group) = groups.next() {
        let time_s = group[0].0;
        frames.push(frame(time_s, group.iter().map(|(_, reading)| *reading).collect()));
        if !spans.go_on_after(time_s) {
            // At least one before the next contact, which may be of the same taxel.
            let next_s = groups.peek().map_or(time_s + 2.0 * period_s, |next| next[0].0);
            let silent = ((next_s - time_s) / period_s - 0.5).floor().max(1.0);
            let step_s = period_s.min(0.5 * (next_s - time_s));
            frames.extend((1..=silent as usize).map(|step| frame(time_s + step as f64 * step_s, Vec::new())));
        }
    }
    frames
}
