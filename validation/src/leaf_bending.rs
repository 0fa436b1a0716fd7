//! Checks 1 and 2: leaves under loads at their tips, small and large.

use std::f64::consts::PI;

use glam::DVec3;
use underbrush_oracles::{beam, chain};

use crate::leaf_case::{ClampedLeaf, LENGTH_M, RIGIDITY_N_M2, STIFF_BLADE, blade};
use crate::{Case, Check, Comparison, Falsification, Fault, Found, Simulated};

/// Check 1.
pub const SMALL_LOAD: Check = Check {
    name: "leaf-small-load",
    summary: "A small load at the tip bends a leaf like a beam; a load lower down bends it like the discrete chain of hinges",
    cases: &[
        Case { compare: tip_load, falsifications: &[STIFF_BLADE] },
        Case { compare: load_below_tip, falsifications: &[STIFF_BLADE, FEWER_HINGES] },
    ],
};

/// Check 2.
pub const LARGE_DEFLECTION: Check = Check {
    name: "leaf-large-deflection",
    summary: "A leaf under a large load follows the elastica, and an end moment bends it into a circular arc",
    cases: &[Case { compare: large_deflection, falsifications: &[STIFF_BLADE] }],
};

const FEWER_HINGES: Falsification = Falsification::new("hinges of the simulated leaf", "one fewer than described");

/// Step of the engine, s. It can be as long as 10 ms, because states of rest do not depend on it.
const STEP_S: f64 = 0.01;
/// A load that bends the leaf by a hundredth of its length.
const SMALL_LOAD_N: f64 = 0.002;

/// A loss factor of 1 brings a leaf to rest quickly. The state of rest does not depend on it.
fn damped_leaf(segments: u32, simulated: Simulated) -> ClampedLeaf {
    let rigidity = RIGIDITY_N_M2 * simulated.with(STIFF_BLADE, 1.0, 1.05);
    ClampedLeaf::new(&blade(segments, rigidity, 1.0), STEP_S)
}

/// The positions of the hinges do not contribute to this tolerance: n ≥ 2 Gauss-Legendre hinges integrate (L − x)², on
/// which the tip's deflection depends, exactly (`chain` in the oracles). The next term of the elastica remains, 9e-6 at
/// this load. It is doubled, because the chain's next term differs a little from the strip's.
fn small_load_tolerance() -> f64 {
    2.0 * beam::small_load_error(SMALL_LOAD_N * LENGTH_M.powi(2) / RIGIDITY_N_M2)
}

fn tip_load(simulated: Simulated) -> Found {
    let compare = |segments: u32| -> Result<Comparison, Fault> {
        let found = damped_leaf(segments, simulated).settle(DVec3::X * SMALL_LOAD_N, DVec3::ZERO)?;
        let quantity = format!("tip deflection, {segments} hinges, against the beam");
        let expected = beam::beam_deflection_m(SMALL_LOAD_N, LENGTH_M, RIGIDITY_N_M2);
        let reason = "twice (4/35) (P L² / E I)², the next term of the elastica: Gauss-Legendre hinges are exact for a \
                      small tip load";
        Ok(Comparison::of(quantity, "m", expected, found.x).relative(small_load_tolerance(), reason))
    };
    [2, 4, 8, 16].into_iter().map(compare).collect()
}

fn load_below_tip(simulated: Simulated) -> Found {
    let height_m = 0.6 * LENGTH_M;
    let compare = |hinges: u32| -> Result<Comparison, Fault> {
        let expected = chain::deflection_m(SMALL_LOAD_N, height_m, LENGTH_M, RIGIDITY_N_M2, hinges)
            .ok_or_else(|| Fault::Run(format!("no table of nodes for {hinges} hinges")))?;
        let mut leaf = damped_leaf(simulated.with(FEWER_HINGES, hinges, hinges - 1), simulated);
        let quantity = format!("deflection by a load at 0.6 of the height, {hinges} hinges, against the sum over them");
        let found = leaf.settle_at(DVec3::X * SMALL_LOAD_N, height_m)?;
        let reason = "the same: the sum over the published Gauss nodes is exact for the chain";
        Ok(Comparison::of(quantity, "m", expected, found).relative(small_load_tolerance(), reason))
    };
    [4, 8].into_iter().map(compare).collect()
}

fn large_deflection(simulated: Simulated) -> Found {
    let reason = "1.5 (π²/24n²) ∫ s (1−s) κ² ds: the leading error of a chain with Gauss-Legendre hinges, and half as much again \
                  because it changes the lever";
    let mut comparisons = Vec::new();
    let mut compare = |what: String, segments: u32, bending: f64, expected: beam::Tip, found: DVec3| {
        let tolerance = 1.5 * chain::far_bending_error(bending, segments);
        for (direction, expected, found) in [
            ("sideways", expected.sideways, found.x / LENGTH_M),
            ("shortening", expected.shortening, 1.0 - found.z / LENGTH_M),
        ] {
            let quantity = format!("{what}, {segments} hinges: {direction} in lengths");
            comparisons.push(Comparison::of(quantity, "", expected, found).absolute(tolerance, reason));
        }
    };
    for (load, segments) in [(0.45, 8), (1.0, 8), (2.0, 8), (3.0, 8), (3.0, 20)] {
        let force_n = load * RIGIDITY_N_M2 / LENGTH_M.powi(2);
        let tip = damped_leaf(segments, simulated).settle(DVec3::X * force_n, DVec3::ZERO)?;
        let bending = chain::tip_load_bending(load);
        let expected = beam::under_tip_load(load);
        compare(format!("P L² / E I = {load}"), segments, bending, expected, tip);
    }
    for (angle, name, segments) in [(PI / 2.0, "quarter", 8), (PI, "half", 20)] {
        let moment_nm = angle * RIGIDITY_N_M2 / LENGTH_M;
        let tip = damped_leaf(segments, simulated).settle(DVec3::ZERO, DVec3::Y * moment_nm)?;
        let (bending, expected) = (chain::arc_bending(angle), beam::under_end_moment(angle));
        compare(format!("end moment, {name} circle"), segments, bending, expected, tip);
    }
    Ok(comparisons)
}
