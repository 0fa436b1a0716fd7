//! Bandwidth, gains, drift, and what the models leave out.

use super::{FLIPPER, FOREARM, press, sensor};
use crate::sensor::{SensorModel, SensorOptions};

/// Readings of an unpressed taxel in successive frames. The quantum keeps negative ones at 0.
fn readings(options: &SensorOptions, taxel: usize, force_n: f64, frames: usize) -> Vec<f64> {
    let mut sensor = sensor(options);
    (0..frames).map(|_| press(&mut sensor, (FOREARM, taxel), force_n)).collect()
}

/// Tests that the reading of a force that begins rises as 1 − exp(−2π f t).
#[test]
fn bandwidth_is_a_low_pass() {
    let bandwidth_hz = 5.0;
    let found = readings(&SensorOptions { bandwidth_hz, ..SensorOptions::off() }, 7, 2.0, 30);
    for (frame, reading) in found.iter().enumerate() {
        let time_s = 0.01 * (frame + 1) as f64;
        let expected = 2.0 * (1.0 - (-2.0 * std::f64::consts::PI * bandwidth_hz * time_s).exp());
        assert!((reading - expected).abs() < 1e-6, "{frame}: {reading}, {expected}");
    }
}

/// Tests that the logarithms of the gains of 384 taxels have the mean 0 and the deviation asked for, within four standard
/// errors, that a taxel keeps its gain, and that a calibrated taxel has none.
#[test]
fn gains_spread_as_they_should() {
    let options = SensorOptions { gain_spread_share: 0.1, ..SensorOptions::off() };
    let gains = |options: &SensorOptions| -> Vec<f64> {
        let mut sensor = sensor(options);
        (0..384).for_each(|taxel| sensor.press(FOREARM, taxel, 1.0));
        sensor.sample();
        let first: Vec<f64> = (0..384).map(|taxel| sensor.reading_n(FOREARM, taxel)).collect();
        (0..384).for_each(|taxel| sensor.press(FOREARM, taxel, 1.0));
        sensor.sample();
        assert!((0..384).all(|taxel| sensor.reading_n(FOREARM, taxel) == first[taxel]));
        first.into_iter().map(f64::ln).collect()
    };
    let found = gains(&options);
    let mean = found.iter().sum::<f64>() / 384.0;
    let deviation = (found.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / 383.0).sqrt();
    assert!(mean.abs() < 4.0 * 0.1 / 384f64.sqrt(), "{mean}");
    assert!((deviation - 0.1).abs() < 4.0 * 0.1 / (2.0 * 384.0f64).sqrt(), "{deviation}");
    let calibrated = gains(&SensorOptions { model: SensorModel::Calibrated, ..options });
    assert!(calibrated.iter().all(|gain| *gain == 0.0));
}

/// Tests that drift keeps its standard deviation, and that it forgets by 1/e in its time: over 60,000 frames of ten
/// taxels with a time of 0.2 s, that is 3,000 independent values each, within four standard errors.
#[test]
fn drift_keeps_its_size_and_forgets() {
    let options = SensorOptions { drift_n: 0.05, drift_time_s: 0.2, ..SensorOptions::off() };
    let mut sensor = sensor(&options);
    let mut products = [0.0; 2];
    let mut before = [[0.0; 10]; 20];
    let frames = 60_000;
    for frame in 0..frames {
        // A force keeps the readings positive.
        (0..10).for_each(|taxel| sensor.press(FOREARM, taxel, 1.0));
        sensor.sample();
        let drift: [f64; 10] = std::array::from_fn(|taxel| sensor.reading_n(FOREARM, taxel) - 1.0);
        for (taxel, value) in drift.iter().enumerate() {
            products[0] += value * value;
            products[1] += value * before[frame % 20][taxel];
        }
        before[frame % 20] = drift;
    }
    let [variance, covariance] = products.map(|sum| sum / (10 * frames) as f64);
    let error = 4.0 * (2.0f64 / 30_000.0).sqrt();
    assert!((variance / 0.0025 - 1.0).abs() < error, "{variance}");
    assert!((covariance / 0.0025 - (-1.0f64).exp()).abs() < error, "{covariance}");
}

/// Tests that a calibrated sensor reads a held force as it is, but for its noise, its quantum and crosstalk, on both kinds of
/// skin, and that the paper's does not.
#[test]
fn a_calibrated_sensor_reads_what_is_there() {
    let error = |model: SensorModel, place: (usize, usize)| {
        let mut sensor = sensor(&SensorOptions { model, ..SensorOptions::default() });
        let held: Vec<f64> = (0..1000).map(|_| press(&mut sensor, place, 10.0)).collect();
        // A second later it is lifted by a fifth.
        let lifted: Vec<f64> = (0..100).map(|_| press(&mut sensor, place, 8.0)).collect();
        (held[999] - 10.0 * crosstalk(place)).abs() + (lifted[99] - 8.0 * crosstalk(place)).abs()
    };
    for place in [(FOREARM, 200), (FLIPPER, 20)] {
        // Six deviations of the fabric's noise, twice.
        assert!(error(SensorModel::Calibrated, place) < 0.2, "{place:?}");
        assert!(error(SensorModel::Paper, place) > 0.5, "{place:?}");
    }
}

/// The share of its force that a taxel keeps.
fn crosstalk((patch, _): (usize, usize)) -> f64 {
    if patch == FOREARM { 0.97 } else { 1.0 }
}
