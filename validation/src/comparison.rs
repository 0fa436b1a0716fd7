//! One simulated quantity beside its closed form.

use serde::Serialize;

/// One simulated quantity beside its closed form.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// What is compared.
    pub quantity: String,
    /// Unit of the two values; empty for numbers.
    pub unit: &'static str,
    /// The closed-form value.
    pub expected: f64,
    /// The simulated value.
    pub found: f64,
    /// How far apart they are: in `unit`, or relative to the expected value.
    pub residual: f64,
    /// Whether residual and tolerance are relative to the expected value.
    pub relative: bool,
    /// The residual must stay under this.
    pub tolerance: f64,
    /// Where the tolerance comes from.
    pub reason: &'static str,
}

impl Comparison {
    /// Compares |found / expected − 1| with the tolerance.
    pub fn relative(
        quantity: impl Into<String>,
        unit: &'static str,
        expected: f64,
        found: f64,
        tolerance: f64,
        reason: &'static str,
    ) -> Self {
        Comparison {
            quantity: quantity.into(),
            unit,
            expected,
            found,
            residual: (found / expected - 1.0).abs(),
            relative: true,
            tolerance,
            reason,
        }
    }

    /// Compares |found − expected| with the tolerance.
    pub fn absolute(
        quantity: impl Into<String>,
        unit: &'static str,
        expected: f64,
        found: f64,
        tolerance: f64,
        reason: &'static str,
    ) -> Self {
        Comparison {
            residual: (found - expected).abs(),
            relative: false,
            ..Comparison::relative(quantity, unit, expected, found, tolerance, reason)
        }
    }

    /// Requires `found` ≤ `bound`. The residual is the excess.
    pub fn at_most(
        quantity: impl Into<String>,
        unit: &'static str,
        bound: f64,
        found: f64,
        tolerance: f64,
        reason: &'static str,
    ) -> Self {
        Comparison {
            // Not `max(0.0)`, which would turn NaN into a pass.
            residual: if found <= bound { 0.0 } else { found - bound },
            relative: false,
            ..Comparison::relative(quantity, unit, bound, found, tolerance, reason)
        }
    }

    /// Whether the residual is strictly below the scaled tolerance, so that a scale of 0 fails everything. NaN never
    /// passes.
    pub fn passes(&self, tolerance_scale: f64) -> bool {
        self.residual < self.tolerance * tolerance_scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that equality passes except at scale 0, and that NaN never passes.
    #[test]
    fn only_numbers_under_the_tolerance_pass() {
        let compare = |expected, found| Comparison::relative("x", "m", expected, found, 0.01, "none");
        assert!(compare(2.0, 2.0).passes(1.0) && !compare(2.0, 2.0).passes(0.0));
        assert!(compare(2.0, 2.01).passes(1.0) && !compare(2.0, 2.01).passes(0.25));
        assert!(!compare(2.0, f64::NAN).passes(1e9) && !compare(0.0, 0.0).passes(1e9));
        let bound = |found| Comparison::at_most("x", "m", 1.0, found, 0.01, "none");
        assert!(bound(0.5).passes(1.0) && !bound(1.02).passes(1.0) && !bound(f64::NAN).passes(1.0));
    }
}
