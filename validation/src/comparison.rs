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

/// A simulated quantity and its closed form, before it is said how far apart they may be.
pub struct Pair {
    quantity: String,
    unit: &'static str,
    expected: f64,
    found: f64,
}

impl Pair {
    /// Compares |found / expected − 1| with the tolerance.
    pub fn relative(self, tolerance: f64, reason: &'static str) -> Comparison {
        let residual = (self.found / self.expected - 1.0).abs();
        Comparison { relative: true, ..self.within(residual, tolerance, reason) }
    }

    /// Compares |found − expected| with the tolerance.
    pub fn absolute(self, tolerance: f64, reason: &'static str) -> Comparison {
        let residual = (self.found - self.expected).abs();
        self.within(residual, tolerance, reason)
    }

    /// Requires `found` ≤ `expected`. The residual is the excess.
    pub fn at_most(self, tolerance: f64, reason: &'static str) -> Comparison {
        // Not `max(0.0)`, which would turn NaN into a pass.
        let residual = if self.found <= self.expected { 0.0 } else { self.found - self.expected };
        self.within(residual, tolerance, reason)
    }

    fn within(self, residual: f64, tolerance: f64, reason: &'static str) -> Comparison {
        let Pair { quantity, unit, expected, found } = self;
        Comparison { quantity, unit, expected, found, residual, relative: false, tolerance, reason }
    }
}

impl Comparison {
    /// A quantity of the simulation beside its closed form.
    pub fn of(quantity: impl Into<String>, unit: &'static str, expected: f64, found: f64) -> Pair {
        Pair { quantity: quantity.into(), unit, expected, found }
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
        let compare = |expected, found| Comparison::of("x", "m", expected, found).relative(0.01, "none");
        assert!(compare(2.0, 2.0).passes(1.0) && !compare(2.0, 2.0).passes(0.0));
        assert!(compare(2.0, 2.01).passes(1.0) && !compare(2.0, 2.01).passes(0.25));
        assert!(!compare(2.0, f64::NAN).passes(1e9) && !compare(0.0, 0.0).passes(1e9));
        let bound = |found| Comparison::of("x", "m", 1.0, found).at_most(0.01, "none");
        assert!(bound(0.5).passes(1.0) && !bound(1.02).passes(1.0) && !bound(f64::NAN).passes(1.0));
    }
}
