//! Tests on hand-made presses: a skin that moves along its normal presses on objects that behave like springs.

mod network;
mod regions;
mod verdicts;

use underbrush_recording::Recording;

use crate::trial::tests::recording;

/// Stiffness of hand-made leaves and trunks, N/m.
const STIFFNESS_N_PER_M: [f64; 2] = [30.0, 2000.0];

/// A recording in which taxels 7 and 8 press a spring of stiffness `stiffness_n_per_m` (object `object`) five times, to
/// `depth_m` at most, while taxel 16 reads `spurious_n`. The forces of the two taxels have the ratio 3 to 1.
fn presses(object: u16, stiffness_n_per_m: f64, depth_m: f64, spurious_n: f64) -> Recording {
    let depth = |index: usize| depth_m * (2.0 * std::f64::consts::PI * index as f64 / 40.0).sin();
    let readings: Vec<Vec<(u16, f64, Option<u16>)>> = (0..200)
        .map(|index| {
            let force_n = stiffness_n_per_m * depth(index).max(0.0);
            let mut readings = Vec::new();
            if force_n > 0.0 {
                readings.extend([(7, 0.75 * force_n, Some(object)), (8, 0.25 * force_n, Some(object))]);
            }
            readings.push((16, spurious_n, None));
            readings
        })
        .collect();
    let frames: Vec<_> = readings.iter().map(|readings| (0.0, readings.as_slice())).collect();
    let mut recording = recording(&frames);
    for (index, frame) in recording.frames.iter_mut().enumerate() {
        // Outward is along z: the skin moves into the object.
        frame.patch_pose_world[0].position.z = depth(index);
        for reading in &mut frame.taxels {
            if reading.object.is_none() {
                reading.true_normal_force_n = 0.0;
            }
        }
    }
    recording
}

/// Reaches with one kind of object each, pressed to different depths.
fn reaches() -> Vec<Recording> {
    let objects = (0..12).map(|index| (index % 2, 1.0 + 0.1 * index as f64));
    objects
        .map(|(object, scale)| {
            let depth_m = [0.03, 0.002][object] * scale;
            presses(object as u16, STIFFNESS_N_PER_M[object] * scale, depth_m, 0.05 * scale)
        })
        .collect()
}
