//! Features on a logarithmic scale.

use underbrush_recording::math::parts;
use underbrush_recording::vector::vectorized;

/// The knee of counts: ln(1 + count).
pub(super) const COUNT_KNEE: f64 = 1.0;

/// The knee of features that are not compressed.
pub(super) const PLAIN: f64 = 0.0;

/// sign(x) ln(1 + |x| / knee) of each value with its knee.
pub(super) fn compress<const COUNT: usize>(values: [f64; COUNT], knees: &[f64; COUNT]) -> [f64; COUNT] {
    let mut lanes = values.map(|value| [value]);
    vectorized(
        #[inline(always)]
        || compress_lanes(&mut lanes, knees),
    );
    lanes.map(|[value]| value)
}

/// [`compress`] for several rows side by side, in place.
#[inline(always)]
pub(super) fn compress_lanes<const LANES: usize>(values: &mut [[f64; LANES]], knees: &[f64]) {
    for (lanes, knee) in values.iter_mut().zip(knees) {
        if *knee != PLAIN {
            *lanes = lanes.map(
                #[inline(always)]
                |value| {
                    let magnitude = ln(1.0 + value.abs() / knee);
                    if value < 0.0 { -magnitude } else { magnitude }
                },
            );
        }
    }
}

/// The natural logarithm of a number of at least 1, within 1e-9. The standard function is not used, because it comes
/// from the platform's library, so its last digits differ between platforms, and because it does not use vector
/// instructions.
#[inline(always)]
fn ln(value: f64) -> f64 {
    // value = 2^exponent * mantissa with a mantissa between √½ and √2, and ln m = 2 artanh((m - 1) / (m + 1)).
    let (mantissa, exponent) = parts(value);
    let is_large = mantissa > std::f64::consts::SQRT_2;
    let mantissa = if is_large { mantissa * 0.5 } else { mantissa };
    let exponent = if is_large { exponent + 1.0 } else { exponent };
    let ratio = (mantissa - 1.0) / (mantissa + 1.0);
    let square = ratio * ratio;
    let series = 1.0 + square * (1.0 / 3.0 + square * (1.0 / 5.0 + square * (1.0 / 7.0 + square * (1.0 / 9.0))));
    exponent * std::f64::consts::LN_2 + 2.0 * ratio * series
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Tests the logarithm against the standard function, over all sizes that features have.
        #[test]
        fn the_logarithm_is_right(exponent in -20.0f64..20.0, sign in prop::bool::ANY, knee in 1e-4f64..10.0) {
            let value = if sign { exponent.exp() } else { -exponent.exp() };
            let expected = value.signum() * (value.abs() / knee).ln_1p();
            let [found] = compress([value], &[knee]);
            prop_assert!((found - expected).abs() < 1e-9, "{value} {knee}");
        }

        /// Tests that counts start at zero and keep their order.
        #[test]
        fn counts_keep_their_order(count in 0u32..1_000_000) {
            let [now, next] = compress([count, count + 1].map(f64::from), &[COUNT_KNEE; 2]);
            prop_assert!(next > now);
            prop_assert!((now - f64::from(count).ln_1p()).abs() < 1e-9);
        }
    }
}
