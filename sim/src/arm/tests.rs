//! Tests of the arm's files and kinematics.

use std::path::Path;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::{Arm, file};
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
