//! Piezoresistive fabric: a voltage divider that saturates, and hysteresis of the fabric.

use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::converter::{Converter, Noise};
use super::options::FabricOptions;

/// The fabric taxels of one patch. They are separate pieces, so there is no crosstalk.
#[derive(Clone, Serialize, Deserialize)]
pub struct Fabric {
    full_scale_n: f64,
    /// Ratio of reading to force while the force decreases: 1 / (1 − hysteresis share).
    opening_gain: f64,
    /// The force that each piece remembers, N.
    memory_n: Vec<f64>,
    noise: Noise,
    gate_n: f64,
    converter: Converter,
}

impl Fabric {
    /// `taxels` taxels, unloaded.
    pub fn new(options: &FabricOptions, taxels: usize) -> Self {
        Fabric {
            full_scale_n: options.full_scale_n,
            opening_gain: 1.0 / (1.0 - options.hysteresis_share),
            memory_n: vec![0.0; taxels],
            noise: Noise::new(options.noise_n),
            gate_n: options.gate_sigmas * options.noise_n,
            converter: Converter::with_steps_per_n(options.counts_per_n),
        }
    }

    /// Turns the true forces on all taxels into one set of readings, N.
    pub fn read(&mut self, true_force_n: &[f64], reading_n: &mut [f64], random: &mut ChaCha8Rng) {
        for ((force, memory), reading) in true_force_n.iter().zip(&mut self.memory_n).zip(reading_n) {
            // A play operator on the logarithm of the force: the memory follows a rising force at once, and a falling
            // force only once it is lower by the hysteresis share. Without force nothing remains.
            *memory = memory.min(force * self.opening_gain).max(*force).max(0.0);
            // The fabric's conductance is proportional to the force, which in a voltage divider gives F S / (F + S).
            // The driver calibrates only the slope at small forces.
            let divided = *memory / (1.0 + *memory / self.full_scale_n);
            let analog = self.noise.over_gate(divided, self.gate_n, random);
            *reading = analog.map_or(0.0, |analog| self.converter.convert(analog).clamp(0.0, self.full_scale_n));
        }
    }
}
