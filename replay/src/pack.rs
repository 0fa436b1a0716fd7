//! A reach as bytes for the page.
//!
//! Forces, angles and positions are stored in single precision, in the units of the data set. The poses of bodies are
//! those that the recording stores. Taxels are numbered through all patches. `replay/page/src/reach.ts` reads what is
//! written here.

use serde::ser::SerializeMap;
use serde::{Serialize, Serializer};
use serde_json::{Value, json};
use underbrush_classifier::trial::{TrialError, TrialOptions, taxel_trials};
use underbrush_recording::{Body, Contact, Fault, Frame, Patch, Pose, Recording, SkinLayout};

use crate::container::{MAX_BYTES, Sections, first_taxels, starts};
use crate::judging::unjudged;
use crate::verdicts::VerdictHeader;
use crate::{Judging, ReplayContext, Verdicts};

/// What the page reads of a reach before its arrays.
struct Header<'a> {
    recording: &'a Recording,
    known: &'a ReplayContext,
    verdicts: Option<&'a VerdictHeader>,
    threshold_n: f64,
    from: usize,
}

impl Serialize for Header<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Header { recording, known, verdicts, threshold_n, from } = self;
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("scene", &recording.scene)?;
        map.serialize_entry("controller", &recording.controller)?;
        // As text, because JavaScript's numbers have 53 bits.
        map.serialize_entry("seed", &recording.seed.to_string())?;
        map.serialize_entry("reach_index", &recording.reach_index)?;
        map.serialize_entry("rate_hz", &recording.rate_hz)?;
        // The number of the first frame whose rows are here, and the number of frames from the start of the reach.
        map.serialize_entry("from", from)?;
        map.serialize_entry("frames", &recording.frames.len())?;
        map.serialize_entry("outcome", &recording.outcome())?;
        map.serialize_entry("goal_outcomes", &recording.goal_outcomes())?;
        map.serialize_entry("safety_stop", &recording.safety_stop())?;
        // What does not change while a reach runs.
        if *from == 0 {
            map.serialize_entry("joint_names", &recording.joint_names)?;
            map.serialize_entry("patches", &patches(&recording.layout))?;
            map.serialize_entry("objects", &recording.objects)?;
            map.serialize_entry("bodies", &recording.bodies)?;
        }
        map.serialize_entry("goals", &recording.goals)?;
        // A contact that lasted until the frame before `from` may have gone on.
        let goes_on = |contact: &&Contact| contact.last_frame as usize + 1 >= *from;
        map.serialize_entry("contacts", &recording.contacts.iter().filter(goes_on).collect::<Vec<_>>())?;
        map.serialize_entry("map", &recording.map)?;
        map.serialize_entry("audit", &recording.audit)?;
        map.serialize_entry("audit_warnings", &(known.audit_warnings)(&recording.audit, &recording.layout))?;
        // The controller's largest allowed force on a taxel, if it is known.
        let limit_n = known.stated_limit_n.or_else(|| (known.force_limit_n)(&recording.controller));
        map.serialize_entry("force_limit_n", &limit_n)?;
        // A taxel is in contact while it senses more than this, N.
        map.serialize_entry("threshold_n", threshold_n)?;
        map.serialize_entry("verdicts", verdicts)?;
        map.end()
    }
}

/// The name of a reach in errors.
fn name(recording: &Recording) -> String {
    let seed = if recording.is_log() { String::new() } else { format!("seed {}, ", recording.seed) };
    format!("{}, {seed}reach {}", recording.scene, recording.reach_index)
}

/// The bytes of a reach, with its contact trials, and with verdicts if there is a model.
///
/// # Errors
/// [`Fault::Usage`] if frames do not fit skin or model, and for a reach of more than 1 GiB, which is hours.
pub fn pack(recording: &Recording, known: &ReplayContext, judging: Option<&Judging>) -> Result<Vec<u8>, Fault> {
    let verdicts = judging.map(|judging| judging.judge(recording)).transpose();
    let verdicts = verdicts.map_err(unjudged(&name(recording)))?;
    pack_from(recording, known, verdicts.as_ref(), 0)
}

/// As [`pack`], with verdicts that are already known, and without what a page already has if it got the frames before
/// number `from`: earlier rows of all arrays, contacts and trials that ended earlier, and everything that does not
/// change.
///
/// # Errors
/// As [`pack`].
pub fn pack_from(
    recording: &Recording,
    known: &ReplayContext,
    verdicts: Option<&Verdicts>,
    from: usize,
) -> Result<Vec<u8>, Fault> {
    let from = from.min(recording.frames.len());
    let frames = &recording.frames[from..];
    let mut sections = Sections::default();
    add_frames(frames, &mut sections);
    if from == 0 {
        add_taxels(recording, &mut sections);
    }
    add_readings(frames, &first_taxels(&recording.layout), &mut sections);
    add_tracks(&recording.bodies, from, &mut sections);
    let threshold_n =
        verdicts.map_or_else(|| TrialOptions::default().threshold_n, |verdicts| verdicts.header.threshold_n);
    add_trials(recording, threshold_n, from, &mut sections)
        .map_err(|error| Fault::Usage(format!("{}: {error}", name(recording))))?;
    if let Some(verdicts) = verdicts {
        verdicts.add(from, &mut sections);
    }
    let verdicts = verdicts.map(|verdicts| &verdicts.header);
    let header = Header { recording, known, verdicts, threshold_n, from };
    sections.finish(&header).map_err(|bytes| {
        let reach = name(recording);
        Fault::Usage(format!("{reach}: takes {bytes} bytes; the page can read {MAX_BYTES} bytes a reach"))
    })
}

fn patches(layout: &SkinLayout) -> Vec<Value> {
    let patch = |(patch, first_taxel): (&Patch, u32)| {
        let Patch { name, link, grid, taxels } = patch;
        json!({ "name": name, "link": link, "grid": grid, "first_taxel": first_taxel, "taxels": taxels.len() })
    };
    layout.patches.iter().zip(first_taxels(layout)).map(patch).collect()
}

/// Adds one row per frame.
fn add_frames(frames: &[Frame], sections: &mut Sections) {
    sections.add("time_s", frames.iter().map(|frame| frame.time_s));
    let each = |read: fn(&Frame) -> &[f64]| frames.iter().flat_map(move |frame| read(frame).iter().copied());
    sections.add_single("joint_angle_rad", each(|frame| &frame.joint_angle_rad));
    sections.add_single("equilibrium_angle_rad", each(|frame| &frame.equilibrium_angle_rad));
    sections.add_single("joint_torque_nm", each(|frame| &frame.joint_torque_nm));
    let tips = frames.iter().map(|frame| &frame.end_effector_pose_world);
    sections.add_single("tip_pose_world", tips.flat_map(Pose::numbers));
    let goals = frames.iter().map(|frame| frame.goal_position_world);
    sections.add_single("goal_position_world_m", goals.flat_map(|goal| goal.to_array()));
    sections.add("goal_index", frames.iter().map(|frame| frame.goal_index));
    let patches = frames.iter().flat_map(|frame| &frame.patch_pose_world);
    sections.add_single("patch_pose_world", patches.flat_map(Pose::numbers));
    let forces = frames.iter().flat_map(|frame| &frame.contact_force_world);
    sections.add_single("patch_force_world_n", forces.flat_map(|force| force.to_array()));
}

/// Adds one row per taxel.
fn add_taxels(recording: &Recording, sections: &mut Sections) {
    let taxels = || recording.layout.patches.iter().flat_map(|patch| &patch.taxels);
    sections.add_single("taxel_position_link_m", taxels().flat_map(|taxel| taxel.position_link.to_array()));
    sections.add_single("taxel_normal_link", taxels().flat_map(|taxel| taxel.normal_link.to_array()));
    sections.add_single("taxel_tangent_link", taxels().flat_map(|taxel| taxel.tangent_link.to_array()));
    sections.add_single("taxel_area_m2", taxels().map(|taxel| taxel.area_m2));
}

/// Adds one row for each taxel that reads a force or is pressed. The rows of frame f are `reading_start[f]` to
/// `reading_start[f + 1]`.
fn add_readings(frames: &[Frame], first_taxels: &[u32], sections: &mut Sections) {
    sections.add("reading_start", starts(frames.iter().map(|frame| frame.taxels.len())));
    let readings = || frames.iter().flat_map(|frame| &frame.taxels);
    let first = |patch: u16| first_taxels.get(usize::from(patch)).copied().unwrap_or_default();
    sections.add("reading_taxel", readings().map(|reading| first(reading.patch) + u32::from(reading.taxel)));
    sections.add_single("reading_sensed_n", readings().map(|reading| reading.sensed_force_n));
    sections.add_single("reading_true_n", readings().map(|reading| reading.true_normal_force_n));
    sections.add_single("reading_shear_n", readings().flat_map(|reading| reading.true_shear_force_n));
    let object = readings().map(|reading| reading.object.map_or(-1, |object| object as i16));
    sections.add("reading_object", object);
}

/// Adds one row for each stored pose from frame `from` on. The rows of body b are `track_start[b]` to
/// `track_start[b + 1]`, and each pose holds until the next.
fn add_tracks(bodies: &[Body], from: usize, sections: &mut Sections) {
    let first_new = |body: &'_ Body| body.track.partition_point(|point| (point.frame as usize) < from);
    sections.add("track_start", starts(bodies.iter().map(|body| body.track.len() - first_new(body))));
    let points = || bodies.iter().flat_map(|body| &body.track[first_new(body)..]);
    sections.add("track_frame", points().map(|point| point.frame));
    let poses = points().flat_map(|point| point.position_world_m.into_iter().chain(point.orientation_world));
    sections.add("track_pose_world", poses);
}

/// Adds the contact trials of every taxel, sorted by patch, then first frame. The sections `trial_*` have one number
/// per trial, and the sections `sample_*` one per sample, which is one per frame of the trial. Trials that end before
/// frame `from`, and samples before it, are left out.
///
/// # Errors
/// If a frame does not fit the skin.
fn add_trials(recording: &Recording, threshold_n: f64, from: usize, sections: &mut Sections) -> Result<(), TrialError> {
    // Without joints, as in a table of trials, it is unknown how the skin moved and which taxels are neighbours.
    let has_arm = !recording.joint_names.is_empty();
    let (mut trials, mut starts, mut samples) = (Vec::new(), vec![0], Vec::new());
    for (patch, first_taxel) in recording.layout.patches.iter().zip(first_taxels(&recording.layout)) {
        let options = TrialOptions { patch: Some(patch.name.clone()), threshold_n, ..TrialOptions::default() };
        for contact in taxel_trials(recording, &options)? {
            let Some(first) = contact.trial.samples.first() else { continue };
            // Times of samples are copied from frames, whose times rise.
            let frame = recording.frames.partition_point(|frame| frame.time_s < first.time_s);
            let known = from.saturating_sub(frame);
            let Some(new @ [_, ..]) = contact.trial.samples.get(known..) else { continue };
            let taxel = first_taxel + contact.trial.taxel.unwrap_or_default();
            trials.push((taxel, frame as u32, contact.object.map_or(-1, |object| object as i16)));
            samples.extend(new.iter().map(|own| if has_arm { (own.motion_m, own.region) } else { (None, None) }));
            starts.push(samples.len() as u32);
        }
    }
    sections.add("trial_taxel", trials.iter().map(|(taxel, ..)| *taxel));
    sections.add("trial_first_frame", trials.iter().map(|(_, frame, _)| *frame));
    sections.add("trial_object", trials.iter().map(|(.., object)| *object));
    sections.add("trial_sample_start", starts);
    sections.add_single("sample_motion_m", samples.iter().map(|(motion_m, _)| motion_m.unwrap_or(f64::NAN)));
    let regions = || samples.iter().map(|(_, region)| region);
    sections.add("sample_region_taxels", regions().map(|own| own.map_or(0, |own| own.taxels as u16)));
    sections.add_single("sample_region_force_n", regions().map(|own| own.map_or(f64::NAN, |own| own.force_sum_n)));
    Ok(())
}
