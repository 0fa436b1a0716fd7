//! Statistics of the response time, in memory that does not grow with the stream.

use std::time::Duration;

use underbrush_recording::math;

use crate::output;

/// Bins of the histogram in each doubling of time: quantiles are accurate to within 9 %.
const STEPS_PER_DOUBLING: f64 = 8.0;
/// Number of doublings, beginning at one microsecond: 2^40 µs are two weeks.
const DOUBLINGS: usize = 40;

/// Times from receiving a frame (a line, or a frame of a file) until its answer is written.
pub struct Latency {
    /// Number of answers by the logarithm of their time.
    counts: Vec<u64>,
    max_us: f64,
}

impl Latency {
    /// No answer yet.
    pub fn new() -> Self {
        Latency { counts: vec![0; DOUBLINGS * STEPS_PER_DOUBLING as usize], max_us: 0.0 }
    }

    /// Counts an answer that took this time.
    pub fn add(&mut self, time: Duration) {
        let time_us = 1e6 * time.as_secs_f64();
        // Less than a microsecond counts as one.
        let step = (STEPS_PER_DOUBLING * math::log2(time_us.max(1.0))) as usize;
        let last = self.counts.len() - 1;
        self.counts[step.min(last)] += 1;
        self.max_us = self.max_us.max(time_us);
    }

    /// Readable text; `None` without answers.
    pub fn text(&self) -> Option<String> {
        let answers: u64 = self.counts.iter().sum();
        (answers > 0).then(|| {
            let [median_us, most_us] = [0.5, 0.99].map(|share| self.quantile_us(share, answers));
            let (frames, max_us) = (output::counted(answers, "frame", "frames"), self.max_us);
            format!("{frames} answered: median {median_us:.0} µs, 99 % within {most_us:.0} µs, at most {max_us:.0} µs")
        })
    }

    /// The time within which a fraction of the answers was given: the upper end of its bin.
    fn quantile_us(&self, share: f64, answers: u64) -> f64 {
        let mut left = (share * answers as f64).ceil() as u64;
        for (step, count) in self.counts.iter().enumerate() {
            if *count >= left {
                return math::exp2((step as f64 + 1.0) / STEPS_PER_DOUBLING).min(self.max_us);
            }
            left -= count;
        }
        self.max_us
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests the quantiles of known times: never too small, and at most 9 %, the width of a bin, too large.
    #[test]
    fn quantiles_are_near_the_true_ones() {
        let mut latency = Latency::new();
        assert_eq!(latency.text(), None);
        (1..=10_000).for_each(|time| latency.add(Duration::from_micros(time)));
        for (share, expected) in [(0.5, 5000.0), (0.99, 9900.0), (1.0, 10_000.0), (0.0001, 1.0)] {
            let found = latency.quantile_us(share, 10_000);
            assert!((expected..1.0906 * expected).contains(&found), "{share}: {found}");
        }
        for extreme in [Duration::ZERO, Duration::from_secs(1_000_000_000_000), Duration::MAX] {
            latency.add(extreme);
        }
        assert!(latency.text().unwrap().starts_with("10003 frames answered: median 5"));
    }
}
