//! What every taxel's electronics have: noise, and steps of a converter.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// White Gaussian noise of one standard deviation for all taxels.
#[derive(Clone)]
pub struct Noise {
    standard_deviation_n: f64,
}

impl Noise {
    /// Noise of this standard deviation, N; none at 0.
    pub fn new(standard_deviation_n: f64) -> Self {
        Noise { standard_deviation_n }
    }

    /// The noise of one reading, N. It is drawn even where it is 0, so that the noise of one technology does not depend on
    /// whether the other has any.
    pub fn draw(&self, random: &mut ChaCha8Rng) -> f64 {
        let deviations: f64 = StandardNormal.sample(random);
        deviations * self.standard_deviation_n
    }
}

/// Rounds readings to steps.
#[derive(Clone)]
pub struct Converter {
    steps_per_n: f64,
}

impl Converter {
    /// Steps of this size, N; none at 0.
    pub fn with_quantum(quantum_n: f64) -> Self {
        if quantum_n == 0.0 {
            return Converter { steps_per_n: 0.0 };
        }
        let steps = 1.0 / quantum_n;
        // The nearest number to 0.001 is not a thousandth: with whole steps per newton, readings are the numbers
        // nearest to count / steps, which print as short as they are.
        let whole = steps.round();
        let is_whole = (steps - whole).abs() <= 4.0 * f64::EPSILON * steps;
        Converter {
            steps_per_n: if is_whole { whole } else { steps },
        }
    }

    /// So many steps per newton; none at 0.
    pub fn with_steps_per_n(steps_per_n: f64) -> Self {
        Converter { steps_per_n }
    }

    /// The step nearest to a reading, N.
    pub fn convert(&self, reading_n: f64) -> f64 {
        if self.steps_per_n > 0.0 {
            (reading_n * self.steps_per_n).round() / self.steps_per_n
        } else {
            reading_n
        }
    }
}
