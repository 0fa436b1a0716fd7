//! Spurious readings: taxels that read a small force although nothing touches them, because the cover has shifted a
//! little since the skin was zeroed.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use underbrush_recording::{FRAME_PERIOD_S, math};

use super::options::SensorOptions;

/// The spurious readings of one patch. Each taxel's offset is a telegraph process: it is zero for a while, then one
/// constant force for a while.
#[derive(Clone, Serialize, Deserialize)]
pub struct SpuriousReadings {
    /// Probability per frame that a taxel's spurious reading begins, and that it ends.
    begin: f64,
    end: f64,
    force_n: [f64; 2],
    /// Present offset of each taxel, N; 0 for a taxel without a spurious reading.
    offset_n: Vec<f64>,
}

impl SpuriousReadings {
    /// Starts without any, because the skin is zeroed before a reach.
    pub fn new(options: &SensorOptions, taxels: usize) -> Self {
        let end = -math::exp_m1(-FRAME_PERIOD_S / options.spurious_time_s);
        SpuriousReadings {
            // In the steady state a share s of the taxels is affected and as many begin as end: begin · (1 − s) = end ·
            // s.
            begin: end * options.spurious_share / (1.0 - options.spurious_share),
            end,
            force_n: options.spurious_force_n,
            offset_n: vec![0.0; taxels],
        }
    }

    /// Advances by one frame and returns the offsets of all taxels, N.
    pub fn advance(&mut self, random: &mut ChaCha8Rng) -> &[f64] {
        if self.begin > 0.0 {
            let [min, max] = self.force_n;
            for offset in &mut self.offset_n {
                if *offset > 0.0 {
                    if random.random_bool(self.end) {
                        *offset = 0.0;
                    }
                } else if random.random_bool(self.begin) {
                    *offset = min + (max - min) * random.random::<f64>();
                }
            }
        }
        &self.offset_n
    }
}
