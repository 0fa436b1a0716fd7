//! What the skin's electronics make of a taxel's true force.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Options of the sensor, for every patch alike; `perfect = true` switches all of it off.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SensorOptions {
    /// The sensed force is the true force.
    pub perfect: bool,
    /// Standard deviation of a taxel's noise, N.
    pub noise_n: f64,
    /// Deviations under this many standard deviations of the noise read 0 (the authors' driver: 6).
    pub gate_sigmas: f64,
    /// Smallest step of a reading, N (the authors' driver: counts / 1000).
    pub quantum_n: f64,
    /// Largest force that a taxel can tell, N (17 on the robot); larger ones read as this.
    pub saturation_n: f64,
    /// Readings under this many newtons read 0; off at 0 (the authors' optional floor: 1.0).
    pub floor_n: f64,
}

impl Default for SensorOptions {
    /// Gate, quantum and saturation are the authors'. The noise is a choice: it puts the gate at 30 mN, just above the
    /// smallest stray readings (20–100 mN) of a stored frame of the real skin.
    fn default() -> Self {
        SensorOptions {
            perfect: false,
            noise_n: 0.005,
            gate_sigmas: 6.0,
            quantum_n: 0.001,
            saturation_n: 17.0,
            floor_n: 0.0,
        }
    }
}

impl SensorOptions {
    /// What is wrong with the options, if anything: `(key, found, allowed)`.
    pub fn fault(&self) -> Option<(&'static str, String, &'static str)> {
        [
            ("noise_n", self.noise_n),
            ("gate_sigmas", self.gate_sigmas),
            ("quantum_n", self.quantum_n),
            ("floor_n", self.floor_n),
        ]
        .into_iter()
        .find(|(_, value)| !(value.is_finite() && *value >= 0.0))
        .map(|(key, value)| (key, value.to_string(), "a finite number of zero or more"))
        .or_else(|| {
            (self.saturation_n.is_nan() || self.saturation_n <= 0.0)
                .then(|| ("saturation_n", self.saturation_n.to_string(), "a positive number"))
        })
    }
}

/// The sensor of one reach.
pub struct Sensor {
    options: SensorOptions,
    random: ChaCha8Rng,
    noise: Option<Normal<f64>>,
}

impl Sensor {
    /// A sensor with its own stream of noise.
    pub fn new(options: SensorOptions, random: ChaCha8Rng) -> Self {
        let noise = Normal::new(0.0, options.noise_n).ok().filter(|_| options.noise_n > 0.0);
        Sensor { options, random, noise }
    }

    /// Reads one taxel: its true normal force in, its sensed force out, both N.
    ///
    /// Every taxel must be read in every frame, in the same order, so that the noise of one does not depend on what
    /// touches another.
    pub fn read(&mut self, true_force_n: f64) -> f64 {
        let options = &self.options;
        if options.perfect {
            return true_force_n;
        }
        let noise = self.noise.map_or(0.0, |noise| noise.sample(&mut self.random));
        let reading = true_force_n + noise;
        if reading.abs() < options.gate_sigmas * options.noise_n || reading < options.floor_n {
            return 0.0;
        }
        let steps = if options.quantum_n > 0.0 {
            (reading / options.quantum_n).round() * options.quantum_n
        } else {
            reading
        };
        steps.clamp(0.0, options.saturation_n)
    }
}
