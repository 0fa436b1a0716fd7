//! The one list of tolerances that are not met, with how far they are missed and why.

use serde::Serialize;

/// A tolerance that is known not to be met. It does not count as a pass; it fails only when it gets worse.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Shortfall {
    /// Name of the check.
    pub check: &'static str,
    /// The quantity that misses.
    pub quantity: &'static str,
    /// The residual must stay under this: what was measured, and a twentieth more for other machines.
    pub bound: f64,
    /// Why it misses.
    pub cause: &'static str,
}

/// Solver of `rapier3d` 0.36.1: `ContactConstraintTangentPart::solve` and `generic_solve`.
const BOX_THAT_TURNS: &str = "the engine limits K⁻¹ v to μ N, where v is the slip and K⁻¹ the effective mass of the contact \
     point; where that differs with the direction, as at the corners of a body that can turn, friction is not opposite to \
     the slip: it is 25° off here, and cos 25° is 0.907. It is exact where the body cannot turn";

/// All known shortfalls.
pub const SHORTFALLS: &[Shortfall] = &[
    Shortfall {
        check: "friction",
        quantity: "slope at which a free box slips",
        bound: 1.95,
        cause: BOX_THAT_TURNS,
    },
    Shortfall {
        check: "friction",
        quantity: "acceleration of a free box at 30°",
        bound: 0.223,
        cause: BOX_THAT_TURNS,
    },
    Shortfall {
        check: "friction",
        quantity: "acceleration of a free box at 45°",
        bound: 0.066,
        cause: BOX_THAT_TURNS,
    },
    Shortfall {
        check: "friction",
        quantity: "sliding forearm, share of the friction that opposes the slip",
        bound: 0.0441,
        cause: "the same on an arm, whose effective mass differs with the direction: friction has the right size and is 17° \
                off",
    },
    Shortfall {
        check: "skin-layer",
        quantity: "trunk across the forearm at 2 N, largest taxel",
        bound: 0.0531,
        cause: "the skin's model tilts the trunk by 1.3°, so that the taxels, which have gaps of 1.8 mm between them, carry no \
                moment about the contact; the closed form has no tilt, and its largest taxel carries more",
    },
    Shortfall {
        check: "free-arm",
        quantity: "largest rise of the energy of the free arm in one step, of the energy at the start",
        bound: 2.45e-7,
        cause: "the engine takes centrifugal and Coriolis forces as they are at the start of a step, so their work has an \
                error of either sign that goes with the square of the step",
    },
];
