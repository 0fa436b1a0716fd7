//! Check 16: the sensor's statistics and its closed forms.

use underbrush_recording::FRAME_PERIOD_S;
use underbrush_sim::arm::Arm;
use underbrush_sim::sensor::{Sensor, SensorOptions};

use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

/// Check 16.
pub const CHECK: Check = Check {
    name: "sensor",
    summary: "The sensor's noise, quantization, delay, crosstalk, creep and hysteresis match its parameters",
    cases: &[
        Case { compare: noise, falsifications: &[LOUD_NOISE, SPURIOUS_LEFT_ON] },
        Case { compare: quantum, falsifications: &[COARSE_STEPS] },
        Case { compare: delay, falsifications: &[SHORT_DELAY] },
        Case { compare: crosstalk, falsifications: &[DEAD_TAXEL, STRONG_CROSSTALK] },
        Case { compare: creep, falsifications: &[STRONG_CREEP] },
        Case { compare: hysteresis, falsifications: &[WIDE_LOOP] },
    ],
};

const LOUD_NOISE: Falsification =
    Falsification::new("standard deviation of the simulated noise", "5 % too large").breaking(&["variance"]);
const SPURIOUS_LEFT_ON: Falsification =
    Falsification::new("spurious readings of the simulated sensor", "left on, two taxels of 384");
const COARSE_STEPS: Falsification = Falsification::new("quantum of the simulated sensor", "2 mN instead of 1 mN");
const SHORT_DELAY: Falsification = Falsification::new("delay of the simulated sensor", "a frame too short");
const DEAD_TAXEL: Falsification =
    Falsification::new("dead taxels of the simulated sensor", "one instead of none").breaking(&["sum of"]);
const STRONG_CROSSTALK: Falsification =
    Falsification::new("crosstalk of the simulated sensor", "5 % too strong").breaking(&["keeps", "its neighbours"]);
const STRONG_CREEP: Falsification = Falsification::new("creep of the simulated sensor", "5 % too strong");
const WIDE_LOOP: Falsification = Falsification::new("hysteresis of the simulated fabric", "5 % too wide");

const NOISE_N: f64 = 0.005;
const TAXELS: usize = 384;
const FRAMES: usize = 1000;
/// The largest relative error of rounding to single precision, in which readings are reported.
const ROUNDING: f64 = 1.0 / (1 << 24) as f64;
const ROUNDING_REASON: &str = "6.0e-8: readings are rounded to single precision, 2⁻²⁴";

/// The sensor of a patch whose taxels are pressed one by one.
struct Bench {
    sensor: Sensor,
    patch: usize,
}

impl Bench {
    fn new(patch: &str, options: &SensorOptions) -> Result<Self, Fault> {
        let skin = &Arm::cody()?.skin;
        let index = skin.layout.patch_index(patch);
        let patch = index.ok_or_else(|| Fault::Run(format!("the arm has no {patch}")))?;
        Ok(Bench { sensor: Sensor::new(options, skin, 0, "validate", 0), patch })
    }

    /// What a taxel reads in the frame in which it is pressed with a force.
    fn press(&mut self, taxel: usize, force_n: f64) -> f64 {
        self.sensor.press(self.patch, taxel, force_n);
        self.sensor.sample();
        self.sensor.reading_n(self.patch, taxel)
    }
}

fn noise(simulated: Simulated) -> Found {
    let options = SensorOptions {
        noise_n: NOISE_N * simulated.with(LOUD_NOISE, 1.0, 1.05),
        spurious_share: simulated.with(SPURIOUS_LEFT_ON, 0.0, 2.0 / 384.0),
        ..SensorOptions::off()
    };
    let mut bench = Bench::new("forearm", &options)?;
    // A force far from zero, so that nothing is clipped.
    let force = 1.0;
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..FRAMES {
        (0..TAXELS).for_each(|taxel| bench.sensor.press(bench.patch, taxel, force));
        bench.sensor.sample();
        for taxel in 0..TAXELS {
            let deviation = bench.sensor.reading_n(bench.patch, taxel) - force;
            sum += deviation;
            squares += deviation * deviation;
        }
    }
    let count = (FRAMES * TAXELS) as f64;
    let variance = (squares - sum * sum / count) / (count - 1.0);
    Ok(vec![
        Comparison::of("mean of the noise", "N", 0.0, sum / count)
            .absolute(3.0 * NOISE_N / count.sqrt(), "3 σ/√N of N = 384 000 readings"),
        Comparison::of("variance of the noise", "N²", NOISE_N * NOISE_N, variance)
            .relative(3.0 * (2.0 / count).sqrt(), "3 √(2/N) of N = 384 000 normal readings"),
    ])
}

/// Counts the readings that are not the number in single precision nearest to a whole number of millinewtons.
fn quantum(simulated: Simulated) -> Found {
    let options = SensorOptions { quantum_n: 0.001 * simulated.with(COARSE_STEPS, 1.0, 2.0), ..SensorOptions::off() };
    let mut bench = Bench::new("forearm", &options)?;
    let mut wrong = 0.0;
    for step in 0..5000 {
        let force = f64::from(step) * 0.00337;
        let reading = bench.press(7, force);
        let nearest = (force * 1000.0).round() / 1000.0;
        wrong += f64::from(reading != f64::from(nearest as f32));
    }
    let wrong = Comparison::of("readings (of 5000) that are not the number nearest to count / 1000", "", 0.0, wrong);
    Ok(vec![wrong.absolute(1.0, "below 1: none is allowed")])
}

/// The number of frames after which a tap arrives.
fn delay(simulated: Simulated) -> Found {
    let options = SensorOptions { delay_frames: simulated.with(SHORT_DELAY, 3, 2), ..SensorOptions::off() };
    let mut bench = Bench::new("forearm", &options)?;
    let mut forces = (0..20).map(|frame| if frame == 5 { 1.0 } else { 0.0 });
    let arrived = forces.position(|force| bench.press(7, force) > 0.0);
    let found = arrived.map_or(f64::NAN, |frame| frame as f64 - 5.0);
    let reason = "half a frame: a delay is a whole number of frames";
    Ok(vec![Comparison::of("delay of a tap", "frames", 3.0, found).absolute(0.5, reason)])
}

/// A taxel of the forearm with four neighbours, in the middle of the 384 taxels.
const INNER_TAXEL: usize = TAXELS / 2 + 3;

/// Crosstalk of a force on one taxel: the kernel's sum for the taxel where it is farthest from 1, and the shares of a
/// taxel with four neighbours.
fn crosstalk(simulated: Simulated) -> Found {
    let share = 0.2;
    let mut options =
        SensorOptions { crosstalk_share: share * simulated.with(STRONG_CROSSTALK, 1.0, 1.05), ..SensorOptions::off() };
    if simulated.is(DEAD_TAXEL) {
        options.dead_taxels.insert("forearm".into(), vec![7]);
    }
    let mut bench = Bench::new("forearm", &options)?;
    let mut kernel = |taxel: usize| -> Vec<f64> {
        bench.press(taxel, 1.0);
        (0..TAXELS).map(|other| bench.sensor.reading_n(bench.patch, other)).collect()
    };
    let sums = (0..TAXELS).map(|taxel| kernel(taxel).iter().sum::<f64>());
    let worst = sums.max_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs()));
    let inner = kernel(INNER_TAXEL);
    let others = inner.iter().enumerate().filter(|(other, _)| *other != INNER_TAXEL);
    let largest = others.map(|(_, reading)| *reading).fold(0.0, f64::max);
    let compare = |quantity: &str, expected: f64, found: f64| {
        Comparison::of(quantity, "", expected, found).absolute(ROUNDING, ROUNDING_REASON)
    };
    Ok(vec![
        compare("sum of a crosstalk kernel, worst of 384", 1.0, worst.unwrap_or(f64::NAN)),
        compare("share that a taxel with four neighbours keeps", 1.0 - share, inner[INNER_TAXEL]),
        compare("largest share that one of its neighbours receives", share / 4.0, largest),
    ])
}

/// The reading after 20 s under a constant force.
fn creep(simulated: Simulated) -> Found {
    let (share, force) = (0.05, 2.0);
    let options = SensorOptions {
        creep_share_per_decade: share * simulated.with(STRONG_CREEP, 1.0, 1.05),
        ..SensorOptions::off()
    };
    let mut bench = Bench::new("forearm", &options)?;
    let frames = 2000;
    let reading = (0..frames).map(|_| bench.press(7, force)).last();
    let crept = |time_s: f64| 1.0 - (-f64::from(frames) * FRAME_PERIOD_S / time_s).exp();
    let expected = force * (1.0 + share * [0.1, 1.0, 10.0, 100.0].map(crept).iter().sum::<f64>());
    let quantity = "reading of 2 N held for 20 s, F (1 + c Σ (1 − e^(−t/τ)))";
    let found = reading.unwrap_or(f64::NAN);
    Ok(vec![Comparison::of(quantity, "N", expected, found).relative(ROUNDING, ROUNDING_REASON)])
}

/// Area of the fabric's hysteresis loop for a load from 0 to 8 N and back.
fn hysteresis(simulated: Simulated) -> Found {
    let (share, peak, steps) = (0.25, 8.0, 4000);
    let mut options = SensorOptions::off();
    options.fabric.hysteresis_share = share * simulated.with(WIDE_LOOP, 1.0, 1.05);
    let mut bench = Bench::new("flipper", &options)?;
    let step = peak / f64::from(steps);
    let mut way = |steps: &mut dyn Iterator<Item = i32>| -> f64 {
        let readings: Vec<f64> = steps.map(|index| bench.press(7, f64::from(index) * step)).collect();
        readings.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0 * step).sum()
    };
    let up = way(&mut (0..=steps));
    let down = way(&mut (0..=steps).rev());
    let area = Comparison::of("area of the fabric's loop to 8 N, h F²/2", "N²", share * peak * peak / 2.0, down - up);
    Ok(vec![area.relative(1e-6, "1e-6: the trapezoidal rule's error at a corner, the square of one of 4000 steps")])
}
