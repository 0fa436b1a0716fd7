//! Checks 1 and 2: leaves under loads at their tips, small and large.

use std::f64::consts::PI;

use glam::DVec3;
use underbrush_oracles::{beam, elastica};

use crate::leaf_case::{ClampedLeaf, LENGTH_M, RIGIDITY_N_M2, blade};
use crate::{Check, CheckError, Comparison, Simulated};

/// Check 1.
pub const SMALL_LOAD: Check = Check {
    number: 1,
    name: "leaf-small-load",
    summary: "A leaf under a small tip load bends as the sum over its hinges says, and as a beam",
    falsification: "E I of the simulated leaf 5 % too high",
    compare: small_load,
};

/// Check 2.
pub const LARGE_DEFLECTION: Check = Check {
    number: 2,
    name: "leaf-large-deflection",
    summary: "A leaf bent far follows the elastica, and an end moment bends it to an arc",
    falsification: "E I of the simulated leaf 5 % too high",
    compare: large_deflection,
};

/// A step of 10 ms for states of rest: they do not depend on it.
const STEP_S: f64 = 0.01;

/// Loss factor 1 brings a leaf to rest soon; the state of rest does not depend on it.
fn damped_leaf(segments: u32, simulated: Simulated) -> Result<ClampedLeaf, CheckError> {
    let rigidity = RIGIDITY_N_M2 * simulated.with(1.0, 1.05);
    ClampedLeaf::new(&blade(segments, rigidity, 1.0), STEP_S)
}

/// Error of hinges at the middles of equal segments with a margin of a half, relative to the continuum.
fn midpoint_tolerance(segments: u32) -> f64 {
    1.5 / (4.0 * f64::from(segments).powi(2))
}

fn small_load(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    // A hundredth of the length at most: the slope's square changes the deflection by 1e-5.
    let load_n = 0.002;
    let mut comparisons = Vec::new();
    for segments in [5, 8, 16] {
        let mut leaf = damped_leaf(segments, simulated)?;
        let sum = beam::chain_deflection_m(load_n, LENGTH_M, &leaf.hinges());
        let found = leaf.settle(DVec3::X * load_n, DVec3::ZERO)?.x;
        let continuum = beam::beam_deflection_m(load_n, LENGTH_M, RIGIDITY_N_M2);
        comparisons.push(Comparison::relative(
            format!("tip deflection, {segments} hinges, against their sum"),
            "m",
            sum,
            found,
            1e-3,
            "0.1 %: the sum is exact for the chain; the slope's square at this load is 1e-5",
        ));
        comparisons.push(Comparison::relative(
            format!("tip deflection, {segments} hinges, against the beam"),
            "m",
            continuum,
            found,
            midpoint_tolerance(segments),
            "1.5 / 4n²: n hinges at the middles of segments, the plainest rule, are 1 / 4n² off",
        ));
    }
    Ok(comparisons)
}

fn large_deflection(simulated: Simulated) -> Result<Vec<Comparison>, CheckError> {
    let mut comparisons = Vec::new();
    let mut compare = |what: String, segments: u32, expected: elastica::Tip, found: DVec3| {
        for (direction, expected, found) in [
            ("sideways", expected.sideways, found.x / LENGTH_M),
            ("shortening", expected.shortening, 1.0 - found.z / LENGTH_M),
        ] {
            comparisons.push(Comparison::relative(
                format!("{what}, {segments} hinges: {direction} in lengths"),
                "",
                expected,
                found,
                midpoint_tolerance(segments) + 2e-3,
                "1.5 / 4n² + 0.2 %: the error of n hinges at the middles of segments, and terms of higher order at large slopes",
            ));
        }
    };
    for (load, segments) in [(0.45, 8), (1.0, 8), (2.0, 8), (3.0, 8), (3.0, 20)] {
        let force_n = load * RIGIDITY_N_M2 / LENGTH_M.powi(2);
        let tip = damped_leaf(segments, simulated)?.settle(DVec3::X * force_n, DVec3::ZERO)?;
        compare(
            format!("P L² / E I = {load}"),
            segments,
            elastica::under_tip_load(load),
            tip,
        );
    }
    for (angle, name, segments) in [(PI / 2.0, "quarter", 8), (PI, "half", 20)] {
        let moment_nm = angle * RIGIDITY_N_M2 / LENGTH_M;
        let tip = damped_leaf(segments, simulated)?.settle(DVec3::ZERO, DVec3::Y * moment_nm)?;
        compare(
            format!("end moment, {name} circle"),
            segments,
            elastica::under_end_moment(angle),
            tip,
        );
    }
    Ok(comparisons)
}
