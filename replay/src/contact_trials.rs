//! The contact trials of all patches, as sections.

use underbrush_classifier::trial::{TrialError, TrialOptions, taxel_trials};
use underbrush_recording::Recording;

use crate::container::{Sections, first_taxels};

/// Adds the contact trials of every taxel, sorted by patch, then first frame. The sections `trial_*` have one number
/// per trial, and the sections `sample_*` one per sample, which is one per frame of the trial. Trials that end before
/// frame `from`, and samples before it, are left out.
///
/// # Errors
/// If a frame does not fit the skin.
pub fn add(recording: &Recording, threshold_n: f64, from: usize, sections: &mut Sections) -> Result<(), TrialError> {
    let (mut taxels, mut firsts, mut starts, mut objects) = (Vec::new(), Vec::new(), vec![0], Vec::new());
    let (mut motions, mut regions, mut region_sums) = (Vec::new(), Vec::new(), Vec::new());
    for (patch, first_taxel) in recording.layout.patches.iter().zip(first_taxels(&recording.layout)) {
        let options = TrialOptions { patch: Some(patch.name.clone()), threshold_n, ..TrialOptions::default() };
        for contact in taxel_trials(recording, &options)? {
            let samples = &contact.trial.samples;
            let Some(first) = samples.first() else { continue };
            // Times of samples are copied from frames, whose times rise.
            let frame = recording.frames.partition_point(|frame| frame.time_s < first.time_s);
            let known = from.saturating_sub(frame);
            if known >= samples.len() {
                continue;
            }
            taxels.push(first_taxel + contact.trial.taxel.unwrap_or_default());
            firsts.push(frame as u32);
            objects.push(contact.object.map_or(-1, |object| object as i16));
            for sample in &samples[known..] {
                // Without joints, as in a table of trials, it is unknown how the skin moved and which taxels are
                // neighbours.
                let has_arm = !recording.joint_names.is_empty();
                let region = sample.region.filter(|_| has_arm);
                motions.push(sample.motion_m.filter(|_| has_arm).unwrap_or(f64::NAN));
                regions.push(region.map_or(0, |region| region.taxels as u16));
                region_sums.push(region.map_or(f64::NAN, |region| region.force_sum_n));
            }
            starts.push(motions.len() as u32);
        }
    }
    sections.add("trial_taxel", taxels);
    sections.add("trial_first_frame", firsts);
    sections.add("trial_object", objects);
    sections.add("trial_sample_start", starts);
    sections.add_single("sample_motion_m", motions);
    sections.add("sample_region_taxels", regions);
    sections.add_single("sample_region_force_n", region_sums);
    Ok(())
}
