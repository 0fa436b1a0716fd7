//! What every taxel does to a force before its electronics read it: bandwidth, gain and drift.

use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use underbrush_recording::{FRAME_PERIOD_S, math};

use super::converter::Noise;
use super::options::SensorOptions;

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
            let mut noise = Noise::new(deviation);
            let count = if deviation > 0.0 { taxels } else { 0 };
            (0..count).map(|_| noise.draw(random)).collect::<Vec<f64>>()
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
            innovation: Noise::new(options.drift_n * (1.0 - keep * keep).sqrt()),
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
        for (force, drift) in force_n.iter_mut().zip(&mut self.drift_n) {
            *drift = *drift * self.keep + self.innovation.draw(&mut self.random);
            *force += *drift;
        }
    }
}
