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

/// Solver of `rapier3d` 0.36.1: `ContactConstraintTangentPart::solve` and `generic_solve`.
const BOX_THAT_ROTATES: &str = "the engine limits K⁻¹ v to μ N, where v is the slip velocity and K⁻¹ the effective mass at the \
     contact point. If the effective mass depends on the direction, as at the corners of a body that can rotate, friction \
     does not oppose the slip exactly: here it is 25° off, and cos 25° = 0.907. It is exact for a body that cannot rotate";

/// All known shortfalls.
pub const SHORTFALLS: &[Shortfall] = &[
    Shortfall {
        check: "friction",
        quantity: "slope at which a free box slips",
        bound: 1.95,
        cause: BOX_THAT_ROTATES,
    },
    Shortfall {
        check: "friction",
        quantity: "acceleration of a free box at 30°",
        bound: 0.223,
        cause: BOX_THAT_ROTATES,
    },
    Shortfall {
        check: "friction",
        quantity: "acceleration of a free box at 45°",
        bound: 0.066,
        cause: BOX_THAT_ROTATES,
    },
    Shortfall {
        check: "friction",
        quantity: "sliding forearm, share of the friction force that opposes the slip",
        bound: 0.0441,
        cause: "the same on an arm, whose effective mass depends on the direction: friction has the right magnitude and is 17° \
                off",
    },
    Shortfall {
        check: "skin-layer",
        quantity: "trunk across the forearm at 2 N, largest taxel",
        bound: 0.0531,
        cause: "the skin model tilts the trunk by 1.3°, so that the taxels, which are 1.8 mm apart, carry no moment about the \
                contact. The closed form has no tilt, and its largest taxel carries more",
    },
    Shortfall {
        check: "free-arm",
        quantity: "largest rise of the energy of the free arm in one step, over the initial energy",
        bound: 2.45e-7,
        cause: "the engine evaluates centrifugal and Coriolis forces at the start of a step, so their work has an error of \
                either sign that is second order in the step",
    },
];
