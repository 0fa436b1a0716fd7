//! Capacitive skin: capacitors under a continuous cover (crosstalk, creep), read by the authors' driver. Some taxels read a
//! small force although nothing touches them, because the cover has shifted a little since the skin was zeroed.

use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use underbrush_recording::{FRAME_PERIOD_S, Patch, math};

use super::options::SensorOptions;
use super::shared::{Noise, quantized, steps_per_n};
use crate::seed::share;

/// Retardation times of the cover's creep, s. With one per decade, the reading of a held force grows with the logarithm
/// of time between the first and the last, as the strain of rubber does.
pub const CREEP_TIMES_S: [f64; 4] = [0.1, 1.0, 10.0, 100.0];

/// The capacitive taxels of one patch.
#[derive(Clone, Serialize, Deserialize)]
pub struct Capacitive {
    /// The four neighbours of each taxel; the taxel itself in place of a neighbour that the grid does not have.
    neighbours: Vec<[usize; 4]>,
    crosstalk_share: f64,
    creep_share: f64,
    /// Share of the remaining creep that each element completes in one frame.
    creep_advance: [f64; CREEP_TIMES_S.len()],
    /// Creep of each taxel so far, as a force, N, by retardation time.
    crept_n: Vec<[f64; CREEP_TIMES_S.len()]>,
    /// The taxels that a force has reached so far. The others feel nothing and have not crept.
    reached: Vec<usize>,
    is_reached: Vec<bool>,
    spurious: SpuriousReadings,
    noise: Noise,
    floor_n: f64,
    saturation_n: f64,
    steps_per_n: f64,
}

impl Capacitive {
    /// The taxels of a patch, unloaded.
    pub fn new(options: &SensorOptions, patch: &Patch) -> Self {
        Capacitive {
            neighbours: neighbours(patch),
            crosstalk_share: options.crosstalk_share,
            creep_share: options.creep_share_per_decade,
            creep_advance: CREEP_TIMES_S.map(|time_s| -math::exp_m1(-FRAME_PERIOD_S / time_s)),
            crept_n: vec![[0.0; CREEP_TIMES_S.len()]; patch.taxels.len()],
            reached: Vec::new(),
            is_reached: vec![false; patch.taxels.len()],
            spurious: SpuriousReadings::new(options, patch.taxels.len()),
            noise: Noise::new(options.noise_n, options.gate_sigmas * options.noise_n),
            floor_n: options.floor_n,
            saturation_n: options.saturation_n,
            steps_per_n: steps_per_n(options.quantum_n),
        }
    }

    /// Turns the true forces on all taxels into one set of readings, N.
    pub fn read(
        &mut self,
        true_force_n: &[f64],
        reading_n: &mut [f64],
        random: &mut ChaCha8Rng,
        random_spurious: &mut ChaCha8Rng,
    ) {
        for taxel in (0..true_force_n.len()).filter(|taxel| true_force_n[*taxel] != 0.0) {
            for reached in self.neighbours[taxel].into_iter().chain([taxel]) {
                if !std::mem::replace(&mut self.is_reached[reached], true) {
                    self.reached.push(reached);
                }
            }
        }
        reading_n.copy_from_slice(self.spurious.advance(random_spurious));
        for taxel in &self.reached {
            let felt = felt(&self.neighbours[*taxel], self.crosstalk_share, true_force_n, *taxel);
            let crept = &mut self.crept_n[*taxel];
            // Kelvin-Voigt elements, dz/dt = (f − z)/τ, integrated exactly for a force that is constant over the frame.
            for (crept, advance) in crept.iter_mut().zip(self.creep_advance) {
                *crept += (felt - *crept) * advance;
            }
            reading_n[*taxel] += felt + self.creep_share * crept.iter().sum::<f64>();
        }
        self.noise.add(reading_n, random);
        for reading in reading_n.iter_mut().filter(|reading| **reading != 0.0) {
            let is_read = *reading >= self.floor_n;
            *reading = if is_read { quantized(*reading, self.steps_per_n).clamp(0.0, self.saturation_n) } else { 0.0 };
        }
    }
}

/// The force on a taxel's capacitor, N, after the cover has passed part of it to the neighbours and part of their
/// forces to the taxel.
///
/// A taxel with fewer than four neighbours keeps the parts of those that are missing. Each column of the kernel
/// therefore sums to 1, and no force is lost.
fn felt(neighbours: &[usize; 4], crosstalk_share: f64, force_n: &[f64], taxel: usize) -> f64 {
    let around: f64 = neighbours.iter().map(|next| force_n[*next]).sum();
    force_n[taxel] + crosstalk_share * (around / 4.0 - force_n[taxel])
}

/// The four neighbours in the patch's grid, around the sleeve if it wraps. Without a grid a taxel has none.
fn neighbours(patch: &Patch) -> Vec<[usize; 4]> {
    let in_grid = |taxel: usize| patch.grid.map_or([None; 4], |grid| grid.neighbours(taxel));
    (0..patch.taxels.len()).map(|taxel| in_grid(taxel).map(|next| next.unwrap_or(taxel))).collect()
}

/// The spurious readings of one patch. Each taxel's offset is a telegraph process: it is zero for a while, then one
/// constant force for a while.
#[derive(Clone, Serialize, Deserialize)]
struct SpuriousReadings {
    /// Probability per frame that a taxel's spurious reading begins, and that it ends.
    begin: f64,
    end: f64,
    force_n: [f64; 2],
    /// Present offset of each taxel, N; 0 for a taxel without a spurious reading.
    offset_n: Vec<f64>,
    /// Buffer of the numbers that are drawn in a frame.
    #[serde(skip)]
    drawn: Vec<u64>,
}

impl SpuriousReadings {
    /// Starts without any, because the skin is zeroed before a reach.
    fn new(options: &SensorOptions, taxels: usize) -> Self {
        let end = -math::exp_m1(-FRAME_PERIOD_S / options.spurious_time_s);
        SpuriousReadings {
            // In the steady state a share s of the taxels is affected and as many begin as end: begin · (1 − s) = end ·
            // s.
            begin: end * options.spurious_share / (1.0 - options.spurious_share),
            end,
            force_n: options.spurious_force_n,
            offset_n: vec![0.0; taxels],
            drawn: Vec::new(),
        }
    }

    /// Advances by one frame and returns the offsets of all taxels, N.
    fn advance(&mut self, random: &mut ChaCha8Rng) -> &[f64] {
        if self.begin > 0.0 {
            let [min, max] = self.force_n;
            let [begin, end] = [self.begin, self.end].map(|probability| (probability * 2_f64.powi(64)) as u64);
            // Each taxel takes at least one number, and all of them are faster to draw at once.
            self.drawn.resize(self.offset_n.len(), 0);
            random.fill(self.drawn.as_mut_slice());
            let mut drawn = self.drawn.iter();
            let mut next = || drawn.next().copied().unwrap_or_else(|| random.next_u64());
            for offset in &mut self.offset_n {
                let number = next();
                if *offset > 0.0 {
                    if number < end {
                        *offset = 0.0;
                    }
                } else if number < begin {
                    *offset = min + (max - min) * share(next());
                }
            }
        }
        &self.offset_n
    }
}
