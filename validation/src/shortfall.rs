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
pub const SHORTFALLS: &[Shortfall] = &[Shortfall {
    check: "standing-bottle",
    quantity: "bottle pushed at 48 cm, force at which it tips over",
    bound: 0.024,
    cause: "not found. It depends on the direction of the push: 2.2 % too high along x, within 0.8 % in two others. Lost ends of \
            the patch, the size of the table and the quadrature (0.2 %) were ruled out",
}];
