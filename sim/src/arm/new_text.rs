//! The texts of a new arm's files: the rules for what its URDF does not say, and the tables.

use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

use underbrush_recording::limits::short;

use super::Joint;
use super::inertia::Entries;
use super::source::{quoted, significant};
use super::start::Room;
use super::urdf::{self, child};

/// Stiffest joint, N m/rad. Choice: the Panda in docs/arms.md has 40, Cody 50; an arm that pushes through foliage is soft.
const MAX_STIFFNESS_NM_PER_RAD: f64 = 40.0;
/// The controller keeps this far from the limits of a joint, deg, but leaves half of a narrow range.
const MARGIN_DEG: f64 = 5.0;
/// Trunks for each square metre of the workspace. Choice: as in the scene `trunk`.
const TRUNKS_PER_M2: f64 = 23.0;

pub(super) const RULES: &str = "\
# Every joint is a spring and a damper about an equilibrium angle, which the controller moves. Rules for all joints:
# - stiffness: the joint exerts its largest torque (URDF: effort) when the equilibrium angle is half its range away, at most
#   90 deg; at most 40 N m/rad, because an arm that pushes through foliage has to be soft. Cody has 3 to 50 N m/rad.
# - damping: critical, 2 sqrt(K I), for the inertia I that the joint moves in the start posture.
# - controller_limits_deg: the URDF's, less 5 deg at each end; a joint without limits gets one turn.
# - the controller's model has the true stiffness.
";

fn half_range_rad(joint: &Joint) -> f64 {
    (joint.limits_rad[1] - joint.limits_rad[0]) / 2.0
}

pub(super) fn stiffness_nm_per_rad(joint: &Joint) -> f64 {
    let strong = joint.torque_limit_nm / half_range_rad(joint).min(FRAC_PI_2);
    significant(strong.min(MAX_STIFFNESS_NM_PER_RAD), 2)
}

pub(super) fn controller_limits_deg(joint: &Joint) -> [f64; 2] {
    if !joint.limits_rad[0].is_finite() {
        return [-PI, PI].map(f64::to_degrees);
    }
    let margin_deg = (half_range_rad(joint).to_degrees() / 2.0).min(MARGIN_DEG);
    let [low, high] = joint.limits_rad.map(f64::to_degrees);
    // Rounded inwards to 0.01 deg.
    [((low + margin_deg) * 100.0).ceil() / 100.0, ((high - margin_deg) * 100.0).floor() / 100.0]
}

pub(super) fn joint_table(joint: &Joint, [low, high]: &[f64; 2], start: f64, [stiffness, damping]: [f64; 2]) -> String {
    let range = match joint.limits_rad[0].is_finite() {
        true => format!("{:.0} deg of range", 2.0 * half_range_rad(joint).to_degrees()),
        false => "no limits".to_owned(),
    };
    let (torque, name, start) = (short(joint.torque_limit_nm), quoted(&joint.name), start + 0.0);
    format!(
        "\n# {torque} N m, {range}\n[[joint]]\nname = {name}\nstiffness_nm_per_rad = {stiffness:?}\ndamping_nm_s_per_rad = {damping:?}\n\
         model_stiffness_nm_per_rad = {stiffness:?}\ncontroller_limits_deg = [{low:?}, {high:?}]\nstart_deg = {start:?}\n"
    )
}

pub(super) fn held_tables(held: &[(urdf::Joint, f64)]) -> String {
    let table = |(joint, place): &(urdf::Joint, f64)| {
        let (key, place) =
            if joint.kind == "prismatic" { ("displacement_m", *place) } else { ("angle_deg", place.to_degrees()) };
        let mimic = if child(joint.element, "mimic").is_some() { ", as its mimic rule says" } else { "" };
        let (name, place) = (quoted(joint.name), place + 0.0);
        format!(
            "\n# Not between base and tip, so it is held as close to zero as its limits allow{mimic}.\n\
             [[held]]\nname = {name}\n{key} = {place:?}\n"
        )
    };
    held.iter().map(table).collect()
}

pub(super) fn inertia_tables(raised: &[(String, Entries, f64)]) -> String {
    let table = |(link, entries, share): &(String, Entries, f64)| {
        let (link, percent) = (quoted(link), 100.0 * share);
        format!(
            "\n# No body has the inertia of this link in the URDF: its largest principal moment is {percent:.1} % above the sum of the other\n\
             # two. This is the nearest one of a body: the other two are raised alike, until their sum is the largest.\n\
             [[inertia]]\nlink = {link}\n# ixx, ixy, ixz, iyy, iyz, izz\nentries_kg_m2 = {entries:?}\n"
        )
    };
    raised.iter().map(table).collect()
}

pub(super) fn skin_text(arm_file: &Path) -> String {
    let file = arm_file.file_name().unwrap_or_default().to_string_lossy();
    format!(
        "# The skin of the arm in {file}. `underbrush arm skin {file} --link LINK --pitch-mm 10 --patch NAME` adds a patch.\n\n\
         # Choice: a cover of modulus 0.1 MPa, 3 mm thick, as on Cody. `underbrush fit-skin` measures that of a real skin.\n\
         stiffness_n_per_m3 = 3e7\n\
         thickness_m = 0.003\n\
         # Soft rubber; also the default.\n\
         loss_time_s = 0.002\n"
    )
}

pub(super) fn scene_text(arm_file: &Path, room: &Room) -> String {
    let [file, stem] =
        [arm_file.file_name(), arm_file.file_stem()].map(|name| name.unwrap_or_default().to_string_lossy());
    let reach = room.reach_m;
    let mm = |value_m: f64| (value_m * 1e3).round() / 1e3 + 0.0;
    let [near, far, goal_near, goal_far] = [0.38, 0.80, 0.48, 0.70].map(|share| mm(room.shoulder_m.x + share * reach));
    let [right, left, goal_right, goal_left] =
        [-0.38, 0.38, -0.32, 0.32].map(|share| mm(room.shoulder_m.y + share * reach));
    let [low, high] = room.goal_heights_m().map(mm);
    let (arm, summary) = (quoted(&file), quoted(&format!("Reach between trunks in front of {stem}")));
    let table = mm(room.table_m());
    let trunks = ((far - near) * (left - right) * TRUNKS_PER_M2).round().max(2.0);
    format!(
        "# Trunks in front of the arm in {file}, written by `underbrush arm new`. Places are shares of the arm's reach, {reach:.2} m from\n\
         # its second joint to its tip, as in docs/arms/panda/foliage.toml, and begin at that joint. Lengths are in the frame of\n\
         # the base: x forward, y left, z up. As many trunks to an area as in the scene `trunk`.\n\
         summary = {summary}\narm = {arm}\n\n\
         [workspace]\nx_m = [{near:?}, {far:?}]\ny_m = [{right:?}, {left:?}]\n# Below the second joint, so that the forearm comes among the trunks.\ntable_height_m = {table:?}\n\n\
         [goals]\ncount = 4\nretries = 0\npatience_s = 1.0\n\
         x_m = {{ uniform = [{goal_near:?}, {goal_far:?}] }}\ny_m = {{ uniform = [{goal_right:?}, {goal_left:?}] }}\nz_m = {{ uniform = [{low:?}, {high:?}] }}\n\n\
         [[objects.trunk]]\ncount = {trunks}\n"
    )
}
