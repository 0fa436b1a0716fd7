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
    /// The comparisons of its case that must fail.
    #[serde(skip)]
    pub breaks: Breaks,
}

/// Which comparisons of a case a falsification must break.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Breaks {
    /// Every one.
    Every,
    /// Those with one of these texts in the name of their quantity.
    Named(&'static [&'static str]),
}

impl Falsification {
    /// Whether a comparison of this quantity must fail.
    pub fn must_break(&self, quantity: &str) -> bool {
        match self.breaks {
            Breaks::Every => true,
            Breaks::Named(parts) => parts.iter().any(|part| quantity.contains(part)),
        }
    }

    /// Parts of names that occur in none of the comparisons' quantities.
    pub(crate) fn unknown_names(&self, comparisons: &[Comparison]) -> impl Iterator<Item = &'static str> {
        let named = match self.breaks {
            Breaks::Every => &[],
            Breaks::Named(parts) => parts,
        };
        named.iter().copied().filter(|part| !comparisons.iter().any(|comparison| comparison.quantity.contains(part)))
    }
}
