//! Tests of the sensor against closed forms and the statistics of its noise: the effects that both technologies share
//! are here, and each other effect has its own file.

mod capacitive;
mod fabric;
mod noise;
mod spurious;
mod transducer;

use std::collections::BTreeMap;

use proptest::prelude::*;
use underbrush_recording::FRAME_PERIOD_S;

use super::{FabricOptions, FabricResponse, Sensor, SensorModel, SensorOptions};
use crate::arm::Arm;

/// Patches of Cody's skin.
const FOREARM: usize = 0;
const FLIPPER: usize = 1;
const COLUMNS: usize = 24;

fn sensor(options: &SensorOptions) -> Sensor {
    Sensor::new(options, &Arm::cody().unwrap().skin, 1, "test", 0)
}

/// The largest relative error of a number that is rounded to single precision.
const ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// The nearest number in single precision.
fn single(number: f64) -> f64 {
    f64::from(number as f32)
}

/// Presses one taxel with a force for a frame and returns its reading.
fn press(sensor: &mut Sensor, (patch, taxel): (usize, usize), force_n: f64) -> f64 {
    sensor.press(patch, taxel, force_n);
    sensor.sample();
    sensor.reading_n(patch, taxel)
}

proptest! {
    /// Tests that readings are the true forces in single precision with the ideal model and with each effect switched off by
    /// itself.
    #[test]
    fn what_is_off_changes_nothing(force in 0.0..100.0f64, taxel in 0usize..69) {
        let ideal = SensorOptions { model: SensorModel::Ideal, ..SensorOptions::default() };
        for options in [ideal, SensorOptions::off()] {
            let mut sensor = sensor(&options);
            prop_assert_eq!(press(&mut sensor, (FOREARM, taxel), force), single(force));
            prop_assert_eq!(press(&mut sensor, (FLIPPER, taxel), force), single(force));
        }
    }

    /// Tests that readings are counts: the number nearest to count / 1000, whatever the rounding of 0.001 itself, and
    /// never farther from the force than half a quantum.
    #[test]
    fn readings_are_the_nearest_thousandths(force in 0.0..16.9f64) {
        let mut sensor = sensor(&SensorOptions { quantum_n: 0.001, ..SensorOptions::off() });
        let reading = press(&mut sensor, (FOREARM, 100), force);
        prop_assert!((reading - force).abs() <= 0.0005 + 17.0 * ROUNDING);
        let nearest: f64 = format!("{reading:.3}").parse().unwrap();
        prop_assert_eq!(reading, single(nearest));
    }
}

/// Tests that an untouched taxel reads 0 with a gate of six sigmas (it fails with a probability of 2e-9 per reading),
/// that a force over the gate is read, and where floor and saturation cut.
#[test]
fn gate_floor_and_saturation_cut_where_they_say() {
    let mut gated = sensor(&SensorOptions { noise_n: 0.005, gate_sigmas: 6.0, ..SensorOptions::off() });
    for _ in 0..100 {
        gated.sample();
        assert!((0..384).all(|taxel| gated.reading_n(FOREARM, taxel) == 0.0));
    }
    // Ten sigmas over the gate.
    assert!(press(&mut gated, (FOREARM, 0), 0.08) > 0.03);
    let mut cut = sensor(&SensorOptions { floor_n: 1.0, saturation_n: 17.0, ..SensorOptions::off() });
    let readings = [0.99, 1.01, 16.5, 17.5].map(|force| press(&mut cut, (FOREARM, 0), force));
    assert_eq!(readings, [0.0, single(1.01), 16.5, 17.0]);
}

/// Tests that readings are delayed by the requested number of frames, and start at 0.
#[test]
fn readings_are_late_by_whole_frames() {
    for delay_frames in [0, 1, 3] {
        let mut sensor = sensor(&SensorOptions { delay_frames, ..SensorOptions::off() });
        let forces: Vec<f64> = (1..20).map(f64::from).collect();
        let readings: Vec<f64> = forces.iter().map(|force| press(&mut sensor, (FLIPPER, 5), *force)).collect();
        let delay = delay_frames as usize;
        assert!(readings[..delay].iter().all(|reading| *reading == 0.0));
        assert_eq!(readings[delay..], forces[..forces.len() - delay]);
    }
}

/// Tests dead taxels: those listed always, and the requested share of the others (within three sigmas of a binomial),
/// which differ from reach to reach and are the same for the same reach. The noise of the other taxels does not change.
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
        let all = || (0..384).map(|taxel| (FOREARM, taxel)).chain((0..69).map(|taxel| (FLIPPER, taxel)));
        all().for_each(|(patch, taxel)| sensor.press(patch, taxel, 1.0));
        sensor.sample();
        all().map(|(patch, taxel)| sensor.reading_n(patch, taxel) == 0.0).collect::<Vec<bool>>()
    };
    let reaches: Vec<Vec<bool>> = (0..20).map(dead_in).collect();
    assert!(reaches.iter().all(|dead| dead[384 + 4]));
    assert_eq!(reaches[0], dead_in(0));
    assert_ne!(reaches[0], reaches[1]);
    // Without the one listed taxel of each reach.
    let drawn = reaches.iter().flatten().filter(|dead| **dead).count() as f64 - 20.0;
    let trials = 20.0 * 452.0;
    assert!((drawn - 0.2 * trials).abs() < 3.0 * (trials * 0.2 * 0.8f64).sqrt(), "{drawn} of {trials}");
    let noisy = SensorOptions { noise_n: 0.01, ..SensorOptions::off() };
    let one_dead = SensorOptions { dead_taxels: BTreeMap::from([("forearm".to_string(), vec![9])]), ..noisy.clone() };
    let (mut whole, mut broken) = (sensor(&noisy), sensor(&one_dead));
    assert_eq!(press(&mut broken, (FOREARM, 10), 1.0), press(&mut whole, (FOREARM, 10), 1.0));
    assert_eq!(press(&mut broken, (FOREARM, 9), 1.0), 0.0);
}

/// Tests that listing a dead taxel does not change which others are dead.
#[test]
fn a_listed_taxel_does_not_redraw_the_others() {
    let skin = Arm::cody().unwrap().skin;
    let dead_with = |listed: &[u16]| {
        let options = SensorOptions {
            dead_share: 0.3,
            dead_taxels: BTreeMap::from([("forearm".to_string(), listed.to_vec())]),
            ..SensorOptions::off()
        };
        Sensor::new(&options, &skin, 1, "test", 0).dead
    };
    let none = dead_with(&[]);
    let living = none.iter().position(|dead| !dead).unwrap();
    let mut expected = none.clone();
    expected[living] = true;
    assert_eq!(dead_with(&[living as u16]), expected);
}

/// Tests that options outside their limits and dead taxels that the skin does not have are found, by key.
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
    let repeated = SensorOptions {
        dead_taxels: BTreeMap::from([("forearm".to_string(), vec![0; 385])]),
        ..SensorOptions::default()
    };
    for options in [with_dead("forearm", 384), with_dead("elbow", 0), repeated] {
        assert_eq!(fault(options).as_deref(), Some("dead_taxels"));
    }
    let fabric = FabricOptions { hysteresis_share: 1.0, ..FabricOptions::default() };
    let options = SensorOptions { fabric, ..SensorOptions::default() };
    assert_eq!(fault(options).as_deref(), Some("fabric.hysteresis_share"));
    let options = SensorOptions { creep_share_per_decade: -0.1, ..SensorOptions::default() };
    assert_eq!(fault(options).as_deref(), Some("creep_share_per_decade"));
}
