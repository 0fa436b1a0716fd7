//! The fabric's loop and responses.

use super::*;

/// Tests the fabric's hysteresis loop: up to F and back to 0 it encloses h F² / 2 at any speed, and a reading during
/// unloading is never below that during loading.
#[test]
fn fabric_has_the_hysteresis_loop_asked_for() {
    let (share, peak) = (0.25, 8.0);
    let options = SensorOptions {
        fabric: FabricOptions { hysteresis_share: share, ..SensorOptions::off().fabric },
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
        // The trapezoidal rule is exact on straight pieces; at the one corner its error is at most the square of a
        // step.
        let gap: Vec<f64> = up.iter().zip(&down).map(|(up, down)| down - up).collect();
        let area: f64 = gap.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0 * (peak / f64::from(steps))).sum();
        let expected = share * peak * peak / 2.0;
        let step = peak / f64::from(steps);
        assert!((area - expected).abs() < step * step, "{area}, {expected}");
    }
}

/// Tests the fabric's response F S / (F + S): slope 1 at small forces, half the full scale at S, never over it, in
/// counts of the converter.
#[test]
fn fabric_saturates_as_a_voltage_divider() {
    let full_scale_n = 34.1;
    let mut smooth = sensor(&SensorOptions {
        fabric: FabricOptions { full_scale_n, ..SensorOptions::off().fabric },
        ..SensorOptions::off()
    });
    let small = press(&mut smooth, (FLIPPER, 0), 1e-6);
    assert!((small / 1e-6 - 1.0).abs() < 1e-6, "slope {}", small / 1e-6);
    let half = press(&mut smooth, (FLIPPER, 0), full_scale_n);
    assert!((half - full_scale_n / 2.0).abs() < ROUNDING * half, "half scale {half}");
    let max = press(&mut smooth, (FLIPPER, 0), 1e12);
    assert!(max <= single(full_scale_n) && max > full_scale_n * (1.0 - ROUNDING) - 1e-6, "largest reading {max}");
    let mut counting = sensor(&SensorOptions {
        fabric: FabricOptions { counts_per_n: 30.0, ..SensorOptions::off().fabric },
        ..SensorOptions::off()
    });
    assert_eq!(press(&mut counting, (FLIPPER, 0), 1.02), single(31.0 / 30.0));
}

/// The authors' taxel, m².
const AREA_M2: f64 = 0.04 * 0.04;

/// The force that saturates all of it: their 45 N saturate 40 %.
const FULL_SCALE_N: f64 = 45.0 / 0.4;

/// The sensor with fabric that responds by conductance, whose taxels all have the authors' size.
fn conducting(counts_per_n: f64) -> Sensor {
    let fabric = FabricOptions { response: FabricResponse::Conductance, counts_per_n, ..SensorOptions::off().fabric };
    let mut skin = Arm::cody().unwrap().skin;
    skin.layout.patches[FLIPPER].taxels.iter_mut().for_each(|taxel| taxel.area_m2 = AREA_M2);
    Sensor::new(&SensorOptions { fabric, ..SensorOptions::off() }, &skin, 1, "test", 0)
}

/// The reading of a force on a share of the taxel.
fn press_share(sensor: &mut Sensor, force_n: f64, share: f64) -> f64 {
    sensor.press_parts(FLIPPER, 0, std::iter::once((force_n, share * AREA_M2)));
    sensor.sample();
    sensor.reading_n(FLIPPER, 0)
}

proptest! {
    /// Tests that a taxel that responds by conductance reads a force that is spread evenly over it, up to the full scale.
    #[test]
    fn evenly_loaded_fabric_reads_its_force(force_n in 0.0..112.0f64) {
        let reading = press_share(&mut conducting(0.0), force_n, 1.0);
        // The logarithm's argument is up to 400 times the unit in the last place of a number near 1.
        prop_assert!((reading - force_n).abs() < ROUNDING * force_n + 1e-12, "{reading}");
    }

    /// Tests the reading of a force on half of the taxel against the sum of the conductances of both halves:
    /// S/6 ln((exp(12 F/S) + 1) / 2), which is more than F.
    #[test]
    fn a_force_on_half_of_the_fabric_reads_more(force_n in 1.0..56.0f64) {
        let reading = press_share(&mut conducting(0.0), force_n, 0.5);
        let expected = FULL_SCALE_N / 6.0 * ((12.0 * force_n / FULL_SCALE_N).exp().midpoint(1.0)).ln();
        prop_assert!((reading / expected - 1.0).abs() < 1e-6 && reading > force_n, "{reading}, {expected}");
    }
}

/// Tests against the authors' model, `tactile_sensor_model.py`: the evenly spread force with the resistance that it gives 10 N
/// on a half and on a quarter of the taxel (33.8659 and 25.9024 Ω), 20 N on a quarter (5.1113 Ω), 5 N on a sixteenth (15.6467 Ω)
/// and 45 N on 40 % (0.6148 Ω). Its contact resistance, which we leave out, is 0.2 % of the last.
#[test]
fn readings_are_those_of_the_published_model() {
    let published = [
        (10.0, 0.5, 12.54903),
        (10.0, 0.25, 19.70742),
        (20.0, 0.25, 54.77525),
        (5.0, 0.0625, 31.58968),
        (45.0, 0.4, 95.36665),
    ];
    for (force_n, share, expected_n) in published {
        let reading = press_share(&mut conducting(0.0), force_n, share);
        assert!((reading / expected_n - 1.0).abs() < 5e-4, "{force_n} N on {share}: {reading}, {expected_n}");
    }
}

/// Tests that fabric saturates at 45 N on 40 % of 4 cm × 4 cm: it reads more with more force, but no more beyond.
#[test]
fn fabric_saturates_at_the_published_pressure() {
    let [below, at, beyond] = [44.0, 45.0, 90.0].map(|force_n| press_share(&mut conducting(0.0), force_n, 0.4));
    assert!(below < at && at == beyond, "{below} {at} {beyond}");
}

/// Tests the 10 bits: 47 Ω in series with 50 Ω leave 50/97 of the supply voltage to the unloaded taxel, and 202 times its
/// conductance leaves 0.0052. Between them are 522 steps of 1/1024, so a rising force has 523 readings.
#[test]
fn readings_have_the_steps_of_the_published_divider() {
    let mut sensor = conducting(30.0);
    let mut readings: Vec<f64> =
        (0..12_000).map(|step| press_share(&mut sensor, f64::from(step) * 0.01, 1.0)).collect();
    readings.dedup();
    assert_eq!((readings.len(), readings[0]), (523, 0.0));
}

/// Tests that parts are added up if the response is that of the total force.
#[test]
fn parts_of_other_taxels_are_added_up() {
    let mut sensor = sensor(&SensorOptions::off());
    for patch in [FOREARM, FLIPPER] {
        assert!(!sensor.feels_parts(patch));
        sensor.press_parts(patch, 3, [(1.0, 1e-5), (0.5, 2e-5)].into_iter());
        sensor.sample();
        assert_eq!(sensor.reading_n(patch, 3), 1.5);
    }
}
