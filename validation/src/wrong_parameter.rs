//! A parameter that is wrong on purpose, and the comparisons that must notice it.

use serde::Serialize;

use crate::Comparison;

/// A parameter of the simulated side that is wrong on purpose, as a mistake in a scene file, in an arm file or in the
/// program could make it.
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
