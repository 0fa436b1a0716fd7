//! A cantilever as a chain of rigid pieces. Its hinges are at the nodes of Gauss-Legendre quadrature over its length
//! and have the compliance w L / E I, where w is the weight of the node (the weights sum to 1).
//!
//! A transverse load P at the tip bends hinge k by P (L − x_k) w_k L / E I, and the tip moves by this angle times
//! L − x_k. The sum over the hinges is the quadrature of the beam's P ∫ (L − x)² dx / E I. The integrand is a
//! polynomial of degree 2, and n nodes integrate up to degree 2n − 1 exactly. The chain's tip therefore deflects by P
//! L³ / 3 E I for every n ≥ 2. Under a load at a < L the integrand is (a − x)² below a and 0 above, which is not a
//! polynomial. In this case the chain has an error, and [`deflection_m`] gives the chain's own deflection.

use std::f64::consts::PI;

use crate::beam::heights_under_tip_load;

/// Nodes and weights of Gauss-Legendre quadrature on −1 to 1, the positive half: Abramowitz and Stegun, *Handbook of
/// Mathematical Functions*, table 25.4.
const TABLE: [(u32, &[(f64, f64)]); 3] = [
    (2, &[(0.577_350_269_189_626, 1.0)]),
    (4, &[(0.339_981_043_584_856, 0.652_145_154_862_546), (0.861_136_311_594_053, 0.347_854_845_137_454)]),
    (
        8,
        &[
            (0.183_434_642_495_650, 0.362_683_783_378_362),
            (0.525_532_409_916_329, 0.313_706_645_877_887),
            (0.796_666_477_413_627, 0.222_381_034_453_374),
            (0.960_289_856_497_536, 0.101_228_536_290_376),
        ],
    ),
];

/// The hinges of a chain of unit length, lowest first: places and weights. `None` if `count` is not in the table, which
/// has 2, 4 and 8.
pub fn hinges(count: u32) -> Option<Vec<(f64, f64)>> {
    let (_, half) = TABLE.iter().find(|(known, _)| *known == count)?;
    let mirrored = half.iter().rev().map(|(node, weight)| (-node, *weight));
    let whole = mirrored.chain(half.iter().copied());
    Some(whole.map(|(node, weight)| ((1.0 + node) / 2.0, weight / 2.0)).collect())
}

/// Deflection, m, of a chain at a small transverse load that acts `height_m` from the clamp: Σ P (a − x_k)² w_k L / E I
/// over the hinges below the load. `None` as for [`hinges`].
///
/// ```
/// use underbrush_oracles::beam::beam_deflection_m;
/// use underbrush_oracles::chain::deflection_m;
///
/// // Under a load at the tip a chain of four hinges bends as far as the beam.
/// let chain = deflection_m(0.1, 0.3, 0.3, 0.02, 4);
/// assert!(chain.is_some_and(|chain_m| (chain_m / beam_deflection_m(0.1, 0.3, 0.02) - 1.0).abs() < 1e-9));
/// ```
pub fn deflection_m(load_n: f64, height_m: f64, length_m: f64, flexural_rigidity_n_m2: f64, count: u32) -> Option<f64> {
    let deflection_m = |(place, weight): (f64, f64)| {
        let lever_m = (height_m - place * length_m).max(0.0);
        load_n * lever_m * lever_m * weight * length_m / flexural_rigidity_n_m2
    };
    Some(hinges(count)?.into_iter().map(deflection_m).sum())
}

/// How far the tip of a chain with `count` hinges may be from the tip of a strip under a large deflection, in strip
/// lengths, to leading order, across or along the strip.
///
/// The slope of the chain is a staircase about the strip's slope θ(s). Its error e has two effects on the tip,
/// (∫ sin θ ds, ∫ cos θ ds). The first, linear in e, is the error of the quadrature, which falls faster than any power
/// of n. The second is −½ ∫ sin θ e² ds sideways and −½ ∫ cos θ e² ds along the strip. Over a piece of length h about a
/// node e runs from −κ h / 2 to κ h / 2, κ = θ′, so the mean of e² is κ² h² / 12; and near s the nodes are h = π √(s
/// (1 − s)) / n apart, in lengths. Sine and cosine are at most 1, so both are at most (π² / 24 n²) ∫ s (1 − s) κ² ds.
pub fn far_bending_error(bending: f64, count: u32) -> f64 {
    PI * PI / 24.0 / f64::from(count).powi(2) * bending
}

/// ∫ s (1 − s) κ² ds of a strip of unit length under an end moment, which bends it to an arc of κ = `angle_rad`.
pub fn arc_bending(angle_rad: f64) -> f64 {
    angle_rad * angle_rad / 6.0
}

/// ∫ s (1 − s) κ² ds of a strip of unit length under a tip load; `load` is P L² / E I. Because κ′ = −load · cos θ, the
/// curvature is the load times the remaining lever arm, load · (z(1) − z(s)), where z is the height above the clamp.
pub fn tip_load_bending(load: f64) -> f64 {
    let heights = heights_under_tip_load(load);
    let spacing = 1.0 / (heights.len() - 1) as f64;
    let top = heights[heights.len() - 1];
    let part = |(index, height): (usize, &f64)| {
        let place = index as f64 * spacing;
        place * (1.0 - place) * (load * (top - height)).powi(2) * spacing
    };
    heights.iter().enumerate().map(part).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::beam::{beam_deflection_m, under_end_moment, under_tip_load};
    use approx::assert_relative_eq;

    /// Tests the table: n nodes integrate every power up to 2n − 1 over 0 to 1 to 1 / (power + 1).
    #[test]
    fn nodes_integrate_polynomials() {
        for (count, _) in TABLE {
            let nodes = hinges(count).unwrap();
            assert_eq!(nodes.len(), count as usize);
            for power in 0..2 * count as i32 {
                let sum: f64 = nodes.iter().map(|(place, weight)| weight * place.powi(power)).sum();
                assert_relative_eq!(sum, 1.0 / f64::from(power + 1), epsilon = 1e-14);
            }
        }
        assert!(hinges(5).is_none());
    }

    /// Tests that a load at the tip bends the chain exactly like the beam, for any number of hinges, and that a load
    /// below the tip does not.
    #[test]
    fn tip_load_is_exact() {
        let beam = |height_m| beam_deflection_m(0.7, height_m, 0.02);
        for (count, _) in TABLE {
            let chain = |height_m| deflection_m(0.7, height_m, 0.3, 0.02, count).unwrap();
            assert_relative_eq!(chain(0.3), beam(0.3), max_relative = 1e-13);
            assert!((chain(0.18) / beam(0.18) - 1.0).abs() > 1e-4, "{count}: {}", chain(0.18));
        }
    }

    /// Tests that hinges above the load do not bend. By hand, for two hinges and a load at half the height:
    /// (1/2 − (1 − 1/√3)/2)² / 2 = 1/24, which for two hinges is the beam's own 1/24.
    #[test]
    fn load_below_the_tip_bends_what_is_below_it() {
        assert_relative_eq!(deflection_m(1.0, 0.5, 1.0, 1.0, 2).unwrap(), 1.0 / 24.0, epsilon = 1e-14);
        assert_eq!(deflection_m(1.0, 0.2, 1.0, 1.0, 2).unwrap(), 0.0);
    }

    /// Tip of a chain in equilibrium under a tip load, found by repeating θ_k − θ_(k−1) = w_k · load · lever: sideways,
    /// shortening.
    fn chain_in_equilibrium(load: f64, count: u32) -> [f64; 2] {
        let nodes = hinges(count).unwrap();
        let mut slopes = vec![0.0_f64; nodes.len()];
        let mut tip = [0.0, 0.0];
        for _ in 0..500 {
            let (mut x, mut z) = (0.0, nodes[0].0);
            let mut heights = Vec::new();
            for (index, slope) in slopes.iter().enumerate() {
                heights.push(z);
                let next = nodes.get(index + 1).map_or(1.0, |node| node.0);
                let length = next - nodes[index].0;
                x += length * slope.sin();
                z += length * slope.cos();
            }
            tip = [x, 1.0 - z];
            let mut slope = 0.0;
            for (index, height) in heights.iter().enumerate() {
                slope += nodes[index].1 * load * (z - height);
                slopes[index] = 0.5 * (slopes[index] + slope);
            }
        }
        tip
    }

    /// Tests the leading error under large deflections: chains in equilibrium under a tip load, and chains bent by an
    /// end moment, have at most one and a half times this error, and at least a third of it in one of the two
    /// directions.
    #[test]
    fn far_bending_error_bounds_chains() {
        let holds = |errors: [f64; 2], bound: f64| {
            let largest = errors[0].abs().max(errors[1].abs());
            assert!(largest < 1.5 * bound && largest > bound / 3.0, "{errors:?}, {bound}");
        };
        for (load, count) in [(0.45, 8), (1.0, 8), (2.0, 8), (3.0, 8), (2.0, 4)] {
            let [sideways, shortening] = chain_in_equilibrium(load, count);
            let exact = under_tip_load(load);
            let errors = [sideways - exact.sideways, shortening - exact.shortening];
            holds(errors, far_bending_error(tip_load_bending(load), count));
        }
        for (angle, count) in [(PI / 2.0, 8), (PI / 2.0, 4), (PI, 8)] {
            let nodes = hinges(count).unwrap();
            let (mut slope, mut x, mut z) = (0.0, 0.0, nodes[0].0);
            for (index, (place, weight)) in nodes.iter().enumerate() {
                slope += weight * angle;
                let length = nodes.get(index + 1).map_or(1.0, |node| node.0) - place;
                x += length * f64::sin(slope);
                z += length * f64::cos(slope);
            }
            let exact = under_end_moment(angle);
            let errors = [x - exact.sideways, 1.0 - z - exact.shortening];
            holds(errors, far_bending_error(arc_bending(angle), count));
        }
    }

    /// Tests ∫ s (1 − s) κ² ds under a small tip load, where κ = load · (1 − s): load² / 20.
    #[test]
    fn small_tip_load_bends_in_proportion() {
        assert_relative_eq!(tip_load_bending(0.01), 0.01_f64.powi(2) / 20.0, max_relative = 1e-3);
    }
}
