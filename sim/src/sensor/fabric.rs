//! Piezoresistive fabric: a voltage divider that saturates, and hysteresis of the fabric.
//!
//! With `response = "conductance"` a taxel is what its authors made of it (C. Kemp, `tactile_sensor_model.py`, 2012, in
//! `hrl_fabric_based_tactile_sensor` of the repository gt-ros-pkg/hrl-haptic-manip): parts of the fabric are resistors in
//! parallel, and the resistivity of each falls with its pressure as a logistic curve. Their constants are below.

use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use underbrush_recording::{Taxel, math};

use super::options::{FabricOptions, FabricResponse};
use super::shared::{Noise, quantized};

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
    steps_per_n: f64,
    /// The taxels as voltage dividers; empty if the readings depend on the total force.
    dividers: Vec<Divider>,
}

/// Pressure that saturates the fabric, Pa: 45 N on 40 % of 4 cm × 4 cm.
const SATURATION_PA: f64 = 45.0 / (0.4 * 0.04 * 0.04);

/// Resistance of unpressed fabric times its area, Ω m²: 50 Ω of 4 cm × 4 cm. A smaller taxel has a larger resistance.
const UNPRESSED_OHM_M2: f64 = 50.0 * 0.04 * 0.04;

/// Resistor in series with the taxel, Ω.
const SERIES_OHM: f64 = 47.0;

/// Steps of the converter over the supply voltage: 10 bits.
const STEPS: f64 = 1024.0;

/// Steepness of the logistic curve, per share of the saturation. Pressed fabric has (1 + exp(6 p/P)) / 2 times the conductance
/// of unpressed fabric. The authors add a contact resistance of 1e-5 of the unpressed one; that is 0.2 % at saturation, and left
/// out.
const STEEPNESS: f64 = 6.0;

/// One taxel and its series resistor.
#[derive(Clone, Serialize, Deserialize)]
struct Divider {
    /// The evenly spread force that saturates it, N.
    full_scale_n: f64,
    /// Series resistance over that of the unpressed taxel.
    ratio: f64,
}

impl Divider {
    fn new(area_m2: f64) -> Self {
        Divider { full_scale_n: SATURATION_PA * area_m2, ratio: SERIES_OHM * area_m2 / UNPRESSED_OHM_M2 }
    }

    /// How far an evenly spread force lowers the voltage across the taxel, as a share of the supply voltage.
    fn signal(&self, force_n: f64) -> f64 {
        let conductance = 0.5 + 0.5 * math::exp(STEEPNESS * (force_n / self.full_scale_n).min(1.0));
        1.0 / (1.0 + self.ratio) - 1.0 / (1.0 + self.ratio * conductance)
    }

    /// The evenly spread force of a signal, N, up to the full scale.
    fn force_n(&self, signal: f64) -> f64 {
        let voltage = 1.0 / (1.0 + self.ratio) - signal.clamp(0.0, self.signal(self.full_scale_n));
        let conductance = (1.0 / voltage - 1.0) / self.ratio;
        self.full_scale_n * math::ln((2.0 * conductance - 1.0).max(1.0)) / STEEPNESS
    }

    /// The slope of the signal of an unloaded taxel, 1/N.
    fn slope(&self) -> f64 {
        0.5 * STEEPNESS / self.full_scale_n * self.ratio / (1.0 + self.ratio).powi(2)
    }
}

impl Fabric {
    /// The unloaded taxels of a patch.
    pub fn new(options: &FabricOptions, taxels: &[Taxel]) -> Self {
        let is_divided = options.response == FabricResponse::Conductance;
        Fabric {
            full_scale_n: options.full_scale_n,
            opening_gain: 1.0 / (1.0 - options.hysteresis_share),
            memory_n: vec![0.0; taxels.len()],
            noise: Noise::new(options.noise_n, options.gate_sigmas * options.noise_n),
            gate_n: options.gate_sigmas * options.noise_n,
            steps_per_n: if is_divided && options.counts_per_n > 0.0 { STEPS } else { options.counts_per_n },
            dividers: taxels.iter().filter(|_| is_divided).map(|taxel| Divider::new(taxel.area_m2)).collect(),
        }
    }

    /// Whether the readings depend on where on a taxel a force acts.
    pub fn feels_parts(&self) -> bool {
        !self.dividers.is_empty()
    }

    /// The evenly spread force, N, that gives a taxel the conductance which it has under these `(normal force, area)`, N and m²,
    /// on parts of it. The conductances of the parts add up, and the rest of the taxel is unpressed.
    pub fn even_force_n(&self, taxel: usize, parts: impl Iterator<Item = (f64, f64)>) -> f64 {
        let divider = self.dividers.get(taxel);
        let Some(Divider { full_scale_n, .. }) = divider else { return parts.map(|(force_n, _)| force_n).sum() };
        let gains = parts.map(|(force_n, area_m2)| {
            let most_n = SATURATION_PA * area_m2;
            most_n / full_scale_n * math::exp_m1(STEEPNESS * (force_n / most_n).min(1.0))
        });
        full_scale_n * math::ln_1p(gains.sum()) / STEEPNESS
    }

    /// Turns the true forces on all taxels into one set of readings, N.
    pub fn read(&mut self, true_force_n: &[f64], reading_n: &mut [f64], random: &mut ChaCha8Rng) {
        for (force, memory) in true_force_n.iter().zip(&mut self.memory_n) {
            // A play operator on the logarithm of the force: the memory follows a rising force at once, and a falling
            // force only once it is lower by the hysteresis share. Without force nothing remains.
            *memory = memory.min(force * self.opening_gain).max(*force).max(0.0);
        }
        if self.feels_parts() {
            let noise_n = self.noise.draw(reading_n.len(), random);
            for (((divider, memory), noise_n), reading) in
                self.dividers.iter().zip(&self.memory_n).zip(noise_n).zip(reading_n)
            {
                let analog = divider.signal(*memory) + noise_n * divider.slope();
                let force_n = divider.force_n(quantized(analog, self.steps_per_n));
                *reading = if force_n < self.gate_n { 0.0 } else { force_n };
            }
            return;
        }
        for (reading, memory) in reading_n.iter_mut().zip(&self.memory_n) {
            // The fabric's conductance is proportional to the force, which in a voltage divider gives F S / (F + S).
            // The driver calibrates only the slope at small forces.
            *reading = *memory / (1.0 + *memory / self.full_scale_n);
        }
        self.noise.add(reading_n, random);
        for reading in reading_n.iter_mut().filter(|reading| **reading != 0.0) {
            *reading = quantized(*reading, self.steps_per_n).clamp(0.0, self.full_scale_n);
        }
    }
}
