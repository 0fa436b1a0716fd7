//! Tests of the arm's files and kinematics.

use std::path::Path;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use super::{Arm, cody_file, file};
use underbrush_recording::InputError;

mod cody;
mod files;
pub(crate) mod kinematics;

/// Postures drawn evenly between the joints' mechanical limits.
pub(crate) fn random_postures(arm: &Arm, count: usize) -> Vec<Vec<f64>> {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let mut posture = || {
        arm.joints
            .iter()
            .map(|joint| random.random_range(joint.limits_rad[0]..joint.limits_rad[1]))
            .collect()
    };
    (0..count).map(|_| posture()).collect()
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
