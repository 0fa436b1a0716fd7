//! Features on a logarithmic scale.

/// sign(x) ln(1 + |x| / knee).
pub(super) fn compress(value: f64, knee: f64) -> f64 {
    let magnitude = ln(1.0 + value.abs() / knee);
    if value < 0.0 { -magnitude } else { magnitude }
}

/// ln(1 + count).
pub(super) fn compress_count(count: f64) -> f64 {
    ln(1.0 + count)
}

/// The natural logarithm of a number of at least 1, within 1e-9. Own code, because the standard one comes from the platform's
/// library, so its last digits differ between platforms, and because it takes a quarter of the time of a verdict.
fn ln(value: f64) -> f64 {
    // value = 2^exponent * mantissa with a mantissa between √½ and √2, and ln m = 2 artanh((m - 1) / (m + 1)).
    const EXPONENT_BITS: u64 = 0x7ff << 52;
    let bits = value.to_bits();
    let mut exponent = ((bits & EXPONENT_BITS) >> 52) as f64 - 1023.0;
    let mut mantissa = f64::from_bits(bits & !EXPONENT_BITS | 1023 << 52);
    if mantissa > std::f64::consts::SQRT_2 {
        mantissa *= 0.5;
        exponent += 1.0;
    }
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
        /// Pins the logarithm against the standard one, over all sizes that features have.
        #[test]
        fn the_logarithm_is_right(exponent in -20.0f64..20.0, sign in prop::bool::ANY, knee in 1e-4f64..10.0) {
            let value = if sign { exponent.exp() } else { -exponent.exp() };
            let expected = value.signum() * (value.abs() / knee).ln_1p();
            prop_assert!((compress(value, knee) - expected).abs() < 1e-9, "{value} {knee}");
        }

        /// Pins that counts start at zero and keep their order.
        #[test]
        fn counts_keep_their_order(count in 0u32..1_000_000) {
            let [now, next] = [count, count + 1].map(|count| compress_count(f64::from(count)));
            prop_assert!(next > now);
            prop_assert!((now - f64::from(count).ln_1p()).abs() < 1e-9);
        }
    }
}
