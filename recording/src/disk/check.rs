//! The rules that a recording keeps, checked before it is written and after it is read.
//!
//! What passes can be laid out in dense columns without loss and indexed without bounds errors.

use std::path::Path;

use super::DiskError;
use super::check_physics::check_physics;
use crate::body::{BodyOwner, ORIENTATION_STEP};
use crate::{Audit, Frame, InputError, Outcome, Pose, Recording, SkinLayout};

/// A rule broken by a recording or a trial.
#[derive(Debug, PartialEq)]
pub(super) struct Violation {
    /// Where.
    pub(super) field: String,
    /// What stands there.
    pub(super) found: String,
    /// The rule.
    pub(super) allowed: &'static str,
}

impl Violation {
    /// The error for something that was to be written to a file.
    pub(super) fn unwritable(self, path: &Path) -> DiskError {
        let Violation { field, found, allowed } = self;
        DiskError::Unwritable {
            path: path.to_path_buf(),
            field,
            found,
            allowed: allowed.to_string(),
        }
    }

    /// The error for something that was read from a file.
    pub(super) fn misread(self, path: &Path) -> DiskError {
        let remedy = "write the file again with the program that made it";
        InputError::new(path, self.field, self.found, self.allowed, remedy).into()
    }
}

/// `Err` with field, found and allowed unless the rule holds.
pub(super) fn require(
    holds: bool,
    field: impl FnOnce() -> String,
    found: impl FnOnce() -> String,
    allowed: &'static str,
) -> Result<(), Violation> {
    if holds {
        Ok(())
    } else {
        Err(Violation {
            field: field(),
            found: found(),
            allowed,
        })
    }
}

fn finite(values: impl IntoIterator<Item = f64>, field: impl FnOnce() -> String) -> Result<(), Violation> {
    match values.into_iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(value) => Err(Violation {
            field: field(),
            found: value.to_string(),
            allowed: "finite numbers",
        }),
    }
}

/// Checks a skin layout: patch names usable in column names and unique, taxels in every patch, grids that fit.
pub(super) fn check_layout(layout: &SkinLayout) -> Result<(), Violation> {
    for (index, patch) in layout.patches.iter().enumerate() {
        let field = |name: &str| format!("layout.patches[{index}].{name}");
        // LeRobot reads "/" in a feature name as a path.
        let named = !patch.name.is_empty() && !patch.name.contains('/');
        require(
            named,
            || field("name"),
            || format!("{:?}", patch.name),
            "a name without \"/\"",
        )?;
        let unique = layout.patch_index(&patch.name) == Some(index);
        require(
            unique,
            || field("name"),
            || format!("{:?} a second time", patch.name),
            "names that differ",
        )?;
        let count = patch.taxels.len();
        require(
            (1..=65536).contains(&count),
            || field("taxels"),
            || format!("{count} taxels"),
            "1 to 65536 taxels",
        )?;
        if let Some(grid) = patch.grid {
            let fits = grid.rows.checked_mul(grid.columns) == Some(count);
            let found = || format!("{} × {} for {count} taxels", grid.rows, grid.columns);
            require(fits, || field("grid"), found, "rows × columns = taxels")?;
        }
        let numbers = patch.taxels.iter().flat_map(|taxel| {
            let vectors = [taxel.position_link, taxel.normal_link, taxel.tangent_link];
            vectors
                .into_iter()
                .flat_map(|vector| vector.to_array())
                .chain([taxel.area_m2])
        });
        finite(numbers, || field("taxels"))?;
    }
    Ok(())
}

/// Checks what a recording and a whole data set say of the robot: its skin, the rate of its frames, its joints.
pub(super) fn check_robot(layout: &SkinLayout, rate_hz: f64, joint_names: &[String]) -> Result<(), Violation> {
    check_layout(layout)?;
    require(
        rate_hz.is_finite() && rate_hz > 0.0,
        || "rate_hz".into(),
        || rate_hz.to_string(),
        "a number above 0",
    )?;
    require(
        !joint_names.is_empty(),
        || "joint_names".into(),
        || "none".into(),
        "at least one joint",
    )
}

/// Checks everything in a recording but its frames.
fn check_header(recording: &Recording) -> Result<(), Violation> {
    check_robot(&recording.layout, recording.rate_hz, &recording.joint_names)?;
    let objects = recording.objects.len();
    // The per-taxel ground truth holds object indices as 16-bit integers with −1 for "none".
    require(
        objects <= 32768,
        || "objects".into(),
        || format!("{objects} objects"),
        "at most 32768 objects",
    )?;
    for field in Audit::FIELDS {
        finite([(field.get)(&recording.audit)], || format!("audit.{}", field.name))?;
    }
    for (index, object) in recording.objects.iter().enumerate() {
        let numbers = object
            .position_world
            .to_array()
            .into_iter()
            .chain(object.parameters.values().copied());
        finite(numbers, || format!("objects[{index}]"))?;
    }
    for (index, goal) in recording.goals.iter().enumerate() {
        let times = [goal.start_time_s, goal.end_time_s];
        finite(goal.position_world.to_array().into_iter().chain(times), || {
            format!("goals[{index}]")
        })?;
        let Some(stop) = &goal.safety_stop else { continue };
        let field = |name: &str| format!("goals[{index}].safety_stop{name}");
        require(
            goal.outcome == Outcome::Aborted,
            || field(""),
            || format!("one on a goal that {}", goal.outcome.name()),
            "none unless the outcome is aborted",
        )?;
        check_place(recording, &stop.link, stop.patch, stop.object, field)?;
        finite([stop.force_n], || field(".force_n"))?;
    }
    for (index, contact) in recording.contacts.iter().enumerate() {
        let field = |name: &str| format!("contacts[{index}].{name}");
        check_place(recording, &contact.link, contact.patch, contact.object, |name| {
            format!("contacts[{index}]{name}")
        })?;
        let ordered = contact.first_frame <= contact.last_frame;
        require(
            ordered,
            || field("last_frame"),
            || contact.last_frame.to_string(),
            "first_frame or later",
        )?;
        finite([contact.peak_force_n, contact.mean_force_n], || {
            field("peak_force_n and mean_force_n")
        })?;
    }
    Ok(())
}

/// Checks where an object pressed on the arm: a patch with its own link, or a link that has a name, and a known object.
fn check_place(
    recording: &Recording,
    link: &str,
    patch: Option<u16>,
    object: u16,
    field: impl Fn(&str) -> String,
) -> Result<(), Violation> {
    if let Some(patch) = patch {
        let known = recording.layout.patches.get(usize::from(patch));
        require(
            known.is_some(),
            || field(".patch"),
            || patch.to_string(),
            "the index of a patch of the layout",
        )?;
        require(
            known.is_some_and(|patch| patch.link == link),
            || field(".link"),
            || format!("{link:?}"),
            "the link that carries the patch",
        )?;
    } else {
        require(
            !link.is_empty(),
            || field(".link"),
            || "no name".into(),
            "the name of a link",
        )?;
    }
    require(
        usize::from(object) < recording.objects.len(),
        || field(".object"),
        || object.to_string(),
        "the index of an object",
    )
}

/// Checks the bodies: known objects, unit quaternions, tracks that go on frame by frame.
fn check_bodies(recording: &Recording) -> Result<(), Violation> {
    for (index, body) in recording.bodies.iter().enumerate() {
        let field = |name: &str| format!("bodies[{index}].{name}");
        if let BodyOwner::Object(object) = body.owner {
            let known = usize::from(object) < recording.objects.len();
            require(
                known,
                || field("owner"),
                || format!("object {object}"),
                "the index of an object",
            )?;
        }
        let poses = body
            .parts
            .iter()
            .map(|part| part.pose_body)
            .chain([body.rest_pose_world]);
        for pose in poses {
            finite(pose_numbers(&pose), || field("parts and rest_pose_world"))?;
            require_unit(pose.orientation.length(), || field("parts and rest_pose_world"))?;
        }
        for part in &body.parts {
            finite(part.shape.numbers(), || field("parts"))?;
        }
        let mut next = 0;
        for point in &body.track {
            let known = point.frame >= next && (point.frame as usize) < recording.frames.len();
            let found = || point.frame.to_string();
            require(
                known,
                || field("track"),
                found,
                "the index of a frame after that of the point before",
            )?;
            next = point.frame + 1;
            let numbers = point.position_world_m.into_iter().chain(point.orientation_world);
            finite(numbers.map(f64::from), || field("track"))?;
            let squares = point.orientation_world.map(|number| f64::from(number).powi(2));
            require_unit(squares.iter().sum::<f64>().sqrt(), || field("track"))?;
        }
    }
    Ok(())
}

/// Checks the length of a quaternion, which is 1 but for the rounding of a track.
fn require_unit(length: f64, field: impl FnOnce() -> String) -> Result<(), Violation> {
    let unit = (length - 1.0).abs() <= 2.0 * ORIENTATION_STEP;
    require(
        unit,
        field,
        || format!("a quaternion of length {length}"),
        "a quaternion of length 1",
    )
}

fn pose_numbers(pose: &Pose) -> impl Iterator<Item = f64> {
    pose.position.to_array().into_iter().chain(pose.orientation.to_array())
}

fn check_frame(recording: &Recording, index: usize, frame: &Frame) -> Result<(), Violation> {
    let field = |name: &str| format!("frames[{index}].{name}");
    let joints = recording.joint_names.len();
    for (name, values) in [
        ("joint_angle_rad", &frame.joint_angle_rad),
        ("joint_velocity_rad_per_s", &frame.joint_velocity_rad_per_s),
        ("equilibrium_angle_rad", &frame.equilibrium_angle_rad),
        ("joint_torque_nm", &frame.joint_torque_nm),
    ] {
        let found = || format!("{} numbers for {joints} joints", values.len());
        require(values.len() == joints, || field(name), found, "one number a joint")?;
        finite(values.iter().copied(), || field(name))?;
    }
    let patches = recording.layout.patches.len();
    let lengths = [frame.patch_pose_world.len(), frame.contact_force_world.len()];
    let found = || format!("{lengths:?} for {patches} patches");
    let each = lengths == [patches; 2];
    require(
        each,
        || field("patch_pose_world and contact_force_world"),
        found,
        "one a patch",
    )?;
    let numbers = [frame.time_s].into_iter().chain(frame.goal_position_world.to_array());
    finite(numbers.chain(pose_numbers(&frame.tip_pose_world)), || {
        field("time, goal or tip pose")
    })?;
    finite(frame.patch_pose_world.iter().flat_map(pose_numbers), || {
        field("patch_pose_world")
    })?;
    finite(
        frame.contact_force_world.iter().flat_map(|force| force.to_array()),
        || field("contact_force_world"),
    )?;
    let sorted = frame
        .taxels
        .is_sorted_by(|a, b| (a.patch, a.taxel) < (b.patch, b.taxel));
    let found = || "out of order or twice the same".to_string();
    require(
        sorted,
        || field("taxels"),
        found,
        "taxels sorted by patch, then taxel, each once",
    )?;
    for (position, reading) in frame.taxels.iter().enumerate() {
        let field = || field(&format!("taxels[{position}]"));
        let patch = recording.layout.patches.get(usize::from(reading.patch));
        let known = patch.is_some_and(|patch| usize::from(reading.taxel) < patch.taxels.len());
        let found = || format!("patch {} taxel {}", reading.patch, reading.taxel);
        require(known, field, found, "a taxel of the layout")?;
        let object = reading.object.map_or(0, usize::from);
        let known = reading.object.is_none() || object < recording.objects.len();
        require(known, field, || format!("object {object}"), "the index of an object")?;
        let [first_shear, second_shear] = reading.true_shear_force_n;
        let forces = [
            reading.true_normal_force_n,
            first_shear,
            second_shear,
            reading.sensed_force_n,
        ];
        finite(forces, field)?;
        let something = reading.object.is_some() || forces.iter().any(|&force| force != 0.0);
        require(
            something,
            field,
            || "all zeros".into(),
            "only taxels that feel or report something",
        )?;
    }
    Ok(())
}

/// Checks a whole recording.
pub(super) fn check_recording(recording: &Recording) -> Result<(), Violation> {
    check_header(recording)?;
    let count = recording.frames.len();
    for (index, contact) in recording.contacts.iter().enumerate() {
        let inside = usize::try_from(contact.last_frame).is_ok_and(|last| last < count);
        let field = || format!("contacts[{index}].last_frame");
        require(inside, field, || contact.last_frame.to_string(), "the index of a frame")?;
    }
    recording
        .frames
        .iter()
        .enumerate()
        .try_for_each(|(index, frame)| check_frame(recording, index, frame))?;
    check_physics(recording)?;
    // Last: its tracks speak of frames.
    check_bodies(recording)
}
