//! Noise.

use super::*;

/// Tests mean and variance of the noise within three standard errors of those of a normal distribution, that no two
/// taxels share their noise, and that gate, quantum and floor are off at 0.
#[test]
fn noise_has_the_variance_asked_for() {
    let sigma = 0.005;
    // A force far from zero, so that no reading is clamped.
    let (force, frames) = (1.0, 2000);
    let mut sensor = sensor(&SensorOptions { noise_n: sigma, ..SensorOptions::off() });
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
    let variance = deviations.iter().map(|deviation| (deviation - mean).powi(2)).sum::<f64>() / (count - 1.0);
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

/// Tests that a contact on one taxel does not change the noise of another taxel or of the other technology.
#[test]
fn noise_does_not_depend_on_other_taxels() {
    let options = SensorOptions { crosstalk_share: 0.0, ..SensorOptions::default() };
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

/// Tests that switching off the noise of one technology leaves the other's as it is.
#[test]
fn noise_does_not_depend_on_the_noise_of_the_other_technology() {
    let readings = |fabric_noise_n: f64| {
        let options = SensorOptions {
            noise_n: 0.01,
            fabric: FabricOptions { noise_n: fabric_noise_n, ..SensorOptions::off().fabric },
            ..SensorOptions::off()
        };
        let mut sensor = sensor(&options);
        // In a later frame the generator has also drawn for the fabric.
        (0..5).map(|_| press(&mut sensor, (FOREARM, 7), 1.0)).collect::<Vec<f64>>()
    };
    assert_eq!(readings(0.0), readings(0.02));
}

/// Tests that contacts in earlier frames leave the draws of the noise as they are, with both responses of the fabric.
#[test]
fn noise_does_not_depend_on_earlier_contacts() {
    for response in [FabricResponse::TotalForce, FabricResponse::Conductance] {
        let fabric = FabricOptions { noise_n: 0.01, response, ..SensorOptions::off().fabric };
        let options = SensorOptions { noise_n: 0.01, fabric, ..SensorOptions::off() };
        let readings = |touched: bool| {
            let mut sensor = sensor(&options);
            for _ in 0..7 {
                if touched {
                    sensor.press(FOREARM, 3, 2.0);
                    sensor.press(FLIPPER, 20, 5.0);
                }
                sensor.sample();
            }
            [(FOREARM, 3), (FLIPPER, 20)].map(|taxel| press(&mut sensor, taxel, 1.0))
        };
        assert_eq!(readings(true), readings(false), "{response:?}");
    }
}
