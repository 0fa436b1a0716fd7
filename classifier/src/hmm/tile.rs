//! Four states side by side: arithmetic that the compiler turns into vector instructions, with the same bits on every
//! processor, since nothing is fused and every sum has one order.

/// Four numbers, one a state.
pub(super) type Tile = [f64; WIDTH];

/// States in a tile.
pub(super) const WIDTH: usize = 4;

/// Runs `work` with AVX2 where the processor has it. What `work` calls must be inlined into it.
#[inline(always)]
pub(super) fn vectorized<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if let Some(avx2) = fearless_simd::Level::new().as_avx2() {
        return fearless_simd::Simd::vectorize(avx2, work);
    }
    work()
}

/// Number of tiles that hold so many states.
pub(super) fn tiles_for(states: usize) -> usize {
    states.div_ceil(WIDTH)
}

/// Applies a function of two numbers lane by lane.
#[inline(always)]
pub(super) fn zip(a: Tile, b: Tile, f: impl Fn(f64, f64) -> f64) -> Tile {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])]
}

/// Applies a function of one number lane by lane.
#[inline(always)]
pub(super) fn map(a: Tile, f: impl Fn(f64) -> f64) -> Tile {
    [f(a[0]), f(a[1]), f(a[2]), f(a[3])]
}

#[inline(always)]
pub(super) fn add(a: Tile, b: Tile) -> Tile {
    zip(a, b, |a, b| a + b)
}

#[inline(always)]
pub(super) fn multiply(a: Tile, b: Tile) -> Tile {
    zip(a, b, |a, b| a * b)
}

#[inline(always)]
pub(super) fn scale(a: Tile, factor: f64) -> Tile {
    map(a, |a| a * factor)
}

/// The larger of two numbers without NaN; a comparison, unlike `f64::max` with its care for NaN, is one instruction.
#[inline(always)]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The sum of a tile's numbers.
#[inline(always)]
pub(super) fn sum(a: Tile) -> f64 {
    (a[0] + a[2]) + (a[1] + a[3])
}

/// The largest of a tile's numbers.
#[inline(always)]
pub(super) fn largest(a: Tile) -> f64 {
    larger(larger(a[0], a[2]), larger(a[1], a[3]))
}

/// Adding and subtracting it rounds to the nearest integer, which then stands in the lowest bits of the sum.
pub(super) const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Coefficients of x, x², … of 2^x − 1, near-minimax on −½ … ½: relative error 2e-17, under rounding.
const EXP2: [f64; 11] = [
    std::f64::consts::LN_2,
    0.24022650695910097,
    0.0555041086648216,
    0.009618129107606888,
    0.0013333558146416936,
    0.0001540353044173605,
    1.525273382983612e-05,
    1.3215442587921524e-06,
    1.0178062445845686e-07,
    7.072585949302182e-09,
    4.4549605982040863e-10,
];

/// 2^x for x from −½ to ½.
#[inline(always)]
pub(super) fn exp2_fraction(x: f64) -> f64 {
    let mut polynomial = EXP2[10];
    for coefficient in EXP2[..10].iter().rev() {
        polynomial = polynomial * x + coefficient;
    }
    1.0 + polynomial * x
}

/// 2^x, to about one unit in the last place, for x from −1022 to 1023.
#[inline(always)]
pub(super) fn exp2(x: f64) -> f64 {
    let shifted = x + ROUNDER;
    let fraction = x - (shifted - ROUNDER);
    // The power of two goes straight into the exponent's bits.
    f64::from_bits(exp2_fraction(fraction).to_bits().wrapping_add(shifted.to_bits() << 52))
}

/// 2^n for an integer n, as a floating-point number, from −1022 to 1023.
#[inline(always)]
pub(super) fn integer_power_of_two(n: f64) -> f64 {
    f64::from_bits(1f64.to_bits().wrapping_add((n + ROUNDER).to_bits() << 52))
}

/// 2^n for an integer n from −1022 to 1023.
#[inline(always)]
pub(super) fn power_of_two(n: i64) -> f64 {
    f64::from_bits(((n + 1023) as u64) << 52)
}

/// ⌊log2 x⌋ of a positive number that is not subnormal.
#[inline(always)]
pub(super) fn exponent(x: f64) -> i64 {
    (x.to_bits() >> 52) as i64 - 1023
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_of_two_are_exact_to_the_last_place() {
        // Pins exp2 against the standard library over its range, and powers of two and exponents exactly.
        for step in -102_200..102_200 {
            let x = f64::from(step) * 0.01 + 1e-3;
            let (found, expected) = (exp2(x), x.exp2());
            assert!(
                (found / expected - 1.0).abs() < 4.5e-16,
                "{x}: {found:e} for {expected:e}"
            );
        }
        for n in -1022..1024 {
            assert_eq!(exp2(n as f64), 2f64.powi(n as i32));
            assert_eq!(power_of_two(n), 2f64.powi(n as i32));
            assert_eq!(integer_power_of_two(n as f64), 2f64.powi(n as i32));
            assert_eq!(exponent(1.5 * power_of_two(n)), n);
        }
    }
}
