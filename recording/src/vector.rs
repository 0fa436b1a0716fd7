//! Vector instructions, chosen at run time. Results have the same bits on every processor, because no operations are
//! fused and every sum has a fixed order.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};

use fearless_simd::{Level, Simd};

thread_local! {
    static BASELINE_ONLY: Cell<bool> = const { Cell::new(false) };
}

/// Runs `work`, on this thread, with only those instructions that every processor has. Tests compare what it returns.
///
/// ```
/// use underbrush_recording::vector::{vectorized, with_baseline};
///
/// let sum = || vectorized(|| (0..100).map(|number| f64::from(number) * 0.1).sum::<f64>());
/// assert_eq!(with_baseline(sum), sum());
/// ```
pub fn with_baseline<R>(work: impl FnOnce() -> R) -> R {
    let before = BASELINE_ONLY.replace(true);
    let result = catch_unwind(AssertUnwindSafe(work));
    BASELINE_ONLY.set(before);
    result.unwrap_or_else(|panic| resume_unwind(panic))
}

/// The instructions that may be used.
#[inline(always)]
pub fn level() -> Level {
    if BASELINE_ONLY.get() { Level::baseline() } else { Level::new() }
}

/// Runs `work` with AVX2 instructions if the processor has them. Everything that `work` calls must be inlined into it.
#[inline(always)]
pub fn vectorized<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if let Some(avx2) = level().as_avx2() {
        return Simd::vectorize(avx2, work);
    }
    work()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that the instructions are the usual ones again after work that panicked, and still few after such work within other work.
    #[test]
    fn a_panic_does_not_keep_the_instructions_few() {
        with_baseline(|| {
            assert!(catch_unwind(|| with_baseline(|| assert!(!BASELINE_ONLY.get()))).is_err());
            assert!(BASELINE_ONLY.get());
        });
        assert!(!BASELINE_ONLY.get());
    }
}
