//! One simulated quantity beside its closed form, and parameters that are wrong on purpose, which it must notice.

use serde::Serialize;

/// One simulated quantity beside its closed form.
///
/// ```
/// use underbrush_validation::Comparison;
///
/// let deflection = Comparison::of("deflection of the tip", "m", 0.1, 0.102).relative(0.03, "pieces for a curve");
/// assert!(deflection.passes(1.0));
/// // The two differ by 2 %.
/// assert!(!deflection.passes(0.5));
/// ```
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
    /// A quantity of the simulation beside its closed form. It does not pass before it is said how far apart they may be.
    pub fn of(quantity: impl Into<String>, unit: &'static str, expected: f64, found: f64) -> Self {
        let (residual, quantity) = (f64::NAN, quantity.into());
        Comparison { quantity, unit, expected, found, residual, relative: false, tolerance: 0.0, reason: "" }
    }

    /// Compares |found / expected − 1| with the tolerance.
    #[must_use]
    pub fn relative(self, tolerance: f64, reason: &'static str) -> Self {
        let residual = (self.found / self.expected - 1.0).abs();
        Comparison { residual, relative: true, tolerance, reason, ..self }
    }

    /// Compares |found − expected| with the tolerance.
    #[must_use]
    pub fn absolute(self, tolerance: f64, reason: &'static str) -> Self {
        let residual = (self.found - self.expected).abs();
        Comparison { residual, tolerance, reason, ..self }
    }

    /// Requires `found` ≤ `expected`. The residual is the excess.
    #[must_use]
    pub fn at_most(self, tolerance: f64, reason: &'static str) -> Self {
        // Not `max(0.0)`, which would turn NaN into a pass.
        let residual = if self.found <= self.expected { 0.0 } else { self.found - self.expected };
        Comparison { residual, tolerance, reason, ..self }
    }

    /// Whether the residual is strictly below the scaled tolerance, so that a scale of 0 fails everything. NaN never
    /// passes.
    pub fn passes(&self, tolerance_scale: f64) -> bool {
        self.residual < self.tolerance * tolerance_scale
    }
}

/// A parameter of the simulated side that is wrong on purpose, as a mistake in a scene file, in an arm file or in the
/// program could make it.
///
/// ```
/// use underbrush_validation::Falsification;
///
/// let softer = Falsification::new("bending stiffness", "10 % too low").breaking(&["deflection"]);
/// assert!(softer.must_break("deflection of the tip"));
/// assert!(!softer.must_break("mass of the leaf"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Falsification {
    /// What is wrong.
    pub wrong: &'static str,
    /// By how much.
    pub by: &'static str,
    /// Texts of which each comparison that must fail has one in the name of its quantity; none if all of its case must.
    #[serde(skip)]
    pub breaks: &'static [&'static str],
}

impl Falsification {
    /// A parameter that every comparison of its case must notice.
    pub const fn new(wrong: &'static str, by: &'static str) -> Self {
        Falsification { wrong, by, breaks: &[] }
    }

    /// The same, noticed only by comparisons with one of these texts in the name of their quantity.
    #[must_use]
    pub const fn breaking(self, breaks: &'static [&'static str]) -> Self {
        Falsification { breaks, ..self }
    }

    /// Whether a comparison of this quantity must fail.
    pub fn must_break(&self, quantity: &str) -> bool {
        self.breaks.is_empty() || self.breaks.iter().any(|part| quantity.contains(part))
    }

    /// Parts of names that occur in none of the comparisons' quantities.
    pub(crate) fn unknown_names(&self, comparisons: &[Comparison]) -> impl Iterator<Item = &'static str> {
        let missing = |part: &&str| !comparisons.iter().any(|comparison| comparison.quantity.contains(part));
        self.breaks.iter().copied().filter(missing)
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
