//! The capacitive skin: a continuous cover over capacitors (crosstalk, creep) and the authors' driver behind them.

use rand_chacha::ChaCha8Rng;
use underbrush_recording::{FRAME_PERIOD_S, Grid, Patch};

use super::converter::{Converter, Noise};
use super::options::SensorOptions;
use super::spurious::SpuriousReadings;

/// Retardation times of the cover's creep, s: one a decade, so that between the first and the last a held force's reading
/// grows with the logarithm of time, as rubber's strain does.
pub const CREEP_TIMES_S: [f64; 4] = [0.1, 1.0, 10.0, 100.0];

/// The capacitive taxels of one patch.
#[derive(Clone)]
pub struct Capacitive {
    /// Four neighbours of each taxel; the taxel itself stands for one that the grid does not have.
    neighbours: Vec<[usize; 4]>,
    crosstalk_share: f64,
    creep_share: f64,
    /// Share of the way to its end that each part of the creep goes in a frame.
    creep_advance: [f64; CREEP_TIMES_S.len()],
    /// The forces that each taxel has crept to, N, by retardation time.
    crept_n: Vec<[f64; CREEP_TIMES_S.len()]>,
    spurious: SpuriousReadings,
    noise: Noise,
    gate_n: f64,
    floor_n: f64,
    saturation_n: f64,
    converter: Converter,
}

impl Capacitive {
    /// The taxels of a patch, at rest.
    pub fn new(options: &SensorOptions, patch: &Patch) -> Self {
        Capacitive {
            neighbours: neighbours(patch),
            crosstalk_share: options.crosstalk_share,
            creep_share: options.creep_share_per_decade,
            creep_advance: CREEP_TIMES_S.map(|time_s| -(-FRAME_PERIOD_S / time_s).exp_m1()),
            crept_n: vec![[0.0; CREEP_TIMES_S.len()]; patch.taxels.len()],
            spurious: SpuriousReadings::new(options, patch.taxels.len()),
            noise: Noise::new(options.noise_n),
            gate_n: options.gate_sigmas * options.noise_n,
            floor_n: options.floor_n,
            saturation_n: options.saturation_n,
            converter: Converter::with_quantum(options.quantum_n),
        }
    }

    /// Reads all taxels once: true forces in, readings out, N.
    pub fn read(
        &mut self,
        true_force_n: &[f64],
        reading_n: &mut [f64],
        random: &mut ChaCha8Rng,
        random_spurious: &mut ChaCha8Rng,
    ) {
        let offsets = self.spurious.advance(random_spurious);
        for (taxel, (reading, offset)) in reading_n.iter_mut().zip(offsets).enumerate() {
            let felt = felt(&self.neighbours[taxel], self.crosstalk_share, true_force_n, taxel);
            // Kelvin-Voigt elements, exact for a force that is constant over the frame: dz/dt = (f − z)/τ.
            let crept = &mut self.crept_n[taxel];
            for (crept, advance) in crept.iter_mut().zip(self.creep_advance) {
                *crept += (felt - *crept) * advance;
            }
            let analog = felt + self.creep_share * crept.iter().sum::<f64>() + offset + self.noise.draw(random);
            *reading = if analog.abs() < self.gate_n || analog < self.floor_n {
                0.0
            } else {
                self.converter.convert(analog).clamp(0.0, self.saturation_n)
            };
        }
    }
}

/// The force on a taxel's capacitor, N: what the cover leaves it of its own and hands it from its neighbours.
///
/// Where a taxel has fewer than four neighbours it keeps their parts, so each column of the kernel sums to 1: force is
/// moved, none is lost.
fn felt(neighbours: &[usize; 4], crosstalk_share: f64, force_n: &[f64], taxel: usize) -> f64 {
    let around: f64 = neighbours.iter().map(|next| force_n[*next]).sum();
    force_n[taxel] + crosstalk_share * (around / 4.0 - force_n[taxel])
}

/// The four neighbours in the patch's grid, around the sleeve where it wraps; without a grid a taxel has none.
fn neighbours(patch: &Patch) -> Vec<[usize; 4]> {
    let count = patch.taxels.len();
    let Some(Grid { rows, columns, wraps }) = patch.grid else {
        return (0..count).map(|taxel| [taxel; 4]).collect();
    };
    let of = |taxel: usize| {
        let (row, column) = (taxel / columns, taxel % columns);
        let or_itself = |exists: bool, next: usize| if exists { next } else { taxel };
        let first = row * columns;
        let last = first + columns - 1;
        let before = if column > 0 { taxel - 1 } else { last };
        let behind = if column + 1 < columns { taxel + 1 } else { first };
        [
            or_itself(row > 0, taxel.wrapping_sub(columns)),
            or_itself(row + 1 < rows, taxel + columns),
            or_itself(wraps || column > 0, before),
            or_itself(wraps || column + 1 < columns, behind),
        ]
    };
    (0..count).map(of).collect()
}
