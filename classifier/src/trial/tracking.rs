//! Tracking of connected components from frame to frame.

use underbrush_recording::{Recording, Sample};

use super::component::{Component, components, grid};
use super::image::PatchImage;
use super::trial_list::{ContactTrial, OpenTrial, TrialList, knows_truth};
use super::{TrialError, TrialOptions};
use crate::error::Fault;

/// One trial for each connected component, tracked from the start to the end of its contact (section IV-C).
///
/// Force is the largest force among the component's taxels in each frame. Motion is the length of the path of its
/// centre in the world frame since the trial started.
///
/// Components are associated with those of the previous frame by the distance between their centres in the world frame:
/// nearest pair first, each used once, and none farther apart than [`TrialOptions::association_distance_m`]. Hence:
/// * If two components merge, the one with the nearer centre continues and the other's trial ends.
/// * If a component splits, the part nearer to the old centre continues and the other starts a new trial.
/// * If a component moves farther than this limit between frames, its trial ends and a new one starts.
///
/// # Errors
/// [`TrialError`] as for [`super::taxel_trials`], and if the patch has no grid.
pub fn component_trials(recording: &Recording, options: &TrialOptions) -> Result<Vec<ContactTrial>, TrialError> {
    let reach = options.association_distance_m;
    if !reach.is_finite() || reach < 0.0 {
        let allowed = "a finite distance from 0 m";
        return Err(Fault::new("association_distance_m", reach.to_string(), allowed).into());
    }
    let mut image = PatchImage::new(&recording.layout, options.patch.as_deref(), options.threshold_n)?;
    let grid = grid(&image, options.wrap)?;
    let mut open: Vec<OpenTrial> = Vec::new();
    let mut trials = TrialList::new(recording, options, &image.patch().name);
    for (index, frame) in recording.frames.iter().enumerate() {
        image.read(frame)?;
        let found = components(&image, grid);
        let followed = associate(&open, &found, reach);
        let mut before: Vec<Option<OpenTrial>> = open.into_iter().map(Some).collect();
        open = Vec::with_capacity(found.len());
        for (component, followed) in found.iter().zip(followed) {
            let center_world = component.center_world;
            let continued = followed.and_then(|trial| before[trial].take());
            let mut trial = continued.unwrap_or_else(|| OpenTrial::new(index, component.strongest, center_world));
            let sample = Sample {
                time_s: frame.time_s,
                force_n: component.region.largest_force_n,
                motion_m: Some(trial.travel.to(center_world)),
                region: Some(component.region),
                touched: knows_truth(recording).then_some(component.touched),
                ..Sample::default()
            };
            trial.push(sample, component.object);
            open.push(trial);
        }
        for ended in before {
            trials.close(ended)?;
        }
    }
    for trial in open {
        trials.close(Some(trial))?;
    }
    Ok(trials.finish())
}

/// The trial that each component continues. Ties go to the trial, then the component, with the smaller index.
fn associate(open: &[OpenTrial], found: &[Component], reach_m: f64) -> Vec<Option<usize>> {
    let mut pairs = Vec::new();
    for (t, trial) in open.iter().enumerate() {
        for (c, component) in found.iter().enumerate() {
            let distance = trial.travel.last_world.distance(component.center_world);
            if distance <= reach_m {
                pairs.push((distance, t, c));
            }
        }
    }
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut used = vec![false; open.len()];
    let mut followed = vec![None; found.len()];
    for (_, t, c) in pairs {
        if !used[t] && followed[c].is_none() {
            used[t] = true;
            followed[c] = Some(t);
        }
    }
    followed
}
