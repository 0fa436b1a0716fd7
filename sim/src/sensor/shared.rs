//! The stages that capacitive taxels and those of fabric have in common: bandwidth, gain and drift, which every taxel does to a
//! force before its electronics read it, and the noise and quantization of the electronics.

use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use underbrush_recording::{FRAME_PERIOD_S, math};

use super::options::SensorOptions;
use crate::seed::{Bound, Normal, standard_normals};

/// The transducers of all taxels. Without an effect they hold nothing and draw nothing.
#[derive(Clone, Serialize, Deserialize)]
pub struct Transducers {
    /// Share of a change of force that passes within a frame, 1 − exp(−2π f Δt).
    pass: f64,
    /// The force behind the low-pass filter, N; empty without one.
    filtered_n: Vec<f64>,
    /// Empty without a spread.
    gains: Vec<f64>,
    /// Ornstein-Uhlenbeck process: the share that a frame keeps, and its innovation.
    keep: f64,
    innovation: Noise,
    /// Empty without drift.
    drift_n: Vec<f64>,
    random: ChaCha8Rng,
}

impl Transducers {
    /// The transducers of a reach, unloaded. Gains and the first drift are drawn from `random`, which draws the drift.
    pub fn new(options: &SensorOptions, taxels: usize, mut random: ChaCha8Rng) -> Self {
        let draw_all = |deviation: f64, random: &mut ChaCha8Rng| {
            let count = if deviation > 0.0 { taxels } else { 0 };
            Noise::new(deviation, 0.0).draw(count, random).collect::<Vec<f64>>()
        };
        let gains = draw_all(options.gain_spread_share, &mut random).into_iter().map(math::exp).collect();
        let drift_n = draw_all(options.drift_n, &mut random);
        let keep = math::exp(-FRAME_PERIOD_S / options.drift_time_s);
        let is_limited = options.bandwidth_hz.is_finite();
        Transducers {
            pass: -math::exp_m1(-2.0 * std::f64::consts::PI * options.bandwidth_hz * FRAME_PERIOD_S),
            filtered_n: vec![0.0; if is_limited { taxels } else { 0 }],
            gains,
            keep,
            // The standard deviation then stays the same.
            innovation: Noise::new(options.drift_n * (1.0 - keep * keep).sqrt(), 0.0),
            drift_n,
            random,
        }
    }

    /// Turns the true forces on all taxels, N, into those that the electronics read.
    pub fn apply(&mut self, force_n: &mut [f64]) {
        for (force, filtered) in force_n.iter_mut().zip(&mut self.filtered_n) {
            *filtered += (*force - *filtered) * self.pass;
            *force = *filtered;
        }
        for (force, gain) in force_n.iter_mut().zip(&self.gains) {
            *force *= gain;
        }
        let innovations = self.innovation.draw(self.drift_n.len(), &mut self.random);
        for ((force, drift), innovation) in force_n.iter_mut().zip(&mut self.drift_n).zip(innovations) {
            *drift = *drift * self.keep + innovation;
            *force += *drift;
        }
    }
}

/// White Gaussian noise of one standard deviation for all taxels, and the gate behind it.
#[derive(Clone, Serialize, Deserialize)]
pub struct Noise {
    standard_deviation_n: f64,
    gate_n: f64,
    /// Noise that lifts no reading from the lower half of the gate over it.
    low: Bound,
    /// The second of two draws, for the next reading.
    spare: Option<Normal>,
    /// Buffer of the draws of a frame.
    #[serde(skip)]
    drawn: Vec<[Normal; 2]>,
}

impl Noise {
    /// Noise with this standard deviation and gate, N; 0 switches them off.
    pub fn new(standard_deviation_n: f64, gate_n: f64) -> Self {
        let low = Bound::new(0.5 * gate_n / standard_deviation_n);
        Noise { standard_deviation_n, gate_n, low, spare: None, drawn: Vec::new() }
    }

    /// Draws the noise of this many readings, N.
    pub fn draw(&mut self, count: usize, random: &mut ChaCha8Rng) -> impl Iterator<Item = f64> {
        let deviation_n = self.standard_deviation_n;
        self.normals(count, random).iter().map(move |normal| normal.value() * deviation_n)
    }

    /// Adds noise to the readings, N. Those whose size is then below the gate become 0.
    pub fn add(&mut self, reading_n: &mut [f64], random: &mut ChaCha8Rng) {
        let Noise { standard_deviation_n, gate_n, low, .. } = *self;
        let normals = self.normals(reading_n.len(), random);
        for (reading, normal) in reading_n.iter_mut().zip(normals) {
            if low.holds(*normal) && reading.abs() <= 0.5 * gate_n {
                *reading = 0.0;
                continue;
            }
            *reading += normal.value() * standard_deviation_n;
            if reading.abs() < gate_n {
                *reading = 0.0;
            }
        }
    }

    /// The next draws. Numbers are drawn even if the noise is off, so that the noise of one technology does not depend on
    /// whether the other has any.
    fn normals(&mut self, count: usize, random: &mut ChaCha8Rng) -> &[Normal] {
        let spare = self.spare.take();
        let pairs = count.saturating_sub(usize::from(spare.is_some())).div_ceil(2);
        // The first pair has place for the spare.
        self.drawn.resize(1 + pairs, [Normal::default(); 2]);
        standard_normals(random, &mut self.drawn[1..]);
        let first = match spare {
            Some(spare) => {
                self.drawn[0][1] = spare;
                1
            }
            None => 2,
        };
        let drawn = self.drawn.as_flattened();
        self.spare = drawn.get(first + count).copied();
        &drawn[first..first + count]
    }
}

/// Steps per newton of a converter with steps of this size, N; 0 switches quantization off.
pub fn steps_per_n(quantum_n: f64) -> f64 {
    if quantum_n == 0.0 {
        return 0.0;
    }
    let steps = 1.0 / quantum_n;
    // The floating-point number 0.001 is not exactly a thousandth. With a whole number of steps per newton,
    // a reading is the number that is nearest to count / steps, and prints with few digits.
    let whole = steps.round();
    let is_whole = (steps - whole).abs() <= 4.0 * f64::EPSILON * steps;
    if is_whole { whole } else { steps }
}

/// The value of a converter that is nearest to a reading, N. With 0 steps per newton it is the reading.
pub fn quantized(reading_n: f64, steps_per_n: f64) -> f64 {
    if steps_per_n > 0.0 { (reading_n * steps_per_n).round() / steps_per_n } else { reading_n }
}
