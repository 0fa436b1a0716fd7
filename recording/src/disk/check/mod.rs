//! The rules for recordings, checked before writing and after reading.
//!
//! A recording that passes can be stored in dense columns without loss, and all its indices are valid.

mod bodies;
mod frames;
mod layout;
mod physics;
mod violation;

use self::bodies::check_bodies;
use self::frames::check_frame;
pub(super) use self::layout::{check_layout, check_robot};
use self::physics::check_times;
use self::violation::finite;
pub(super) use self::violation::{Violation, require};
use crate::{Audit, Category, Outcome, Recording};

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

/// Checks a whole recording.
pub(super) fn check_recording(recording: &Recording) -> Result<(), Violation> {
    check_header(recording)?;
    recording.frames.iter().enumerate().try_for_each(|(index, frame)| check_frame(recording, index, frame))?;
    check_times(recording)?;
    // Last, because tracks refer to frames.
    check_bodies(recording)
}
