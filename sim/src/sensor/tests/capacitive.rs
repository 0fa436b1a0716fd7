//! Crosstalk and creep.

use super::*;

/// Tests the crosstalk: the kernel of every taxel sums to 1 (to rounding), takes four equal parts, keeps the parts of
/// neighbours that are missing at the rim, and wraps around the forearm; separate fabric has no crosstalk.
#[test]
fn crosstalk_moves_force_and_loses_none() {
    let share = 0.2;
    let mut sensor = sensor(&SensorOptions { crosstalk_share: share, ..SensorOptions::off() });
    for taxel in 0..384 {
        sensor.press(FOREARM, taxel, 1.0);
        sensor.sample();
        let kernel: Vec<f64> = (0..384).map(|taxel| sensor.reading_n(FOREARM, taxel)).collect();
        let sum: f64 = kernel.iter().sum();
        assert!((sum - 1.0).abs() < ROUNDING, "taxel {taxel}: {sum}");
        let (row, column) = (taxel / COLUMNS, taxel % COLUMNS);
        let mut around = vec![row * COLUMNS + (column + 1) % COLUMNS, row * COLUMNS + (column + COLUMNS - 1) % COLUMNS];
        around.extend((row > 0).then(|| taxel - COLUMNS));
        around.extend((row < 15).then(|| taxel + COLUMNS));
        for next in &around {
            assert!((kernel[*next] - share / 4.0).abs() < ROUNDING * share, "taxel {taxel} to {next}");
        }
        assert_eq!(kernel.iter().filter(|part| **part != 0.0).count(), around.len() + 1);
    }
    assert_eq!(press(&mut sensor, (FLIPPER, 3), 2.0), 2.0);
    assert_eq!(sensor.reading_n(FLIPPER, 4), 0.0);
}

/// Tests the creep to its closed form: under a constant force F the reading after n frames is F (1 + c Σ (1 −
/// e^(−nΔt/τ))), τ = 0.1, 1, 10, 100 s, and, m frames after release, F c Σ (1 − e^(−nΔt/τ)) e^(−mΔt/τ). The update is
/// exact, so they agree to rounding to single precision.
#[test]
fn creep_follows_its_step_response() {
    let (share, force) = (0.05, 2.0);
    let mut sensor = sensor(&SensorOptions { creep_share_per_decade: share, ..SensorOptions::off() });
    let decay = |frames: i32, time_s: f64| (-f64::from(frames) * FRAME_PERIOD_S / time_s).exp();
    let sum = |part: &dyn Fn(f64) -> f64| [0.1, 1.0, 10.0, 100.0].into_iter().map(part).sum::<f64>();
    let held = 3000;
    for frame in 1..=held {
        let reading = press(&mut sensor, (FOREARM, 50), force);
        let expected = force * (1.0 + share * sum(&|time_s| 1.0 - decay(frame, time_s)));
        assert!((reading - expected).abs() < 1e-10 + ROUNDING * expected, "{frame}: {reading}, {expected}");
    }
    for frame in 1..=held {
        let reading = press(&mut sensor, (FOREARM, 50), 0.0);
        let expected = force * share * sum(&|time_s| (1.0 - decay(held, time_s)) * decay(frame, time_s));
        assert!((reading - expected).abs() < 1e-10 + ROUNDING * expected, "{frame}: {reading}, {expected}");
    }
}

/// Tests that creep follows the logarithm of time: from 0.1 to 1, 1 to 10 and 10 to 100 s under a force, the reading
/// grows by the share per decade, within 10 %. The last decade lacks the tenth that a further element would add.
#[test]
fn creep_goes_with_the_logarithm_of_time() {
    let share = 0.05;
    let mut sensor = sensor(&SensorOptions { creep_share_per_decade: share, ..SensorOptions::off() });
    let mut readings = vec![1.0];
    readings.extend((0..10_000).map(|_| press(&mut sensor, (FOREARM, 50), 1.0)));
    for (from, to) in [(10, 100), (100, 1000), (1000, 10_000)] {
        let grown = readings[to] - readings[from];
        assert!((grown / share - 1.0).abs() < 0.1, "frames {from} to {to}: {grown}");
    }
}
