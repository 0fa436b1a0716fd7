//! Tests of the arm's files and kinematics.

use std::f64::consts::TAU;
use std::path::Path;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::start::Room;
use super::{Arm, Joint, file};
use underbrush_recording::InputError;

mod cody;
mod cover;
mod files;
pub(crate) mod kinematics;

/// Postures drawn evenly between the joints' mechanical limits.
pub(crate) fn random_postures(arm: &Arm, count: usize) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut posture =
        || arm.joints.iter().map(|joint| random.random_range(joint.limits_rad[0]..joint.limits_rad[1])).collect();
    (0..count).map(|_| posture()).collect()
}

/// Tests that angles drawn from a joint's range are within half a turn from zero if a part of the range is, and within the range.
#[test]
fn shares_of_a_range_are_within_it() {
    for (range_deg, expected_deg) in [
        ([-1.0, 215.0], [-1.0, 180.0]),
        ([200.0, 340.0], [200.0, 340.0]),
        ([-340.0, -180.0], [-340.0, -180.0]),
        ([f64::NEG_INFINITY, f64::INFINITY], [-180.0, 180.0]),
    ] {
        let joint = Joint { controller_limits_rad: range_deg.map(f64::to_radians), ..Joint::default() };
        let found_deg = [0.0, 1.0].map(|share| joint.at_share(share).to_degrees());
        let is_close = found_deg.iter().zip(expected_deg).all(|(found, expected)| (found - expected).abs() < 1e-9);
        assert!(is_close, "{found_deg:?} of {range_deg:?}");
    }
}

/// Tests that a start posture is the same for a joint whose range is a turn farther from zero.
#[test]
fn the_start_does_not_depend_on_whole_turns() {
    let arm = Arm::cody().unwrap();
    let mut farther = arm.clone();
    farther.joints[3].controller_limits_rad = arm.joints[3].controller_limits_rad.map(|limit| limit + TAU);
    let elbow_rad = |arm: &Arm| Room::of(arm).start_posture(arm).unwrap()[3];
    let (found, expected) = (elbow_rad(&farther) - TAU, elbow_rad(&arm));
    assert!((found - expected).abs() < 1e-6, "{found} rad, not {expected} rad");
}

/// The text of one of Cody's files.
fn cody_file(path: &Path) -> Result<String, InputError> {
    let file = Arm::cody()?.files.into_iter().find(|file| Path::new(&file.name) == path);
    let missing = || InputError::new(path, "file", "no such file", "a file of Cody", "name one of them");
    Ok(file.ok_or_else(missing)?.text)
}

/// Cody with `from` replaced by `to` in one of its files.
fn altered_cody(name: &str, from: &str, to: &str) -> Result<Arm, InputError> {
    file::assemble(Path::new("cody.toml"), &|path: &Path| {
        let text = cody_file(path)?;
        if path != Path::new(name) {
            return Ok(text);
        }
        assert!(text.contains(from), "{name} has no {from}");
        Ok(text.replacen(from, to, 1))
    })
}

/// Tests that names of arms, patches, links and joints with a character that would change a terminal are refused.
#[test]
fn names_that_change_a_terminal_are_refused() {
    for (file, from, to) in [
        ("cody.toml", "name = \"cody\"", "name = \"co\\u001b[31mdy\""),
        ("cody.skin.toml", "name = \"forearm\"", "name = \"fore\\u001b[31marm\""),
        ("cody.urdf", "<link name=\"torso\"/>", "<link name=\"tor\u{202e}so\"/>"),
        ("cody.urdf", "<joint name=\"", "<joint name=\"\u{9b}"),
    ] {
        let error = altered_cody(file, from, to).err().unwrap();
        assert!(error.allowed.contains("control characters"), "{error}");
    }
}
