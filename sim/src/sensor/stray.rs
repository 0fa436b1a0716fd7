//! Strays: taxels that read a small force though nothing touches them, since the cover has come to lie a little
//! otherwise than when the skin was zeroed.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use underbrush_recording::FRAME_PERIOD_S;

use super::options::SensorOptions;

/// The strays of one patch. Each taxel's offset is a telegraph process: zero for a while, then one force for a while.
pub struct Strays {
    /// Chances of a taxel, in a frame, to begin to stray and to stop.
    begin: f64,
    end: f64,
    force_n: [f64; 2],
    /// The offset of each taxel at the moment, N; 0 where it does not stray.
    offset_n: Vec<f64>,
}

impl Strays {
    /// The strays of so many taxels; none yet, as the skin is zeroed before a reach.
    pub fn new(options: &SensorOptions, taxels: usize) -> Self {
        let end = -(-FRAME_PERIOD_S / options.stray_time_s).exp_m1();
        Strays {
            // In the long run a share s strays where as many begin as end: begin · (1 − s) = end · s.
            begin: end * options.stray_share / (1.0 - options.stray_share),
            end,
            force_n: options.stray_force_n,
            offset_n: vec![0.0; taxels],
        }
    }

    /// Goes on by one frame; the offsets of all taxels, N.
    pub fn advance(&mut self, random: &mut ChaCha8Rng) -> &[f64] {
        if self.begin > 0.0 {
            let [least, most] = self.force_n;
            for offset in &mut self.offset_n {
                if *offset > 0.0 {
                    if random.random_bool(self.end) {
                        *offset = 0.0;
                    }
                } else if random.random_bool(self.begin) {
                    *offset = least + (most - least) * random.random::<f64>();
                }
            }
        }
        &self.offset_n
    }
}
