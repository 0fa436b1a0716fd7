//! Check 16: the sensor's statistics and its closed forms.

use underbrush_sim::arm::{Arm, Skin};
use underbrush_sim::sensor::{Sensor, SensorOptions};
use underbrush_sim::world::FRAME_PERIOD_S;

use crate::{Check, CheckError, Comparison, Simulated};

/// Check 16.
pub const CHECK: Check = Check {
    number: 16,
    name: "sensor",
    summary: "The sensor's noise, quantum, delay, crosstalk, creep and hysteresis are those asked for",
    falsification: "standard deviation of the noise 5 % too large",
    compare,
};

const NOISE_N: f64 = 0.005;
const TAXELS: usize = 384;
const FRAMES: usize = 1000;
const ROUNDING: &str = "1e-9: exact updates, only rounding is lost";

/// A sensor whose taxels are pressed one by one.
struct Bench {
    sensor: Sensor,
    forearm: usize,
    flipper: usize,
}

impl Bench {
    fn new(skin: &Skin, options: &SensorOptions) -> Result<Self, CheckError> {
        let patch = |name: &str| {
            let index = skin.layout.patch_index(name);
            index.ok_or_else(|| CheckError::Case(format!("the arm has no {name}")))
        };
        Ok(Bench {
            sensor: Sensor::new(options, skin, 0, "validate", 0),
            forearm: patch("forearm")?,
            flipper: patch("flipper")?,
        })
    }

    /// What a taxel reads in the frame in which it is pressed with a force.
    fn press(&mut self, patch: usize, taxel: usize, force_n: f64) -> f64 {
        self.sensor.press(patch, taxel, force_n);
        self.sensor.sample();
        self.sensor.reading_n(patch, taxel)
    }
}

fn compare(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let skin = Arm::cody()?.skin;
    let mut comparisons = noise(&skin, simulated.with(NOISE_N, 1.05 * NOISE_N))?;
    comparisons.extend([
        quantum(&skin)?,
        delay(&skin)?,
        crosstalk(&skin)?,
        creep(&skin)?,
        hysteresis(&skin)?,
    ]);
    Ok(comparisons)
}

fn noise(skin: &Skin, noise_n: f64) -> Result<Vec<Comparison>, CheckError> {
    let mut bench = Bench::new(
        skin,
        &SensorOptions {
            noise_n,
            ..SensorOptions::off()
        },
    )?;
    // A force far from zero, so that nothing is cut.
    let force = 1.0;
    let (mut sum, mut squares) = (0.0, 0.0);
    for _ in 0..FRAMES {
        (0..TAXELS).for_each(|taxel| bench.sensor.press(bench.forearm, taxel, force));
        bench.sensor.sample();
        for taxel in 0..TAXELS {
            let deviation = bench.sensor.reading_n(bench.forearm, taxel) - force;
            sum += deviation;
            squares += deviation * deviation;
        }
    }
    let count = (FRAMES * TAXELS) as f64;
    let variance = (squares - sum * sum / count) / (count - 1.0);
    Ok(vec![
        Comparison::absolute(
            "mean of the noise",
            "N",
            0.0,
            sum / count,
            3.0 * NOISE_N / count.sqrt(),
            "3 σ/√N of N = 384 000 readings",
        ),
        Comparison::relative(
            "variance of the noise",
            "N²",
            NOISE_N * NOISE_N,
            variance,
            3.0 * (2.0 / count).sqrt(),
            "3 √(2/N) of N = 384 000 normal readings",
        ),
    ])
}

/// The largest distance of a reading from the number nearest to its count.
fn quantum(skin: &Skin) -> Result<Comparison, CheckError> {
    let options = SensorOptions {
        quantum_n: 0.001,
        ..SensorOptions::off()
    };
    let mut bench = Bench::new(skin, &options)?;
    let mut wrong = 0.0;
    for step in 0..5000 {
        let force = f64::from(step) * 0.00337;
        let reading = bench.press(bench.forearm, 7, force);
        wrong += f64::from(reading != (force * 1000.0).round() / 1000.0);
    }
    Ok(Comparison::absolute(
        "readings of 5000 that are not the number nearest to count / 1000",
        "",
        0.0,
        wrong,
        1.0,
        "under 1: not one",
    ))
}

/// The frame in which a tap arrives.
fn delay(skin: &Skin) -> Result<Comparison, CheckError> {
    let options = SensorOptions {
        delay_frames: 3,
        ..SensorOptions::off()
    };
    let mut bench = Bench::new(skin, &options)?;
    let forces = (0..20).map(|frame| if frame == 5 { 1.0 } else { 0.0 });
    let readings: Vec<f64> = forces.map(|force| bench.press(bench.forearm, 7, force)).collect();
    let arrived = readings.iter().position(|reading| *reading > 0.0);
    Ok(Comparison::absolute(
        "delay of a tap",
        "frames",
        3.0,
        arrived.map_or(f64::NAN, |frame| frame as f64 - 5.0),
        1.0,
        "under 1: whole frames",
    ))
}

/// The sum of the kernel of the taxel whose sum is farthest from 1.
fn crosstalk(skin: &Skin) -> Result<Comparison, CheckError> {
    let options = SensorOptions {
        crosstalk_share: 0.2,
        ..SensorOptions::off()
    };
    let mut bench = Bench::new(skin, &options)?;
    let sums = (0..TAXELS).map(|taxel| {
        bench.press(bench.forearm, taxel, 1.0);
        (0..TAXELS)
            .map(|other| bench.sensor.reading_n(bench.forearm, other))
            .sum::<f64>()
    });
    let worst = sums.max_by(|a, b| (a - 1.0).abs().total_cmp(&(b - 1.0).abs()));
    Ok(Comparison::absolute(
        "sum of a crosstalk kernel, the worst of 384",
        "",
        1.0,
        worst.unwrap_or(f64::NAN),
        1e-12,
        "1e-12: force is moved, only rounding is lost",
    ))
}

/// The reading after 20 s under a constant force.
fn creep(skin: &Skin) -> Result<Comparison, CheckError> {
    let (share, force) = (0.05, 2.0);
    let options = SensorOptions {
        creep_share_per_decade: share,
        ..SensorOptions::off()
    };
    let mut bench = Bench::new(skin, &options)?;
    let frames = 2000;
    let reading = (0..frames).map(|_| bench.press(bench.forearm, 7, force)).last();
    let crept = |time_s: f64| 1.0 - (-f64::from(frames) * FRAME_PERIOD_S / time_s).exp();
    let expected = force * (1.0 + share * [0.1, 1.0, 10.0, 100.0].map(crept).iter().sum::<f64>());
    Ok(Comparison::relative(
        "reading of 2 N held for 20 s, F (1 + c Σ (1 − e^(−t/τ)))",
        "N",
        expected,
        reading.unwrap_or(f64::NAN),
        1e-9,
        ROUNDING,
    ))
}

/// The area of the fabric's loop to a force and back.
fn hysteresis(skin: &Skin) -> Result<Comparison, CheckError> {
    let (share, peak, steps) = (0.25, 8.0, 4000);
    let mut options = SensorOptions::off();
    options.fabric.hysteresis_share = share;
    let mut bench = Bench::new(skin, &options)?;
    let step = peak / f64::from(steps);
    let mut way = |steps: &mut dyn Iterator<Item = i32>| -> f64 {
        let readings: Vec<f64> = steps
            .map(|index| bench.press(bench.flipper, 7, f64::from(index) * step))
            .collect();
        readings.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0 * step).sum()
    };
    let up = way(&mut (0..=steps));
    let down = way(&mut (0..=steps).rev());
    Ok(Comparison::relative(
        "area of the fabric's loop to 8 N, h F²/2",
        "N²",
        share * peak * peak / 2.0,
        down - up,
        1e-6,
        "1e-6: the square of one of 4000 steps, by which the trapezoidal rule misses a corner",
    ))
}
