//! The rules for recordings, checked before writing and after reading.
//!
//! A recording that passes can be stored in dense columns without loss, and all its indices are valid.

mod frames;

use std::path::Path;

use self::frames::check_frame;
use crate::body::ORIENTATION_STEP;
use crate::{Audit, BodyOwner, Category, DiskError, InputError, Outcome, Recording, SkinLayout};

/// Tolerance for the length of a quaternion: the rounding of the bodies' tracks.
const QUATERNION_TOLERANCE: f64 = 2.0 * ORIENTATION_STEP;

/// Relative tolerance for the frame rate. Choice: ten times the error of a computer's clock, and far less than the
/// error of a wrong rate.
const RATE_TOLERANCE: f64 = 1e-3;

/// A rule broken by a recording or a trial.
#[derive(Debug, PartialEq)]
pub(super) struct Violation {
    /// The field that breaks the rule.
    pub(super) field: String,
    /// What was found.
    pub(super) found: String,
    /// The rule.
    pub(super) allowed: &'static str,
}

impl Violation {
    /// The error when writing to a file.
    pub(super) fn unwritable(self, path: &Path) -> DiskError {
        let Violation { field, found, allowed } = self;
        DiskError::Unwritable { path: path.to_path_buf(), field, found, allowed: allowed.to_string() }
    }

    /// The error when reading from a file.
    pub(super) fn misread(self, path: &Path) -> DiskError {
        let remedy = "write the file again with the program that made it";
        InputError::new(path, self.field, self.found, self.allowed, remedy).into()
    }
}

/// An error with field, found and allowed, unless the rule holds.
pub(super) fn require(
    holds: bool,
    field: impl FnOnce() -> String,
    found: impl FnOnce() -> String,
    allowed: &'static str,
) -> Result<(), Violation> {
    if holds { Ok(()) } else { Err(Violation { field: field(), found: found(), allowed }) }
}

/// Checks that a quaternion of this length has unit length, up to a tolerance.
fn require_unit(length: f64, tolerance: f64, field: impl FnOnce() -> String) -> Result<(), Violation> {
    let found = || format!("a quaternion of length {length}");
    require((length - 1.0).abs() <= tolerance, field, found, "a quaternion of length 1")
}

/// `Err` with the first number that is not finite.
fn finite(values: impl IntoIterator<Item = f64>, field: impl FnOnce() -> String) -> Result<(), Violation> {
    let strange = values.into_iter().find(|value| !value.is_finite());
    require(strange.is_none(), field, || strange.unwrap_or_default().to_string(), "finite numbers")
}

/// Checks a skin layout: unique patch names that can be part of column names, taxels in every patch, and grids that
/// fit.
pub(super) fn check_layout(layout: &SkinLayout) -> Result<(), Violation> {
    for (index, patch) in layout.patches.iter().enumerate() {
        let field = |name: &str| format!("layout.patches[{index}].{name}");
        // LeRobot reads a "/" in a feature name as part of a path.
        let named = !patch.name.is_empty() && !patch.name.contains('/');
        require(named, || field("name"), || format!("{:?}", patch.name), "a name without \"/\"")?;
        let unique = layout.patch_index(&patch.name) == Some(index);
        require(unique, || field("name"), || format!("{:?} twice", patch.name), "unique names")?;
        let count = patch.taxels.len();
        require((1..=65536).contains(&count), || field("taxels"), || format!("{count} taxels"), "1 to 65536 taxels")?;
        if let Some(grid) = patch.grid {
            let fits = grid.rows.checked_mul(grid.columns) == Some(count);
            let found = || format!("{} × {} for {count} taxels", grid.rows, grid.columns);
            require(fits, || field("grid"), found, "rows × columns = taxels")?;
        }
        let numbers = patch.taxels.iter().flat_map(|taxel| {
            let vectors = [taxel.position_link, taxel.normal_link, taxel.tangent_link];
            vectors.into_iter().flat_map(|vector| vector.to_array()).chain([taxel.area_m2])
        });
        finite(numbers, || field("taxels"))?;
    }
    Ok(())
}

/// Checks what recordings and data sets say about the robot: skin, frame rate and joints.
pub(super) fn check_robot(layout: &SkinLayout, rate_hz: f64, joint_names: &[String]) -> Result<(), Violation> {
    check_layout(layout)?;
    require(rate_hz.is_finite() && rate_hz > 0.0, || "rate_hz".into(), || rate_hz.to_string(), "a number above 0")?;
    require(!joint_names.is_empty(), || "joint_names".into(), || "none".into(), "at least one joint")
}

/// Checks that further categories can be told apart by name and by code.
pub(super) fn check_categories(further: &[Category]) -> Result<(), Violation> {
    for (index, category) in further.iter().enumerate() {
        let clash = |other: &&Category| other.name() == category.name() || other.code() == category.code();
        let is_new = !category.is_built_in() && !further[..index].iter().any(|other| clash(&other));
        let found = || format!("\"{}\" with code {}", category.name(), category.code());
        require(is_new, || "categories".into(), found, "a name and a code that no other category has")?;
    }
    Ok(())
}

/// Checks everything in a recording except its frames and tracks.
fn check_header(recording: &Recording) -> Result<(), Violation> {
    check_robot(&recording.layout, recording.rate_hz, &recording.joint_names)?;
    let objects = recording.objects.len();
    // The ground truth of taxels holds object indices as 16-bit integers, with −1 for none.
    require(objects <= 32768, || "objects".into(), || format!("{objects} objects"), "at most 32768 objects")?;
    for field in Audit::FIELDS {
        finite([(field.get)(&recording.audit)], || format!("audit.{}", field.name))?;
    }
    for (index, object) in recording.objects.iter().enumerate() {
        let numbers = object.position_world.to_array().into_iter().chain(object.parameters.values().copied());
        finite(numbers, || format!("objects[{index}]"))?;
    }
    check_categories(&recording.further_categories())?;
    for (index, goal) in recording.goals.iter().enumerate() {
        let times = [goal.start_time_s, goal.end_time_s];
        finite(goal.position_world.to_array().into_iter().chain(times), || format!("goals[{index}]"))?;
        let field = |name: &str| format!("goals[{index}].{name}");
        let found = |what: &str| format!("{what} on a goal with the outcome {}", goal.outcome.name());
        let fits = goal.given_up.is_none() || goal.outcome == Outcome::Stuck;
        require(fits, || field("given_up"), || found("a reason"), "none, unless the outcome is stuck")?;
        let Some(stop) = &goal.safety_stop else { continue };
        let field = |name: &str| field(&format!("safety_stop{name}"));
        let fits = goal.outcome == Outcome::Aborted;
        require(fits, || field(""), || found("one"), "none, unless the outcome is aborted")?;
        check_place(recording, &stop.link, stop.patch, stop.object, field)?;
        finite([stop.force_n], || field(".force_n"))?;
    }
    for (index, obstacle) in recording.map.iter().enumerate() {
        let numbers = obstacle.top_world.to_array().into_iter().chain([obstacle.radius_m, obstacle.deviation_m]);
        finite(numbers, || format!("map[{index}]"))?;
        let ordered = obstacle.first_frame <= obstacle.last_frame;
        let field = || format!("map[{index}].last_frame");
        require(ordered, field, || obstacle.last_frame.to_string(), "first_frame or later")?;
    }
    for (index, contact) in recording.contacts.iter().enumerate() {
        let field = |name: &str| format!("contacts[{index}]{name}");
        check_place(recording, &contact.link, contact.patch, Some(contact.object), field)?;
        let ordered = contact.first_frame <= contact.last_frame;
        require(ordered, || field(".last_frame"), || contact.last_frame.to_string(), "first_frame or later")?;
        let forces = [contact.peak_force_n, contact.mean_force_n];
        finite(forces, || field(".peak_force_n and mean_force_n"))?;
        for (name, force) in [".peak_force_n", ".mean_force_n"].into_iter().zip(forces) {
            require(force >= 0.0, || field(name), || force.to_string(), "0 or more")?;
        }
        let inside = (contact.last_frame as usize) < recording.frames.len();
        require(inside, || field(".last_frame"), || contact.last_frame.to_string(), "the index of a frame")?;
    }
    Ok(())
}

/// Checks the place where an object pressed on the arm: a patch and its link, or a link with a name, and a known
/// object.
fn check_place(
    recording: &Recording,
    link: &str,
    patch: Option<u16>,
    object: Option<u16>,
    field: impl Fn(&str) -> String,
) -> Result<(), Violation> {
    if let Some(patch) = patch {
        let known = recording.layout.patches.get(usize::from(patch));
        require(known.is_some(), || field(".patch"), || patch.to_string(), "the index of a patch of the layout")?;
        let carries = known.is_some_and(|patch| patch.link == link);
        require(carries, || field(".link"), || format!("{link:?}"), "the link that carries the patch")?;
    } else {
        require(!link.is_empty(), || field(".link"), || "no name".into(), "the name of a link")?;
    }
    let known = object.is_none_or(|object| usize::from(object) < recording.objects.len());
    require(known, || field(".object"), || object.unwrap_or_default().to_string(), "the index of an object")
}

/// `timestamp` is computed from index and rate, so the frames' times may jitter but must stay on that grid. A frame
/// that a driver has dropped must be filled in.
fn check_times(recording: &Recording) -> Result<(), Violation> {
    let start_s = recording.frames.first().map_or(0.0, |frame| frame.time_s);
    let mut before_s = f64::NEG_INFINITY;
    for (index, frame) in recording.frames.iter().enumerate() {
        let field = || format!("frames[{index}].time_s");
        let found = || format!("{} s", frame.time_s);
        let later = frame.time_s > before_s;
        require(later, field, found, "a later time than that of the previous frame")?;
        let frames_since_start = (frame.time_s - start_s) * recording.rate_hz;
        let on_grid = (frames_since_start - index as f64).abs() < 0.5 + RATE_TOLERANCE * index as f64;
        let allowed = "within half a frame of the first frame's time + index / rate";
        require(on_grid, field, found, allowed)?;
        before_s = frame.time_s;
    }
    for (index, goal) in recording.goals.iter().enumerate() {
        let field = || format!("goals[{index}].end_time_s");
        let found = || format!("{} s", goal.end_time_s);
        require(goal.start_time_s <= goal.end_time_s, field, found, "the start time or later")?;
    }
    Ok(())
}

/// Checks that objects are known, quaternions have unit length, and the frames of tracks increase.
fn check_bodies(recording: &Recording) -> Result<(), Violation> {
    for (index, body) in recording.bodies.iter().enumerate() {
        let field = |name: &str| format!("bodies[{index}].{name}");
        if let BodyOwner::Object(object) = body.owner {
            let known = usize::from(object) < recording.objects.len();
            require(known, || field("owner"), || format!("object {object}"), "the index of an object")?;
        }
        let poses = body.parts.iter().map(|part| part.pose_body).chain([body.rest_pose_world]);
        for pose in poses {
            finite(pose.numbers(), || field("parts and rest_pose_world"))?;
            require_unit(pose.orientation.length(), QUATERNION_TOLERANCE, || field("parts and rest_pose_world"))?;
        }
        for part in &body.parts {
            finite(part.shape.numbers(), || field("parts"))?;
        }
        let mut next = 0;
        for point in &body.track {
            let known = point.frame >= next && (point.frame as usize) < recording.frames.len();
            let found = || point.frame.to_string();
            require(known, || field("track"), found, "the index of a later frame than that of the previous point")?;
            next = point.frame + 1;
            let numbers = point.position_world_m.into_iter().chain(point.orientation_world);
            finite(numbers.map(f64::from), || field("track"))?;
            let squares = point.orientation_world.map(|number| f64::from(number).powi(2));
            require_unit(squares.iter().sum::<f64>().sqrt(), QUATERNION_TOLERANCE, || field("track"))?;
        }
    }
    Ok(())
}

/// Checks a whole recording.
pub(super) fn check_recording(recording: &Recording) -> Result<(), Violation> {
    check_header(recording)?;
    recording.frames.iter().enumerate().try_for_each(|(index, frame)| check_frame(recording, index, frame))?;
    check_times(recording)?;
    // Last, because tracks refer to frames.
    check_bodies(recording)
}
