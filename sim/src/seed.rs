//! Random numbers: one `u64` seed gives every reach its own named streams.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use underbrush_recording::math;

/// The stream for one purpose (such as `"clutter"`, `"goals"` or `"sensor"`) of one reach of one scene, which is named by
/// [`Scene::stream`](crate::scene::Scene::stream).
///
/// A stream depends only on these four arguments, so threads, shards and other scenes do not change it.
///
/// ```
/// use rand::Rng;
/// use underbrush_sim::seed::stream;
///
/// // Each reach draws its own numbers, the same in every run.
/// let draw = |reach| stream(7, "leaf", reach, "goals").next_u64();
/// assert_eq!(draw(0), draw(0));
/// assert_ne!(draw(0), draw(1));
/// ```
pub fn stream(seed: u64, scene: &str, reach_index: u64, purpose: &str) -> ChaCha8Rng {
    let mut hasher = blake3::Hasher::new_derive_key("underbrush 2026 random streams");
    hasher.update(&seed.to_le_bytes());
    hasher.update(&reach_index.to_le_bytes());
    // The length keeps ("ab", "c") apart from ("a", "bc").
    hasher.update(&(scene.len() as u64).to_le_bytes());
    hasher.update(scene.as_bytes());
    hasher.update(purpose.as_bytes());
    ChaCha8Rng::from_seed(*hasher.finalize().as_bytes())
}

/// A draw from the standard normal distribution, x √(−2 ln s / s). Its logarithm is computed only where the value is needed.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Normal {
    x: f64,
    square: f64,
}

impl Normal {
    /// The value of the draw.
    pub fn value(self) -> f64 {
        self.x * (-2.0 * math::ln(self.square) / self.square).sqrt()
    }
}

/// A limit to the size of draws that is compared without their logarithms.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Bound {
    /// A draw is no larger than √(−2 ln s), because |x| ≤ √s.
    least_square: f64,
}

impl Bound {
    /// The bound with this limit, in standard deviations. No draw is below a limit of 0.
    pub fn new(limit: f64) -> Self {
        // Rounding errors are far smaller than this.
        Bound { least_square: math::exp(-0.5 * limit * limit.max(0.0)) * (1.0 + 1e-9) }
    }

    /// Whether a draw is certainly smaller than the limit. It is found of nearly all that are far smaller.
    pub fn holds(self, draw: Normal) -> bool {
        draw.square > self.least_square
    }
}

/// Fills the places with independent draws from the standard normal distribution, two by two (Marsaglia's polar method).
/// `rand_distr` takes its logarithm from the machine, and the last digits of a draw would depend on it.
pub fn standard_normals(random: &mut ChaCha8Rng, pairs: &mut [[Normal; 2]]) {
    // Each pair that is still missing takes at least two numbers, and those of several pairs are faster to draw at once.
    let mut numbers = [0_u64; 2 * PAIRS_AT_ONCE];
    let mut drawn = 0;
    while drawn < pairs.len() {
        let missing = (pairs.len() - drawn).min(PAIRS_AT_ONCE);
        let numbers = &mut numbers[..2 * missing];
        random.fill(numbers);
        for [x, y] in numbers.as_chunks().0 {
            let [x, y] = [x, y].map(|number| 2.0 * share(*number) - 1.0);
            let square = x * x + y * y;
            // A pair outside the circle is overwritten by the next one.
            pairs[drawn] = [x, y].map(|x| Normal { x, square });
            drawn += usize::from(0.0 < square && square < 1.0);
        }
    }
}

/// The number from 0 to 1 that `rand` makes of a drawn one.
pub fn share(number: u64) -> f64 {
    (number >> 11) as f64 * 2_f64.powi(-53)
}

/// Pairs that [`standard_normals`] draws at once.
const PAIRS_AT_ONCE: usize = 32;

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;

    /// Tests the mean, the spread, the fourth moment and the share beyond two deviations of normal draws against the
    /// distribution's own, within five standard errors.
    #[test]
    fn normal_draws_are_normal() {
        let mut random = stream(1, "test", 0, "normal");
        let count = 200_000.0;
        let mut pairs = vec![[Normal::default(); 2]; 100_000];
        standard_normals(&mut random, &mut pairs);
        let draws: Vec<f64> = pairs.as_flattened().iter().map(|draw| draw.value()).collect();
        let product: f64 = draws.chunks_exact(2).map(|pair| pair[0] * pair[1]).sum::<f64>() / 100_000.0;
        assert!(product.abs() < 5.0 / f64::sqrt(100_000.0), "the draws of a pair are correlated: {product}");
        let mean = |of: &dyn Fn(f64) -> f64| draws.iter().map(|draw| of(*draw)).sum::<f64>() / count;
        for (found, expected, variance) in [
            (mean(&|x| x), 0.0, 1.0),
            (mean(&|x| x * x), 1.0, 2.0),
            (mean(&|x| x * x * x * x), 3.0, 96.0),
            (mean(&|x| f64::from(u8::from(x.abs() > 2.0))), 0.045_500, 0.0434),
        ] {
            assert!((found - expected).abs() < 5.0 * f64::sqrt(variance / count), "{found} {expected}");
        }
    }

    /// Tests that no draw is larger than a limit that it is said to be within, and that nine in ten draws of less than half a
    /// limit of six deviations are known to be within it.
    #[test]
    fn draws_are_within_their_limits() {
        let mut random = stream(1, "test", 0, "limits");
        let mut pairs = vec![[Normal::default(); 2]; 100_000];
        standard_normals(&mut random, &mut pairs);
        let draws = pairs.as_flattened();
        for limit in [-1.0, 0.0, 0.01, 0.5, 2.0, 6.0] {
            let bound = Bound::new(limit);
            let within = || draws.iter().filter(|draw| bound.holds(**draw));
            assert!(within().all(|draw| draw.value().abs() < limit), "{limit}");
        }
        let small = || draws.iter().filter(|draw| draw.value().abs() < 3.0);
        let known = small().filter(|draw| Bound::new(6.0).holds(**draw)).count();
        assert!(10 * known > 9 * small().count(), "{known}");
    }

    /// Tests that a change of any of the four arguments gives another stream, and that the same arguments give the same
    /// stream.
    #[test]
    fn streams_differ_in_every_part() {
        let first = |seed, scene, reach, purpose| stream(seed, scene, reach, purpose).next_u64();
        let base = first(1, "leaf", 2, "clutter");
        assert_eq!(base, first(1, "leaf", 2, "clutter"));
        for other in [
            first(2, "leaf", 2, "clutter"),
            first(1, "trunk", 2, "clutter"),
            first(1, "leaf", 3, "clutter"),
            first(1, "leaf", 2, "goals"),
            first(1, "leafc", 2, "lutter"),
        ] {
            assert_ne!(base, other);
        }
    }
}
