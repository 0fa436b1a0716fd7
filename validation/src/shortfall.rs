//! The tolerances that are not met, by how much, and why.

use serde::Serialize;

/// A tolerance that is known not to be met. It does not count as a pass, and fails only when it gets worse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Shortfall {
    /// Name of the check.
    pub check: &'static str,
    /// The quantity that misses its tolerance.
    pub quantity: &'static str,
    /// The residual must stay below this: the measured value plus 5 % for other machines.
    pub bound: f64,
    /// Why it misses.
    pub cause: &'static str,
}

/// All known shortfalls.
pub const SHORTFALLS: &[Shortfall] = &[];
