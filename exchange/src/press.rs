//! A press test of a skin: depth, force and time of one pad that a punch or a ball presses, and the law that fits them.
//!
//! The skin is an elastic foundation whose pressure at the depth d is p = C d (1 + β d) + C τ ḋ: foundation modulus C, hardening
//! β, loss time τ (docs/physics.md, Contact). The force of a flat punch of area A is A p. A ball of radius R presses an area
//! that grows with its depth, 2 π R d, so its force is π R C d² (1 + 2/3 β d) + 2 π R C τ d ḋ. Both are linear in C, C β and C
//! τ, which least squares find.

use std::f64::consts::PI;
use std::path::Path;

use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};
use underbrush_recording::limits::CSV_BYTES;
use underbrush_recording::{InputError, math, read_text};

/// Fewest samples under load.
const MIN_SAMPLES: usize = 20;

/// Draws of the bootstrap. The limits of 95 % are then the 13th smallest and largest.
const DRAWS: usize = 500;

/// Parts of a press that are drawn together, because noise and errors of neighbouring samples belong together.
const BLOCKS: usize = 25;

/// Shortest time at one depth from which creep is fitted, s.
const MIN_HOLD_S: f64 = 2.0;

/// One row of the file.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct PressSample {
    /// Time, s, rising.
    pub time_s: f64,
    /// Depth of the punch below the untouched surface, m.
    pub depth_m: f64,
    /// Force on the punch, N.
    pub force_n: f64,
}

/// What presses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Punch {
    /// A flat punch of this area, m².
    Flat(f64),
    /// A ball of this radius, m.
    Ball(f64),
}

/// A value with its interval of 95 %, from a bootstrap over parts of the press.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Lower and upper limit.
    pub interval: [f64; 2],
}

/// The fitted law.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PressFit {
    /// Foundation modulus C, N/m³.
    pub modulus_n_per_m3: Estimate,
    /// Loss time τ, s.
    pub loss_time_s: Estimate,
    /// Hardening β, 1/m.
    pub hardening_per_m: Estimate,
    /// Share of the force that a hold at one depth loses per decade of time; `None` without a hold of 2 s.
    pub relaxation_share_per_decade: Option<f64>,
    /// Root mean square of what is left, as a share of the largest force.
    pub residual_share: f64,
    /// Samples under load.
    pub samples: usize,
    /// Largest depth, m.
    pub largest_depth_m: f64,
}

/// Why a press cannot be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PressError {
    /// Too few samples under load.
    #[error("{0} samples have depth and force above 0; a fit needs at least 20")]
    FewSamples(usize),
    /// The terms cannot be told apart.
    #[error("stiffness, hardening and loss cannot be told apart: press to several depths and at two speeds")]
    Indistinct,
}

/// Reads a press from a CSV file with the columns `time_s`, `depth_m` and `force_n`.
///
/// # Errors
/// When the file cannot be read, a column is missing, a value is no finite number, or the time does not rise.
pub fn read_press(path: &Path) -> Result<Vec<PressSample>, InputError> {
    let remedy = "give a CSV file with the columns time_s, depth_m and force_n";
    let text = read_text(path, &CSV_BYTES, "a readable press test", remedy)?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let mut samples: Vec<PressSample> = Vec::new();
    for row in reader.deserialize() {
        let line = samples.len() + 2;
        let fault = |found: String, allowed: &str| InputError::new(path, "press", found, allowed, remedy).at_line(line);
        let sample: PressSample =
            row.map_err(|error| fault(error.to_string(), "numbers in the columns time_s, depth_m and force_n"))?;
        if ![sample.time_s, sample.depth_m, sample.force_n].iter().all(|value| value.is_finite()) {
            return Err(fault("a value that is not finite".into(), "finite numbers"));
        }
        if samples.last().is_some_and(|last| last.time_s >= sample.time_s) {
            return Err(fault(format!("time_s = {}", sample.time_s), "a time after that of the row before"));
        }
        samples.push(sample);
    }
    Ok(samples)
}

/// Fits the law.
///
/// # Errors
/// When there are too few samples under load, or the terms cannot be told apart.
pub fn fit_press(samples: &[PressSample], punch: Punch) -> Result<PressFit, PressError> {
    let rows = rows(samples, punch);
    if rows.len() < MIN_SAMPLES {
        return Err(PressError::FewSamples(rows.len()));
    }
    let best = solve(&rows).ok_or(PressError::Indistinct)?;
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let blocks: Vec<&[Row]> = rows.chunks(rows.len().div_ceil(BLOCKS)).collect();
    let mut draws: Vec<[f64; 3]> = (0..DRAWS)
        .filter_map(|_| {
            let drawn = (0..blocks.len()).flat_map(|_| blocks[random.random_range(0..blocks.len())]);
            solve(&drawn.copied().collect::<Vec<Row>>())
        })
        .collect();
    if draws.len() < DRAWS / 2 {
        return Err(PressError::Indistinct);
    }
    let mut estimate = |at: usize| {
        draws.sort_by(|a, b| a[at].total_cmp(&b[at]));
        let beyond = draws.len() / 40;
        Estimate { value: best[at], interval: [draws[beyond][at], draws[draws.len() - 1 - beyond][at]] }
    };
    let (modulus_n_per_m3, hardening_per_m, loss_time_s) = (estimate(0), estimate(1), estimate(2));
    let largest_n = rows.iter().map(|row| row.force_n).fold(0.0, f64::max);
    let squares: f64 = rows.iter().map(|row| (row.force_n - row.predicted_n(&best)).powi(2)).sum();
    Ok(PressFit {
        modulus_n_per_m3,
        loss_time_s,
        hardening_per_m,
        relaxation_share_per_decade: relaxation(samples),
        residual_share: (squares / rows.len() as f64).sqrt() / largest_n,
        samples: rows.len(),
        largest_depth_m: samples.iter().map(|sample| sample.depth_m).fold(0.0, f64::max),
    })
}

/// One sample: the force, and what C, C β and C τ are multiplied with.
#[derive(Clone, Copy)]
struct Row {
    force_n: f64,
    terms: [f64; 3],
}

impl Row {
    fn predicted_n(&self, [modulus, hardening, loss]: &[f64; 3]) -> f64 {
        modulus * (self.terms[0] + hardening * self.terms[1] + loss * self.terms[2])
    }
}

/// The samples under load. The speed is that between the neighbours of a sample.
fn rows(samples: &[PressSample], punch: Punch) -> Vec<Row> {
    // The force of a hold falls, which the law does not describe.
    let holds: Vec<&[PressSample]> = holds(samples).collect();
    let is_held =
        |time_s: f64| holds.iter().any(|hold| hold[0].time_s < time_s && time_s <= hold[hold.len() - 1].time_s);
    let row = |window: &[PressSample]| {
        let [before, PressSample { depth_m: d, force_n, time_s }, after] = *window else { return None };
        let speed = (after.depth_m - before.depth_m) / (after.time_s - before.time_s);
        let terms = match punch {
            Punch::Flat(area) => [area * d, area * d * d, area * speed],
            Punch::Ball(radius) => {
                [PI * radius * d * d, 2.0 / 3.0 * PI * radius * d.powi(3), 2.0 * PI * radius * d * speed]
            }
        };
        (d > 0.0 && force_n > 0.0 && !is_held(time_s)).then_some(Row { force_n, terms })
    };
    samples.windows(3).filter_map(row).collect()
}

/// Least squares: C, β and τ. `None` if they cannot be told apart.
fn solve(rows: &[Row]) -> Option<[f64; 3]> {
    // Columns of unit length keep the rank apart from the units.
    let lengths = [0, 1, 2].map(|at| rows.iter().map(|row| row.terms[at].powi(2)).sum::<f64>().sqrt());
    if lengths.contains(&0.0) {
        return None;
    }
    let matrix = DMatrix::from_fn(rows.len(), 3, |row, at| rows[row].terms[at] / lengths[at]);
    let forces = DVector::from_iterator(rows.len(), rows.iter().map(|row| row.force_n));
    let found = matrix.svd(true, true);
    if found.singular_values.min() < 1e-6 * found.singular_values.max() {
        return None;
    }
    let solution = found.solve(&forces, 0.0).ok()?;
    let modulus = solution[0] / lengths[0];
    (modulus > 0.0).then(|| [modulus, solution[1] / lengths[1] / modulus, solution[2] / lengths[2] / modulus])
}

/// The times of at least 2 s in which the depth stays within 2 % of the largest.
fn holds(samples: &[PressSample]) -> impl Iterator<Item = &[PressSample]> {
    let largest_m = samples.iter().map(|sample| sample.depth_m).fold(0.0, f64::max);
    let is_level = move |a: &PressSample, b: &PressSample| (a.depth_m - b.depth_m).abs() < 0.02 * largest_m;
    let level = samples.chunk_by(move |a, b| is_level(a, b) && a.force_n > 0.0 && b.force_n > 0.0);
    // A slow press is level from sample to sample, too.
    level.filter(move |hold| length_s(hold) >= MIN_HOLD_S && hold.iter().all(|sample| is_level(sample, &hold[0])))
}

fn length_s(hold: &[PressSample]) -> f64 {
    hold[hold.len() - 1].time_s - hold[0].time_s
}

/// The slope of the force over the decades of the longest hold, as a share of its force after a tenth of a second; `None` if no
/// hold is long enough.
fn relaxation(samples: &[PressSample]) -> Option<f64> {
    let hold = holds(samples).max_by(|a, b| length_s(a).total_cmp(&length_s(b)))?;
    let points = hold.iter().map(|sample| (sample.time_s - hold[0].time_s, sample.force_n));
    let points: Vec<(f64, f64)> = points
        .filter(|(time_s, _)| *time_s >= 0.1)
        .map(|(time_s, force_n)| (math::log10(time_s / 0.1), force_n))
        .collect();
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let (decade, force_n) = (mean(|point| point.0), mean(|point| point.1));
    let covariance: f64 = points.iter().map(|point| (point.0 - decade) * (point.1 - force_n)).sum();
    let slope = covariance / points.iter().map(|point| (point.0 - decade).powi(2)).sum::<f64>();
    Some(-slope / (force_n - slope * decade))
}

#[cfg(test)]
mod tests;
