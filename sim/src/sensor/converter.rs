//! What the electronics of all taxels have in common: noise and quantization.

use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::seed::{Normal, standard_normals};

/// White Gaussian noise of one standard deviation for all taxels.
#[derive(Clone, Serialize, Deserialize)]
pub struct Noise {
    standard_deviation_n: f64,
    /// The second of two draws, for the next reading.
    spare: Option<Normal>,
}

impl Noise {
    /// Noise with this standard deviation, N; 0 switches it off.
    pub fn new(standard_deviation_n: f64) -> Self {
        Noise { standard_deviation_n, spare: None }
    }

    /// Draws the noise of one reading, N.
    pub fn draw(&mut self, random: &mut ChaCha8Rng) -> f64 {
        self.next(random).value() * self.standard_deviation_n
    }

    /// Draws the noise of a reading of `clean_n` (N), and adds it; `None` if the sum is smaller than `gate_n`, N.
    pub fn over_gate(&mut self, clean_n: f64, gate_n: f64, random: &mut ChaCha8Rng) -> Option<f64> {
        let normal = self.next(random);
        if normal.is_within(gate_n - clean_n.abs(), self.standard_deviation_n) {
            return None;
        }
        let reading_n = clean_n + normal.value() * self.standard_deviation_n;
        (reading_n.abs() >= gate_n).then_some(reading_n)
    }

    /// A number is drawn even if the noise is off, so that the noise of one technology does not depend on whether the other
    /// has any.
    fn next(&mut self, random: &mut ChaCha8Rng) -> Normal {
        self.spare.take().unwrap_or_else(|| {
            let [first, second] = standard_normals(random);
            self.spare = Some(second);
            first
        })
    }
}

/// Quantizes readings.
#[derive(Clone, Serialize, Deserialize)]
pub struct Converter {
    /// Steps per newton; 0 switches quantization off.
    pub steps_per_n: f64,
}

impl Converter {
    /// Steps of this size, N; 0 switches quantization off.
    pub fn with_quantum(quantum_n: f64) -> Self {
        if quantum_n == 0.0 {
            return Converter { steps_per_n: 0.0 };
        }
        let steps = 1.0 / quantum_n;
        // The floating-point number 0.001 is not exactly a thousandth. With a whole number of steps per newton,
        // a reading is the number that is nearest to count / steps, and prints with few digits.
        let whole = steps.round();
        let is_whole = (steps - whole).abs() <= 4.0 * f64::EPSILON * steps;
        Converter { steps_per_n: if is_whole { whole } else { steps } }
    }

    /// The quantized value nearest to a reading, N.
    pub fn convert(&self, reading_n: f64) -> f64 {
        if self.steps_per_n > 0.0 { (reading_n * self.steps_per_n).round() / self.steps_per_n } else { reading_n }
    }
}
