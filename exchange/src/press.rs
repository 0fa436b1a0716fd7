//! A press test of a skin: depth, force and time of one pad that a punch or a ball presses, and the law that fits them.
//!
//! The skin is an elastic foundation whose pressure at the depth d is p(d) + τ dp/dt with p = C d / (1 − β d): foundation
//! modulus C at small depths, loss time τ, and hardening β, the inverse of the depth that it cannot reach (docs/physics.md,
//! Contact). The force of a flat punch of area A is A p. A ball of radius R presses an area that grows with its depth, so its
//! force is 2 π R times the integral of p over the depth. Least squares find C, β and τ by the Gauss-Newton method.

use std::f64::consts::PI;
use std::path::Path;

use nalgebra::{DMatrix, DVector};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};
use underbrush_recording::fault::line_of_row;
use underbrush_recording::limits::CSV_BYTES;
use underbrush_recording::{InputError, math, read_text};

use crate::straight_line;

/// Fewest samples under load.
const MIN_SAMPLES: usize = 20;

/// Draws of the bootstrap. The limits of 95 % are then the 13th smallest and largest.
const DRAWS: usize = 500;

/// Parts of a press that are drawn together, because noise and errors of neighbouring samples belong together.
const BLOCKS: usize = 25;

/// The intervals of a bootstrap over so few parts are too narrow. They are widened by √(25/24) and by the ratio of Student's t
/// with 24 degrees of freedom to the limit of a normal distribution.
const WIDENED: f64 = 1.0206 * 2.064 / 1.960;

/// Depths over which the pressure under a ball is summed.
const DEPTHS: usize = 64;

/// Limit of the steps of the fit.
const MAX_STEPS: usize = 50;

/// The largest share of its thickness by which a layer can have been pressed. Beyond, its force has no bound.
const MOST_PRESSED: f64 = 0.98;

/// A press has one speed if the middle four fifths of its speeds differ by less than this share of their median. Loss then cannot
/// be told from stiffness.
const ONE_SPEED: f64 = 0.1;

/// Shortest time at one depth from which creep is fitted, s.
const MIN_HOLD_S: f64 = 2.0;

/// How much the depth may vary in a hold, as a share of the largest depth. Choice: the noise of a sensor.
const VARIES: f64 = 0.02;
/// How much the depth may drift in a hold, as a share of the largest depth. Choice: much less than a slow press moves while
/// its depth varies by [`VARIES`].
const DRIFTS: f64 = 0.005;

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
    /// Loss time τ, s; `None` if the punch only pressed at one speed.
    pub loss_time_s: Option<Estimate>,
    /// Hardening β, 1/m: the inverse of the thickness of the layer.
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
    #[error("a fit needs at least 20 samples with depth and force above 0, outside of holds; there are {0}")]
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
    let mut rows = reader.deserialize();
    loop {
        let line = line_of_row(text.as_bytes(), rows.reader().position());
        let Some(row) = rows.next() else { return Ok(samples) };
        let fault = |found: String, allowed: &str| InputError::new(path, "press", found, allowed, remedy).at_line(line);
        let sample: PressSample =
            row.map_err(|error| InputError::of_csv(path, "press", text.as_bytes(), error, remedy).at_line(line))?;
        if ![sample.time_s, sample.depth_m, sample.force_n].iter().all(|value| value.is_finite()) {
            return Err(fault("a value that is not finite".into(), "finite numbers"));
        }
        if samples.last().is_some_and(|last| last.time_s >= sample.time_s) {
            return Err(fault(format!("time_s = {}", sample.time_s), "a time after that of the row before"));
        }
        samples.push(sample);
    }
}

/// Fits the law.
///
/// # Errors
/// When there are too few samples under load, or the terms cannot be told apart.
pub fn fit_press(samples: &[PressSample], punch: Punch) -> Result<PressFit, PressError> {
    let mut rows = rows(samples);
    if rows.len() < MIN_SAMPLES {
        return Err(PressError::FewSamples(rows.len()));
    }
    let one_speed = has_one_speed(&rows);
    if one_speed {
        rows.iter_mut().for_each(|row| row.speed_m_per_s = 0.0);
    }
    // Near the best fit the law is linear in its constants, so a draw needs one step of the method.
    let (best, linear) = fit(&rows, punch).ok_or(PressError::Indistinct)?;
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let blocks: Vec<&[Linear]> = linear.chunks(linear.len().div_ceil(BLOCKS)).collect();
    let mut draws: Vec<[f64; 3]> = (0..DRAWS)
        .filter_map(|_| {
            let drawn = (0..blocks.len()).flat_map(|_| blocks[random.random_range(0..blocks.len())]);
            solve(&drawn.copied().collect::<Vec<Linear>>()).map(|step| moved(&best, &step, 1.0))
        })
        .collect();
    if draws.len() < DRAWS / 2 {
        return Err(PressError::Indistinct);
    }
    let mut estimate = |at: usize| {
        draws.sort_by(|a, b| a[at].total_cmp(&b[at]));
        let beyond = draws.len() / 40;
        let limit = |draw: usize| best[at] + WIDENED * (draws[draw][at] - best[at]);
        Estimate { value: best[at], interval: [limit(beyond), limit(draws.len() - 1 - beyond)] }
    };
    let (modulus_n_per_m3, hardening_per_m, loss_time_s) = (estimate(0), estimate(1), estimate(2));
    let largest_n = rows.iter().map(|row| row.force_n).fold(0.0, f64::max);
    let squares: f64 = linear.iter().map(|row| row.missing_n.powi(2)).sum();
    Ok(PressFit {
        modulus_n_per_m3,
        loss_time_s: (!one_speed).then_some(loss_time_s),
        hardening_per_m,
        relaxation_share_per_decade: relaxation(samples),
        residual_share: (squares / rows.len() as f64).sqrt() / largest_n,
        samples: rows.len(),
        largest_depth_m: samples.iter().map(|sample| sample.depth_m).fold(0.0, f64::max),
    })
}

/// One sample under load.
#[derive(Clone, Copy)]
struct Row {
    depth_m: f64,
    speed_m_per_s: f64,
    force_n: f64,
}

/// A sample near some constants: what their force lacks, and its slopes with respect to ln C, β and τ.
#[derive(Clone, Copy)]
struct Linear {
    missing_n: f64,
    slopes: [f64; 3],
}

impl Row {
    fn linear(&self, punch: Punch, [modulus, hardening, loss_s]: &[f64; 3]) -> Linear {
        let Row { depth_m: d, speed_m_per_s, force_n } = *self;
        // Force over C, its slope with respect to the depth, and the slopes of both with respect to β.
        let rest = 1.0 - hardening * d;
        let [pressed, by_depth, by_hardening, both] = match punch {
            Punch::Flat(area) => {
                [d / rest, 1.0 / rest.powi(2), (d / rest).powi(2), 2.0 * d / rest.powi(3)].map(|of| area * of)
            }
            Punch::Ball(radius) => {
                let spacing = d / DEPTHS as f64;
                let (mut sum, mut slope) = (0.0, 0.0);
                for at in 0..DEPTHS {
                    let depth_m = (at as f64 + 0.5) * spacing;
                    let pressed = depth_m / (1.0 - hardening * depth_m);
                    (sum, slope) = (sum + pressed * spacing, slope + pressed * pressed * spacing);
                }
                [sum, d / rest, slope, (d / rest).powi(2)].map(|of| 2.0 * PI * radius * of)
            }
        };
        let predicted_n = modulus * (pressed + loss_s * speed_m_per_s * by_depth);
        let slopes =
            [predicted_n, modulus * (by_hardening + loss_s * speed_m_per_s * both), modulus * speed_m_per_s * by_depth];
        Linear { missing_n: force_n - predicted_n, slopes }
    }
}

/// Constants after a share of a step.
fn moved(from: &[f64; 3], step: &[f64; 3], share: f64) -> [f64; 3] {
    [from[0] * math::exp(share * step[0]), from[1] + share * step[1], from[2] + share * step[2]]
}

/// C, β and τ, and the samples near them. `None` if they cannot be told apart.
fn fit(rows: &[Row], punch: Punch) -> Option<([f64; 3], Vec<Linear>)> {
    let deepest_m = rows.iter().map(|row| row.depth_m).fold(0.0, f64::max);
    let linear = |constants: &[f64; 3]| rows.iter().map(|row| row.linear(punch, constants)).collect::<Vec<_>>();
    let misfit = |rows: &[Linear]| rows.iter().map(|row| row.missing_n.powi(2)).sum::<f64>();
    // The force that the start predicts is right on average.
    let unit = linear(&[1.0, 0.0, 0.0]);
    let predicted_n: f64 = unit.iter().map(|row| row.slopes[0]).sum();
    let mut constants = [rows.iter().map(|row| row.force_n).sum::<f64>() / predicted_n, 0.0, 0.0];
    let mut now = linear(&constants);
    for _ in 0..MAX_STEPS {
        let step = solve(&now)?;
        // A layer is thicker than the deepest press.
        let better = (0..20).map(|halvings| moved(&constants, &step, 0.5_f64.powi(halvings))).find_map(|trial| {
            let next = (trial[1] * deepest_m < MOST_PRESSED).then(|| linear(&trial))?;
            (misfit(&next) < misfit(&now)).then_some((trial, next))
        });
        let Some((trial, next)) = better else { break };
        let gain = 1.0 - misfit(&next) / misfit(&now);
        (constants, now) = (trial, next);
        if gain < 1e-12 {
            break;
        }
    }
    Some((constants, now))
}

/// The samples under load. The speed is that between the neighbours of a sample.
fn rows(samples: &[PressSample]) -> Vec<Row> {
    // The force of a hold falls, which the law does not describe.
    let holds = holds(samples);
    let is_held =
        |time_s: f64| holds.iter().any(|hold| hold[0].time_s < time_s && time_s <= hold[hold.len() - 1].time_s);
    let row = |&[before, PressSample { depth_m: d, force_n, time_s }, after]: &[PressSample; 3]| {
        let speed_m_per_s = (after.depth_m - before.depth_m) / (after.time_s - before.time_s);
        (d > 0.0 && force_n > 0.0 && !is_held(time_s)).then_some(Row { depth_m: d, speed_m_per_s, force_n })
    };
    samples.array_windows().filter_map(row).collect()
}

/// Whether the punch only pressed at one speed.
fn has_one_speed(rows: &[Row]) -> bool {
    let speeds = math::sorted(rows.iter().map(|row| row.speed_m_per_s).collect());
    let [low, median, high] = [1, 5, 9].map(|tenths| speeds[(speeds.len() - 1) * tenths / 10]);
    high - low < ONE_SPEED * median.abs()
}

/// Least squares: the changes of ln C, β and τ that make up for what is missing. `None` if they cannot be told apart.
fn solve(rows: &[Linear]) -> Option<[f64; 3]> {
    // Columns of unit length keep the rank apart from the units.
    let lengths = [0, 1, 2].map(|at| rows.iter().map(|row| row.slopes[at].powi(2)).sum::<f64>().sqrt());
    // Without speeds there is no loss.
    let count = if lengths[2] > 0.0 { 3 } else { 2 };
    // The squares of extreme numbers are infinite or 0.
    if !lengths[..count].iter().all(|length| length.is_normal()) {
        return None;
    }
    let matrix = DMatrix::from_fn(rows.len(), count, |row, at| rows[row].slopes[at] / lengths[at]);
    let missing = DVector::from_iterator(rows.len(), rows.iter().map(|row| row.missing_n));
    let found = matrix.svd(true, true);
    if found.singular_values.min() < 1e-6 * found.singular_values.max() {
        return None;
    }
    let solution = found.solve(&missing, 0.0).ok()?;
    Some([0, 1, 2].map(|at| solution.get(at).map_or(0.0, |own| own / lengths[at])))
}

/// The times of at least 2 s in which the depth stays, in their order.
fn holds(samples: &[PressSample]) -> Vec<&[PressSample]> {
    let largest_m = samples.iter().map(|sample| sample.depth_m).fold(0.0, f64::max);
    let (mut found, mut rest) = (Vec::new(), samples);
    while let [first, ..] = rest {
        let is_near = |own: &&PressSample| (own.depth_m - first.depth_m).abs() < VARIES * largest_m;
        let level = &rest[..rest.iter().take_while(|own| own.force_n > 0.0 && is_near(own)).count()];
        let hold = still(level, DRIFTS * largest_m);
        found.extend(hold);
        // After no hold, one may begin within these samples.
        rest = &rest[if hold.is_some() { level.len() } else { (level.len() / 8).max(1) }..];
    }
    found
}

/// The samples of a level stretch without those of a press that leads to it or away from it; `None` if it is no hold.
fn still(level: &[PressSample], drift_m: f64) -> Option<&[PressSample]> {
    if level.is_empty() || length_s(level) < MIN_HOLD_S {
        return None;
    }
    let depth_m = |of: &[PressSample]| math::median(of.iter().map(|sample| sample.depth_m).collect());
    let (early, late) = level.split_at(level.len() / 2);
    let is_drifting = (depth_m(early)? - depth_m(late)?).abs() >= drift_m;
    let middle_m = depth_m(level)?;
    let is_still = |sample: &PressSample| (sample.depth_m - middle_m).abs() < drift_m;
    let hold = &level[level.iter().position(is_still)?..=level.iter().rposition(is_still)?];
    (!is_drifting && length_s(hold) >= MIN_HOLD_S).then_some(hold)
}

fn length_s(hold: &[PressSample]) -> f64 {
    hold[hold.len() - 1].time_s - hold[0].time_s
}

/// The slope of the force over the decades of the longest hold, as a share of its force after a tenth of a second; `None` if no
/// hold is long enough, or has too few samples.
fn relaxation(samples: &[PressSample]) -> Option<f64> {
    let hold = holds(samples).into_iter().max_by(|a, b| length_s(a).total_cmp(&length_s(b)))?;
    let points = hold.iter().map(|sample| (sample.time_s - hold[0].time_s, sample.force_n));
    let points = points.filter(|(time_s, _)| *time_s >= 0.1);
    let [start_n, slope] = straight_line(points.map(|(time_s, force_n)| (math::log10(time_s / 0.1), force_n)));
    Some(-slope / start_n).filter(|share| share.is_finite())
}

#[cfg(test)]
mod tests;
