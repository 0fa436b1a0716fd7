//! Rules for a single frame: one number per joint, one pose per patch, taxels that exist and are sorted, and contacts
//! on a patch that add up to its force.

use glam::DVec3;

use super::{Violation, finite, require, require_unit};
use crate::{BodyOwner, Frame, Pose, Recording};

/// Tolerance for the length of a quaternion. Choice: ten times the rounding error of single precision, which many
/// drivers use.
const QUATERNION_TOLERANCE: f64 = 1e-6;

/// Relative tolerance for a sum of forces: rounding of some ten of them to single precision.
const SUM_TOLERANCE: f64 = 1e-6;

/// Checks the lengths, indices and numbers of a frame.
pub(super) fn check_frame(recording: &Recording, index: usize, frame: &Frame) -> Result<(), Violation> {
    let field = |name: &str| format!("frames[{index}].{name}");
    let joints = recording.joint_names.len();
    for (name, values) in [
        ("joint_angle_rad", &frame.joint_angle_rad),
        ("joint_velocity_rad_per_s", &frame.joint_velocity_rad_per_s),
        ("equilibrium_angle_rad", &frame.equilibrium_angle_rad),
        ("joint_torque_nm", &frame.joint_torque_nm),
    ] {
        let found = || format!("{} numbers for {joints} joints", values.len());
        require(values.len() == joints, || field(name), found, "one number per joint")?;
        finite(values.iter().copied(), || field(name))?;
    }
    let patches = recording.layout.patches.len();
    let lengths = [frame.patch_pose_world.len(), frame.contact_force_world.len()];
    let found = || format!("{lengths:?} for {patches} patches");
    let each = lengths == [patches; 2];
    require(each, || field("patch_pose_world and contact_force_world"), found, "one per patch")?;
    let numbers = [frame.time_s].into_iter().chain(frame.goal_position_world.to_array());
    finite(numbers.chain(frame.end_effector_pose_world.numbers()), || field("time, goal or end effector pose"))?;
    finite(frame.patch_pose_world.iter().flat_map(Pose::numbers), || field("patch_pose_world"))?;
    finite(frame.contact_force_world.iter().flat_map(|force| force.to_array()), || field("contact_force_world"))?;
    let sorted = frame.taxels.is_sorted_by(|a, b| (a.patch, a.taxel) < (b.patch, b.taxel));
    let found = || "out of order, or one twice".to_string();
    require(sorted, || field("taxels"), found, "each taxel once, sorted by patch, then taxel")?;
    let is_turn = |pose: &Pose, name| require_unit(pose.orientation.length(), QUATERNION_TOLERANCE, || field(name));
    is_turn(&frame.end_effector_pose_world, "end_effector_pose_world")?;
    frame.patch_pose_world.iter().try_for_each(|pose| is_turn(pose, "patch_pose_world"))?;
    for (position, reading) in frame.taxels.iter().enumerate() {
        let field = || field(&format!("taxels[{position}]"));
        let patch = recording.layout.patches.get(usize::from(reading.patch));
        let known = patch.is_some_and(|patch| usize::from(reading.taxel) < patch.taxels.len());
        let found = || format!("patch {} taxel {}", reading.patch, reading.taxel);
        require(known, field, found, "a taxel of the layout")?;
        let known = reading.object.is_none_or(|object| usize::from(object) < recording.objects.len());
        let found = || format!("object {}", reading.object.unwrap_or_default());
        require(known, field, found, "the index of an object")?;
        let [first_shear, second_shear] = reading.true_shear_force_n;
        // As files store it.
        let sensed_n = f64::from(reading.sensed_force_n as f32);
        let forces = [reading.true_normal_force_n, first_shear, second_shear, sensed_n];
        finite(forces, field)?;
        for (name, force) in [("true_normal_force_n", forces[0]), ("sensed_force_n", reading.sensed_force_n)] {
            require(force >= 0.0, || format!("{}.{name}", field()), || force.to_string(), "0 or more")?;
        }
        let something = reading.object.is_some() || forces.iter().any(|&force| force != 0.0);
        require(something, field, || "all zeros".into(), "only taxels with a force or an object")?;
    }
    for (position, point) in frame.contact_points.iter().enumerate() {
        let field = || field(&format!("contact_points[{position}]"));
        let owner = |body: u16| recording.bodies.get(usize::from(body)).map(|body| &body.owner);
        let is_link = matches!(owner(point.link), Some(BodyOwner::Link(_)));
        require(is_link, field, || format!("link {}", point.link), "the index of a link's body")?;
        let is_other = match (owner(point.body), point.object) {
            (Some(BodyOwner::Object(own)), Some(object)) => *own == object,
            (Some(BodyOwner::Link(_)), None) => point.body != point.link,
            _ => false,
        };
        let allowed = "the index of a body of the object, or of another link";
        require(is_other, field, || format!("body {}", point.body), allowed)?;
        let known = point.patch.is_none_or(|patch| usize::from(patch) < patches);
        require(known, field, || format!("patch {:?}", point.patch), "a patch of the layout")?;
        finite(point.numbers().map(f64::from), field)?;
    }
    check_contact_forces(frame, field)
}

/// The contacts of a patch add up to the patch's force. A recording may come without contacts, as one of a robot does.
fn check_contact_forces(frame: &Frame, field: impl Fn(&str) -> String) -> Result<(), Violation> {
    if frame.contact_points.is_empty() {
        return Ok(());
    }
    for (patch, force) in frame.contact_force_world.iter().enumerate() {
        let on_patch = || frame.contact_points.iter().filter(|point| point.patch.map(usize::from) == Some(patch));
        let sum: DVec3 = on_patch().map(|point| point.force_world.as_dvec3()).sum();
        let largest_n = on_patch().map(|point| point.force_world.as_dvec3().length()).fold(0.0, f64::max);
        let apart_n = (sum - *force).length();
        let found = || format!("{apart_n} N away from the sum of the patch's contact points");
        let field = || field(&format!("contact_force_world[{patch}]"));
        let allowed = "the sum of the contact points on the patch";
        require(apart_n <= SUM_TOLERANCE * largest_n, field, found, allowed)?;
    }
    Ok(())
}
