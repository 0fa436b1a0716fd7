//! Arithmetic on four numbers at a time, which the compiler turns into vector instructions. Results have the same bits
//! on every processor, because no operations are fused and every sum has a fixed order.

use underbrush_recording::math::parts;

/// Four numbers: one for each of four states or streams.
pub(super) type Tile = [f64; WIDTH];

/// Numbers in a tile.
pub(super) const WIDTH: usize = 4;

/// Number of tiles needed for this many states.
pub(super) fn tiles_for(states: usize) -> usize {
    states.div_ceil(WIDTH)
}

/// Arranges `outer` rows of one number per state in tiles, padded with `padding`. `value` maps row and state to a
/// number.
pub(super) fn tiled(outer: usize, states: usize, padding: f64, value: impl Fn(usize, usize) -> f64) -> Vec<Tile> {
    let tiles = tiles_for(states);
    let lane = |row: usize, state: usize| if state < states { value(row, state) } else { padding };
    (0..outer * tiles).map(|place| std::array::from_fn(|k| lane(place / tiles, place % tiles * WIDTH + k))).collect()
}

/// Applies a function of two numbers to each lane.
#[inline(always)]
pub(super) fn zip(a: Tile, b: Tile, f: impl Fn(f64, f64) -> f64) -> Tile {
    [f(a[0], b[0]), f(a[1], b[1]), f(a[2], b[2]), f(a[3], b[3])]
}

/// Applies a function of one number to each lane.
#[inline(always)]
pub(super) fn map(a: Tile, f: impl Fn(f64) -> f64) -> Tile {
    [f(a[0]), f(a[1]), f(a[2]), f(a[3])]
}

/// `a` where the mask is above 0, `b` elsewhere. A mask of floats keeps the selection in vector registers.
#[inline(always)]
pub(super) fn select(mask: Tile, a: Tile, b: Tile) -> Tile {
    let lane = |k: usize| if mask[k] > 0.0 { a[k] } else { b[k] };
    [lane(0), lane(1), lane(2), lane(3)]
}

#[inline(always)]
pub(super) fn add(a: Tile, b: Tile) -> Tile {
    zip(a, b, |a, b| a + b)
}

#[inline(always)]
pub(super) fn multiply(a: Tile, b: Tile) -> Tile {
    zip(a, b, |a, b| a * b)
}

/// The larger of two numbers that are not NaN. Unlike `f64::max`, which handles NaN, this is a single instruction.
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

/// Adding and then subtracting this rounds to the nearest integer. The sum holds that integer in its lowest bits.
pub(super) const ROUNDER: f64 = 6_755_399_441_055_744.0;

/// Coefficients of 1, x, x², … of 2^x, near-minimax on −½ … ½. The relative error of 2e-17 is below rounding.
const EXP2: [f64; 12] = [
    1.0,
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
    // Estrin's scheme: its parts are independent, while each step of Horner's scheme waits for the previous one.
    let (square, pair) = (x * x, |k: usize| EXP2[k] + EXP2[k + 1] * x);
    let four = |k: usize| pair(k) + pair(k + 2) * square;
    let fourth = square * square;
    (four(8) * fourth + four(4)) * fourth + four(0)
}

/// 2^x to about one unit in the last place, for x from −1022 to 1023.
#[inline(always)]
pub(super) fn exp2(x: f64) -> f64 {
    let shifted = x + ROUNDER;
    let fraction = x - (shifted - ROUNDER);
    // The integer part is added directly to the exponent's bits.
    f64::from_bits(exp2_fraction(fraction).to_bits().wrapping_add(shifted.to_bits() << 52))
}

/// 2^n for an integer n, given as a floating-point number, from −1022 to 1023.
#[inline(always)]
pub(super) fn integer_power_of_two(n: f64) -> f64 {
    scale_mantissa(1.0, n)
}

/// A mantissa (1 … 2) times 2^n for an integer n, given as a floating-point number, from −1022 to 1023.
#[inline(always)]
pub(super) fn scale_mantissa(mantissa: f64, n: f64) -> f64 {
    f64::from_bits(mantissa.to_bits().wrapping_add((n + ROUNDER).to_bits() << 52))
}

/// ⌊log2 x⌋ of a positive number that is not subnormal.
#[inline(always)]
pub(super) fn exponent(x: f64) -> i64 {
    (x.to_bits() >> 52) as i64 - 1023
}

/// For x ≥ 1 written as m·2^k with m from √½ to √2: ln m, to about one unit in the last place of 1, and k.
#[inline(always)]
pub(super) fn logarithm(x: f64) -> (f64, f64) {
    let (mantissa, exponent) = parts(x);
    let high = mantissa > std::f64::consts::SQRT_2;
    let (mantissa, exponent) = if high { (0.5 * mantissa, exponent + 1.0) } else { (mantissa, exponent) };
    // ln m = 2 artanh ((m − 1) / (m + 1)), whose argument is under 0.172.
    let argument = (mantissa - 1.0) / (mantissa + 1.0);
    let square = argument * argument;
    let mut series = 0.0;
    for odd in [21.0, 19.0, 17.0, 15.0, 13.0, 11.0, 9.0, 7.0, 5.0, 3.0] {
        series = series * square + 1.0 / odd;
    }
    (2.0 * argument + 2.0 * argument * (square * series), exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests exp2 against the standard library over its range, and that powers of two and exponents are exact.
    #[test]
    fn powers_of_two_are_exact_to_the_last_place() {
        for step in -102_200..102_200 {
            let x = f64::from(step) * 0.01 + 1e-3;
            let (found, expected) = (exp2(x), x.exp2());
            assert!((found / expected - 1.0).abs() < 4.5e-16, "{x}: {found:e} for {expected:e}");
        }
        for n in -1022..1024 {
            assert_eq!(exp2(n as f64), 2f64.powi(n as i32));
            assert_eq!(integer_power_of_two(n as f64), 2f64.powi(n as i32));
            assert_eq!(exponent(1.5 * 2f64.powi(n as i32)), n);
            assert_eq!(scale_mantissa(1.75, n as f64), 1.75 * 2f64.powi(n as i32));
        }
    }

    /// Tests ln against the standard library from 1 to 2^20. The tolerance of 4e-16 is relative for logarithms above 1
    /// and absolute below.
    #[test]
    fn logarithms_are_exact_to_the_last_place() {
        for step in 0..200_000 {
            let x = 1.0 + f64::from(step) * 5.24;
            let (log, whole) = logarithm(x);
            let (found, expected) = (log + whole * std::f64::consts::LN_2, x.ln());
            assert!((found - expected).abs() < 4e-16 * expected.max(1.0), "{x}: {found} for {expected}");
        }
    }
}
