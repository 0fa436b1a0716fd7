//! Vector instructions, chosen at run time. Results have the same bits on every processor, because no operations are
//! fused and every sum has a fixed order.

use fearless_simd::{Level, Simd};

#[cfg(test)]
thread_local! {
    /// Whether this thread uses only instructions that every processor has.
    pub(crate) static BASELINE_ONLY: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

/// The instructions that may be used.
#[inline(always)]
pub(crate) fn level() -> Level {
    #[cfg(test)]
    if BASELINE_ONLY.get() {
        return Level::baseline();
    }
    Level::new()
}

/// Runs `work` with AVX2 instructions if the processor has them. Everything that `work` calls must be inlined into it.
#[inline(always)]
pub(crate) fn vectorized<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if let Some(avx2) = level().as_avx2() {
        return Simd::vectorize(avx2, work);
    }
    work()
}

/// Mantissa (1 … 2) and exponent of a positive number that is not subnormal.
#[inline(always)]
pub(crate) fn parts(x: f64) -> (f64, f64) {
    let bits = x.to_bits();
    let mantissa = f64::from_bits(bits & 0x000f_ffff_ffff_ffff | 0x3ff0_0000_0000_0000);
    // The exponent's bits, placed in the mantissa of 2^52, give 2^52 + exponent + bias as a float.
    let exponent = f64::from_bits((bits >> 52) | 0x4330_0000_0000_0000) - 4_503_599_627_371_519.0;
    (mantissa, exponent)
}
