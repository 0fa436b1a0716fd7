//! Tests of the sensor against closed forms and the statistics of its noise.

use std::collections::BTreeMap;

use proptest::prelude::*;

use super::{FabricOptions, Sensor, SensorOptions};
use crate::arm::Arm;
use crate::world::FRAME_PERIOD_S;

/// Patches of Cody's skin.
const FOREARM: usize = 0;
const FLIPPER: usize = 1;
const COLUMNS: usize = 24;

fn sensor(options: &SensorOptions) -> Sensor {
    Sensor::new(options, &Arm::cody().unwrap().skin, 1, "test", 0)
}

/// Presses one taxel with a force for a frame; what it reads then.
fn press(sensor: &mut Sensor, (patch, taxel): (usize, usize), force_n: f64) -> f64 {
    sensor.press(patch, taxel, force_n);
    sensor.sample();
    sensor.reading_n(patch, taxel)
}

proptest! {
    /// Pins that readings are the true forces, bit for bit, with `perfect` and with each effect switched off by itself.
    #[test]
    fn what_is_off_changes_nothing(force in 0.0..100.0f64, taxel in 0usize..69) {
        let perfect = SensorOptions { perfect: true, ..SensorOptions::default() };
        for options in [perfect, SensorOptions::off()] {
            let mut sensor = sensor(&options);
            prop_assert_eq!(press(&mut sensor, (FOREARM, taxel), force), force);
            prop_assert_eq!(press(&mut sensor, (FLIPPER, taxel), force), force);
        }
    }

    /// Pins that readings are counts: the double nearest to count / 1000, whatever the rounding of 0.001 itself, and
    /// never farther from the force than half a quantum.
    #[test]
    fn readings_are_the_nearest_thousandths(force in 0.0..16.9f64) {
        let mut sensor = sensor(&SensorOptions { quantum_n: 0.001, ..SensorOptions::off() });
        let reading = press(&mut sensor, (FOREARM, 100), force);
        prop_assert!((reading - force).abs() <= 0.0005 + 1e-12);
        let nearest: f64 = format!("{reading:.3}").parse().unwrap();
        prop_assert_eq!(reading, nearest);
    }
}

/// Pins mean and variance of the noise within three standard errors of those of a normal distribution, that no two
/// taxels share their noise, and that gate, quantum and floor are off at 0.
#[test]
fn noise_has_the_variance_asked_for() {
    let sigma = 0.005;
    // A force far from zero, so that no reading is clamped.
    let (force, frames) = (1.0, 2000);
    let mut sensor = sensor(&SensorOptions {
        noise_n: sigma,
        ..SensorOptions::off()
    });
    let taxels = 384;
    let mut deviations = Vec::new();
    for _ in 0..frames {
        for taxel in 0..taxels {
            sensor.press(FOREARM, taxel, force);
        }
        sensor.sample();
        deviations.extend((0..taxels).map(|taxel| sensor.reading_n(FOREARM, taxel) - force));
    }
    let count = deviations.len() as f64;
    let mean = deviations.iter().sum::<f64>() / count;
    let variance = deviations
        .iter()
        .map(|deviation| (deviation - mean).powi(2))
        .sum::<f64>()
        / (count - 1.0);
    assert!(mean.abs() < 3.0 * sigma / count.sqrt(), "mean {mean}");
    let error = variance / (sigma * sigma) - 1.0;
    assert!(error.abs() < 3.0 * (2.0 / count).sqrt(), "variance {error} off");
    // The correlation of neighbours, and of a taxel with itself a frame later, has standard error 1/√count.
    for lag in [1, taxels] {
        let products = deviations.windows(lag + 1).map(|pair| pair[0] * pair[lag]);
        let correlation = products.sum::<f64>() / (count * variance);
        assert!(correlation.abs() < 3.0 / count.sqrt(), "lag {lag}: {correlation}");
    }
}

/// Pins that what touches one taxel does not change the noise of another, nor that of the other technology.
#[test]
fn noise_does_not_depend_on_other_taxels() {
    let options = SensorOptions {
        crosstalk_share: 0.0,
        ..SensorOptions::default()
    };
    let readings = |touched: bool| {
        let mut sensor = sensor(&options);
        let mut readings = Vec::new();
        for frame in 0..50 {
            if touched && frame % 7 == 0 {
                sensor.press(FOREARM, 3, 2.0);
                sensor.press(FLIPPER, 0, 5.0);
            }
            for (patch, taxel) in [(FOREARM, 200), (FLIPPER, 20)] {
                sensor.press(patch, taxel, 1.0);
            }
            sensor.sample();
            readings.extend([sensor.reading_n(FOREARM, 200), sensor.reading_n(FLIPPER, 20)]);
        }
        readings
    };
    assert_eq!(readings(false), readings(true));
}

/// Pins that an untouched taxel reads 0 behind a gate of six sigmas (2e-9 a reading; 45 300 of them) and a force over
/// the gate is read, floor and saturation included.
#[test]
fn gate_floor_and_saturation_cut_where_they_say() {
    let mut gated = sensor(&SensorOptions {
        noise_n: 0.005,
        gate_sigmas: 6.0,
        ..SensorOptions::off()
    });
    for _ in 0..100 {
        gated.sample();
        assert!((0..384).all(|taxel| gated.reading_n(FOREARM, taxel) == 0.0));
    }
    // Ten sigmas over the gate.
    assert!(press(&mut gated, (FOREARM, 0), 0.08) > 0.03);
    let mut cut = sensor(&SensorOptions {
        floor_n: 1.0,
        saturation_n: 17.0,
        ..SensorOptions::off()
    });
    let readings = [0.99, 1.01, 16.5, 17.5].map(|force| press(&mut cut, (FOREARM, 0), force));
    assert_eq!(readings, [0.0, 1.01, 16.5, 17.0]);
}

/// Pins that readings come as many whole frames late as asked for, and start from nothing.
#[test]
fn readings_are_late_by_whole_frames() {
    for delay_frames in [0, 1, 3] {
        let mut sensor = sensor(&SensorOptions {
            delay_frames,
            ..SensorOptions::off()
        });
        let forces: Vec<f64> = (1..20).map(f64::from).collect();
        let readings: Vec<f64> = forces
            .iter()
            .map(|force| press(&mut sensor, (FLIPPER, 5), *force))
            .collect();
        let delay = delay_frames as usize;
        assert!(readings[..delay].iter().all(|reading| *reading == 0.0));
        assert_eq!(readings[delay..], forces[..forces.len() - delay]);
    }
}

/// Pins the crosstalk: the kernel of every taxel sums to 1 (to rounding), takes four equal parts, keeps the parts of
/// neighbours that the rim does not have, and wraps around the forearm; separate fabric has none.
#[test]
fn crosstalk_moves_force_and_loses_none() {
    let share = 0.2;
    let mut sensor = sensor(&SensorOptions {
        crosstalk_share: share,
        ..SensorOptions::off()
    });
    for taxel in 0..384 {
        sensor.press(FOREARM, taxel, 1.0);
        sensor.sample();
        let kernel: Vec<f64> = (0..384).map(|taxel| sensor.reading_n(FOREARM, taxel)).collect();
        let sum: f64 = kernel.iter().sum();
        assert!((sum - 1.0).abs() < 1e-12, "taxel {taxel}: {sum}");
        let (row, column) = (taxel / COLUMNS, taxel % COLUMNS);
        let mut around = vec![
            row * COLUMNS + (column + 1) % COLUMNS,
            row * COLUMNS + (column + COLUMNS - 1) % COLUMNS,
        ];
        around.extend((row > 0).then(|| taxel - COLUMNS));
        around.extend((row < 15).then(|| taxel + COLUMNS));
        for next in &around {
            assert!((kernel[*next] - share / 4.0).abs() < 1e-15, "taxel {taxel} to {next}");
        }
        assert_eq!(kernel.iter().filter(|part| **part != 0.0).count(), around.len() + 1);
    }
    assert_eq!(press(&mut sensor, (FLIPPER, 3), 2.0), 2.0);
    assert_eq!(sensor.reading_n(FLIPPER, 4), 0.0);
}

/// Pins the creep to its closed form: under a constant force F the reading after n frames is F (1 + c (1 − e^(−nΔt/τ)))
/// and, m frames after release, F c (1 − e^(−nΔt/τ)) e^(−mΔt/τ). The update is exact, so to rounding.
#[test]
fn creep_follows_its_step_response() {
    let (share, time_s, force) = (0.05, 12.0, 2.0);
    let mut sensor = sensor(&SensorOptions {
        creep_share: share,
        creep_time_s: time_s,
        ..SensorOptions::off()
    });
    let decay = |frames: i32| (-f64::from(frames) * FRAME_PERIOD_S / time_s).exp();
    let held = 3000;
    for frame in 1..=held {
        let reading = press(&mut sensor, (FOREARM, 50), force);
        let expected = force * (1.0 + share * (1.0 - decay(frame)));
        assert!((reading - expected).abs() < 1e-10, "{frame}: {reading}, {expected}");
    }
    for frame in 1..=held {
        let reading = press(&mut sensor, (FOREARM, 50), 0.0);
        let expected = force * share * (1.0 - decay(held)) * decay(frame);
        assert!((reading - expected).abs() < 1e-10, "{frame}: {reading}, {expected}");
    }
}

/// Pins the fabric's loop: up to F and down to nothing it encloses h F² / 2, whatever the speed, and a reading on the
/// way down is never under that on the way up.
#[test]
fn fabric_has_the_hysteresis_loop_asked_for() {
    let (share, peak) = (0.25, 8.0);
    let options = SensorOptions {
        fabric: FabricOptions {
            hysteresis_share: share,
            ..SensorOptions::off().fabric
        },
        ..SensorOptions::off()
    };
    for steps in [400, 4000] {
        let mut sensor = sensor(&options);
        let force = |step: i32| peak * f64::from(step) / f64::from(steps);
        let mut way = |step: i32| press(&mut sensor, (FLIPPER, 7), force(step));
        let up: Vec<f64> = (0..=steps).map(&mut way).collect();
        let mut down: Vec<f64> = (0..=steps).rev().map(&mut way).collect();
        down.reverse();
        assert!(up.iter().zip(&down).all(|(up, down)| up <= down));
        assert_eq!((down[0], up[0]), (0.0, 0.0));
        // The trapezoidal rule is exact on straight pieces; the one corner is missed by at most a step's square.
        let gap: Vec<f64> = up.iter().zip(&down).map(|(up, down)| down - up).collect();
        let area: f64 = gap
            .windows(2)
            .map(|pair| (pair[0] + pair[1]) / 2.0 * (peak / f64::from(steps)))
            .sum();
        let expected = share * peak * peak / 2.0;
        let step = peak / f64::from(steps);
        assert!((area - expected).abs() < step * step, "{area}, {expected}");
    }
}

/// Pins the fabric's response F S / (F + S): slope 1 at small forces, half the full scale at S, never over it, in
/// counts of the converter.
#[test]
fn fabric_saturates_as_a_voltage_divider() {
    let full_scale_n = 34.1;
    let mut smooth = sensor(&SensorOptions {
        fabric: FabricOptions {
            full_scale_n,
            ..SensorOptions::off().fabric
        },
        ..SensorOptions::off()
    });
    let small = press(&mut smooth, (FLIPPER, 0), 1e-6);
    assert!((small / 1e-6 - 1.0).abs() < 1e-6, "slope {}", small / 1e-6);
    let half = press(&mut smooth, (FLIPPER, 0), full_scale_n);
    assert!((half - full_scale_n / 2.0).abs() < 1e-12, "half scale {half}");
    let most = press(&mut smooth, (FLIPPER, 0), 1e12);
    assert!(most <= full_scale_n && most > full_scale_n - 1e-6, "most {most}");
    let mut counting = sensor(&SensorOptions {
        fabric: FabricOptions {
            counts_per_n: 30.0,
            ..SensorOptions::off().fabric
        },
        ..SensorOptions::off()
    });
    assert_eq!(press(&mut counting, (FLIPPER, 0), 1.02), 31.0 / 30.0);
}

/// Pins dead taxels: those listed always, a share of the others as large as asked for (three sigmas of a binomial),
/// drawn anew for another reach and the same for the same; the noise of the living does not change.
#[test]
fn dead_taxels_read_nothing() {
    let skin = Arm::cody().unwrap().skin;
    let options = SensorOptions {
        dead_share: 0.2,
        dead_taxels: BTreeMap::from([("flipper".to_string(), vec![4])]),
        ..SensorOptions::off()
    };
    let dead_in = |reach: u64| {
        let mut sensor = Sensor::new(&options, &skin, 1, "test", reach);
        let all = || {
            (0..384)
                .map(|taxel| (FOREARM, taxel))
                .chain((0..69).map(|taxel| (FLIPPER, taxel)))
        };
        all().for_each(|(patch, taxel)| sensor.press(patch, taxel, 1.0));
        sensor.sample();
        all()
            .map(|(patch, taxel)| sensor.reading_n(patch, taxel) == 0.0)
            .collect::<Vec<bool>>()
    };
    let reaches: Vec<Vec<bool>> = (0..20).map(dead_in).collect();
    assert!(reaches.iter().all(|dead| dead[384 + 4]));
    assert_eq!(reaches[0], dead_in(0));
    assert_ne!(reaches[0], reaches[1]);
    // Without the listed one of each reach.
    let drawn = reaches.iter().flatten().filter(|dead| **dead).count() as f64 - 20.0;
    let trials = 20.0 * 452.0;
    assert!(
        (drawn - 0.2 * trials).abs() < 3.0 * (trials * 0.2 * 0.8f64).sqrt(),
        "{drawn} of {trials}"
    );
    let noisy = SensorOptions {
        noise_n: 0.01,
        ..SensorOptions::off()
    };
    let one_dead = SensorOptions {
        dead_taxels: BTreeMap::from([("forearm".to_string(), vec![9])]),
        ..noisy.clone()
    };
    let (mut whole, mut broken) = (sensor(&noisy), sensor(&one_dead));
    assert_eq!(
        press(&mut broken, (FOREARM, 10), 1.0),
        press(&mut whole, (FOREARM, 10), 1.0)
    );
    assert_eq!(press(&mut broken, (FOREARM, 9), 1.0), 0.0);
}

/// Pins that options outside their limits and dead taxels that the skin does not have are found, by key.
#[test]
fn faults_are_found() {
    let layout = Arm::cody().unwrap().skin.layout;
    assert_eq!(SensorOptions::default().fault(), None);
    assert_eq!(SensorOptions::off().fault(), None);
    let fault = |options: SensorOptions| options.fault().or(options.fault_on(&layout)).map(|(key, ..)| key);
    let with_dead = |patch: &str, taxel| SensorOptions {
        dead_taxels: BTreeMap::from([(patch.to_string(), vec![taxel])]),
        ..SensorOptions::default()
    };
    assert_eq!(fault(with_dead("forearm", 383)), None);
    for options in [with_dead("forearm", 384), with_dead("elbow", 0)] {
        assert_eq!(fault(options).as_deref(), Some("dead_taxels"));
    }
    let fabric = FabricOptions {
        hysteresis_share: 1.0,
        ..FabricOptions::default()
    };
    let options = SensorOptions {
        fabric,
        ..SensorOptions::default()
    };
    assert_eq!(fault(options).as_deref(), Some("fabric.hysteresis_share"));
    let options = SensorOptions {
        creep_time_s: 0.0,
        ..SensorOptions::default()
    };
    assert_eq!(fault(options).as_deref(), Some("creep_time_s"));
}

/// Pins the strays' long-run share and mean duration within four standard errors, their range, that none is there when
/// the skin has just been zeroed, and that they leave the noise alone.
#[test]
fn strays_have_the_share_and_the_duration_asked_for() {
    let (share, time_s, range) = (0.05, 0.5, [0.02, 0.10]);
    let options = SensorOptions {
        stray_share: share,
        stray_time_s: time_s,
        stray_force_n: range,
        ..SensorOptions::off()
    };
    let mut straying = sensor(&options);
    let (frames, taxels) = (20_000, 384);
    let (mut lit, mut begun, mut before) = (0.0, 0.0, vec![0.0; taxels]);
    for frame in 0..frames {
        straying.sample();
        let now: Vec<f64> = (0..taxels).map(|taxel| straying.reading_n(FOREARM, taxel)).collect();
        assert!(
            now.iter()
                .all(|force| *force == 0.0 || (range[0]..=range[1]).contains(force))
        );
        let strays = now.iter().filter(|force| **force > 0.0).count() as f64;
        assert!(frame > 0 || strays < 0.1 * share * taxels as f64, "{strays} at once");
        lit += strays;
        begun += before
            .iter()
            .zip(&now)
            .filter(|(before, now)| **before == 0.0 && **now > 0.0)
            .count() as f64;
        before = now;
    }
    // Begin and end are independent of the past: durations are geometric, as spread as they are long.
    let error = 4.0 / f64::sqrt(begun);
    let duration_s = lit / begun * FRAME_PERIOD_S;
    assert!(
        (duration_s / time_s - 1.0).abs() < error,
        "{duration_s} s on average of {begun}"
    );
    // In the long run; the first time constants from zero cost a part in 400.
    let found = lit / (frames * taxels) as f64;
    assert!((found / share - 1.0).abs() < 1.5 * error + 0.0025, "share {found}");
    let noisy = |stray_share| {
        let mut sensor = sensor(&SensorOptions {
            noise_n: 0.01,
            stray_share,
            ..SensorOptions::off()
        });
        // A force far from zero; strays are on few taxels for the first frames.
        (0..5)
            .map(|_| press(&mut sensor, (FOREARM, 7), 1.0))
            .collect::<Vec<f64>>()
    };
    assert_eq!(noisy(0.0), noisy(1e-6));
}
