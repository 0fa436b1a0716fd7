//! Elementary functions that return the same bits on every machine.
//!
//! The methods of `f64` call the machine's math library, which picks an implementation by its version and by the
//! processor, and these differ in the last digits. Data, trials, models and verdicts are computed with the crate `libm`,
//! whose functions consist of additions, multiplications and roots, which IEEE 754 defines bit by bit. The workspace's
//! `clippy.toml` forbids the methods.

pub use libm::{
    acos, asin, atan, atan2, cos, exp, exp2, expm1 as exp_m1, hypot, log as ln, log1p as ln_1p, log2, log10,
    pow as powf, sin, sincos as sin_cos, tanh,
};

/// Mantissa (1 … 2) and exponent of a positive number that is not subnormal.
#[inline(always)]
pub fn parts(x: f64) -> (f64, f64) {
    let bits = x.to_bits();
    let mantissa = f64::from_bits(bits & 0x000f_ffff_ffff_ffff | 0x3ff0_0000_0000_0000);
    // The exponent's bits, placed in the mantissa of 2^52, give 2^52 + exponent + bias as a float.
    let exponent = f64::from_bits((bits >> 52) | 0x4330_0000_0000_0000) - 4_503_599_627_371_519.0;
    (mantissa, exponent)
}

/// The larger number, or NaN if one of them is NaN, which [`f64::max`] would pass over.
#[inline]
pub fn larger(first: f64, second: f64) -> f64 {
    if first >= second || first.is_nan() { first } else { second }
}

/// The values in the order of [`f64::total_cmp`]. Equal ones have equal bits, so it does not matter which is first.
pub fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values
}

/// The median: the mean of the two middle values if the count is even. `None` without values.
pub fn median(values: Vec<f64>) -> Option<f64> {
    let values = sorted(values);
    let middle = values.len() / 2;
    let upper = *values.get(middle)?;
    Some(if values.len().is_multiple_of(2) { f64::midpoint(values[middle - 1], upper) } else { upper })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that the larger of two numbers is NaN if either is.
    #[test]
    fn nothing_is_larger_than_nan() {
        assert_eq!((larger(1.0, 2.0), larger(2.0, 1.0)), (2.0, 2.0));
        assert!(larger(f64::NAN, 1.0).is_nan() && larger(1.0, f64::NAN).is_nan());
    }

    /// Tests that an even count gives the mean of the two middle values.
    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(vec![4.0, 1.0, 2.0, 9.0]), Some(3.0));
        assert_eq!((median(vec![9.0, 1.0, 2.0]), median(Vec::new())), (Some(2.0), None));
    }

    /// Tests the functions bit by bit against values computed once, at arguments at which math libraries differ.
    #[test]
    fn functions_return_the_same_bits_everywhere() {
        let mut hasher = 0xcbf2_9ce4_8422_2325_u64;
        let mut add = |value: f64| hasher = (hasher ^ value.to_bits()).wrapping_mul(0x0100_0000_01b3);
        for index in 1..20_000_u32 {
            let x = f64::from(index) * 7.31e-4;
            let within = f64::from(index) / 20_000.0;
            let (sine, cosine) = sin_cos(x);
            for value in [
                sin(x),
                cos(x),
                sine,
                cosine,
                exp(-x),
                exp2(x),
                exp_m1(-x),
                ln(x),
                ln_1p(x),
                log2(x),
                log10(x),
                tanh(x),
                powf(x, 0.37),
                hypot(x, 0.61),
                atan(x),
                atan2(within, x),
                acos(within),
                asin(within),
            ] {
                add(value);
            }
        }
        assert_eq!(format!("{hasher:016x}"), "3eb88a188e191383");
    }
}
