//! How an object answers to the skin: to the first touch, to each step of the skin, and to its vibration.
//!
//! Stiffness alone hardly tells a branch or a roll from a leaf. A leaf gives way at once. Objects with mass or loss answer a quick
//! push with a larger force, or later. Three groups of features describe this:
//!
//! * the rise of force over press in the first frames,
//! * the spectra of force and of the skin's path along its normal, and how the two belong together, in five bands of an octave,
//! * a linear model of the next step of the force.

use std::array;
use std::f64::consts::TAU;

use nalgebra::{Complex, SMatrix, SVector};
use underbrush_recording::math;

use crate::touch::compress::{PLAIN, compress};
use crate::touch::contact_history::{FORCE_KNEE_N, MOTION_KNEE_M, STIFFNESS_KNEE_N_PER_M};

/// Frames after the first touch at which force and press are features.
const EARLY_FRAMES: [usize; 6] = [2, 3, 5, 10, 20, 40];
/// The features at each of these frames, with their knees: force, press, and the rise of force over press.
const OF_EARLY: [f64; 3] = [FORCE_KNEE_N, MOTION_KNEE_M, STIFFNESS_KNEE_N_PER_M];
/// Added to the press that the rise of force is divided by, m. Choice: the skin's way in a frame at 2 cm/s.
const LEAST_PRESS_M: f64 = 2e-4;

/// Frames of a spectrum, 0.64 s, and the frames from one spectrum to the next.
const WINDOW: usize = 64;
const HOP: usize = 32;
/// The first line of each band and the first line beyond it. A line is 1/0.64 s, so the bands begin at 1.6, 3.1, 6.3, 12.5 and 25 Hz.
const BANDS: [[usize; 2]; 5] = [[1, 2], [2, 4], [4, 8], [8, 16], [16, 27]];
/// The features of a band, with their knees: the power of the force over the square of its mean, the power of the skin's path, the real
/// part and the phase of the stiffness, and the coherence of force and path.
const OF_BAND: [f64; 5] = [PLAIN, PLAIN, STIFFNESS_KNEE_N_PER_M, PLAIN, PLAIN];
/// Added to powers, so that their logarithms and ratios are finite.
const LEAST_SHARE: f64 = 1e-9;
const LEAST_POWER_M2: f64 = 1e-12;
/// A spectrum or a step counts if the force is larger than this, N. Choice: half as much again as spurious readings.
const FELT_N: f64 = 0.15;

/// The terms of the linear model of the next step of the force: press in this frame and in the last one, mm; the force, tens of N; the
/// products of the force with press and with slide, N mm; and a constant.
const TERMS: usize = 6;
const CONSTANT: f64 = 0.1;
/// Added to the diagonal of the normal equations. Choice: the press of some twenty frames at 5 mm/s.
const RIDGE: f64 = 0.05;
/// The fewest steps of a fit.
const FEWEST_STEPS: f64 = 15.0;
/// Features of the model: its coefficients, the logarithm of its error as a share of the mean force, and the sum of the first two
/// coefficients.
const OF_MODEL: usize = TERMS + 2;

/// Stands for what was not measured; far below everything else.
const MISSING: f64 = -1e9;
/// Two frames count as consecutive if they are at most this far apart, s.
const FOLLOWS_S: f64 = 0.015;

/// Number of features.
pub(super) const RESPONSE_FEATURE_COUNT: usize =
    EARLY_FRAMES.len() * OF_EARLY.len() + BANDS.len() * OF_BAND.len() + OF_MODEL;

/// Sums over the lines of a band and all spectra.
#[derive(Clone, Copy, Debug, Default)]
struct Band {
    /// Power of the force over the square of its mean.
    share: f64,
    force_power: f64,
    path_power: f64,
    /// The spectrum of the force times the conjugate of that of the path.
    product: Complex<f64>,
}

/// Running statistics of the answers of an object.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Response {
    frames: usize,
    /// Frames that follow each other, up to this one.
    in_a_row: usize,
    time_s: f64,
    force_n: f64,
    press_m: f64,
    path_m: f64,
    first_force_n: f64,
    /// What was felt in each of [`EARLY_FRAMES`]; `None` before it, or if a frame until then was missing.
    early: [Option<[f64; OF_EARLY.len()]>; EARLY_FRAMES.len()],
    /// Force, N, and path, m, of the last frames. Frame n is at index n modulo [`WINDOW`] of the flattened list, which is divided
    /// because longer lists have no default.
    window: [[[f64; 2]; HOP]; WINDOW / HOP],
    spectra: f64,
    bands: [Band; BANDS.len()],
    /// Sums of the products of the terms and the step of the force with each other.
    products: SMatrix<f64, { TERMS + 1 }, { TERMS + 1 }>,
    steps: f64,
    sum_n: f64,
}

impl Response {
    /// Takes in a frame in which the object touches the skin: its time, the force, and the skin's motion since the last frame along
    /// its normal and sideways.
    pub(super) fn push(&mut self, time_s: f64, force_n: f64, press_m: f64, slide_m: f64) {
        let before_n = self.force_n;
        if self.frames == 0 {
            self.first_force_n = force_n;
        } else {
            self.path_m += press_m;
        }
        self.in_a_row = if self.frames > 0 && time_s - self.time_s <= FOLLOWS_S { self.in_a_row + 1 } else { 1 };
        if self.in_a_row > self.frames
            && let Some(early) = EARLY_FRAMES.iter().position(|frame| *frame == self.frames)
        {
            let rise_n_per_m = (force_n - self.first_force_n) / (self.path_m.abs() + LEAST_PRESS_M);
            self.early[early] = Some([force_n, self.path_m, rise_n_per_m]);
        }
        if self.in_a_row > 2 && before_n > FELT_N {
            let (now_mm, last_mm) = (1e3 * press_m, 1e3 * self.press_m);
            let slid_n_mm = before_n * 1e3 * slide_m;
            let step_n = force_n - before_n;
            let row = [now_mm, last_mm, 0.1 * before_n, before_n * now_mm, slid_n_mm, CONSTANT, step_n];
            let row = SVector::from(row);
            self.products += row * row.transpose();
            self.steps += 1.0;
            self.sum_n += before_n;
        }
        self.window.as_flattened_mut()[self.frames % WINDOW] = [force_n, self.path_m];
        self.frames += 1;
        if self.in_a_row >= WINDOW && (self.in_a_row - WINDOW).is_multiple_of(HOP) {
            self.add_spectrum();
        }
        (self.time_s, self.force_n, self.press_m) = (time_s, force_n, press_m);
    }

    /// Adds the spectra of the last frames.
    fn add_spectrum(&mut self) {
        let frame = |number: usize| self.window.as_flattened()[(self.frames + number) % WINDOW];
        let mean_n = (0..WINDOW).map(|number| frame(number)[0]).sum::<f64>() / WINDOW as f64;
        if mean_n <= FELT_N {
            return;
        }
        // Powers of exp(−2πi/64).
        let turns: [Complex<f64>; WINDOW] = array::from_fn(|number| {
            let (sine, cosine) = math::sin_cos(TAU * number as f64 / WINDOW as f64);
            Complex::new(cosine, -sine)
        });
        let signals = [0, 1].map(|signal| tapered(array::from_fn(|number| frame(number)[signal])));
        for (band, [first, beyond]) in self.bands.iter_mut().zip(BANDS) {
            for line in first..beyond {
                let [force, path] = signals.map(|signal| {
                    let terms = signal.iter().enumerate();
                    terms.map(|(number, value)| turns[number * line % WINDOW] * *value).sum::<Complex<f64>>()
                });
                band.share += force.norm_sqr() / (mean_n * mean_n);
                band.force_power += force.norm_sqr();
                band.path_power += path.norm_sqr();
                band.product += force * path.conj();
            }
        }
        self.spectra += 1.0;
    }

    /// The features.
    pub(super) fn features(&self) -> [f64; RESPONSE_FEATURE_COUNT] {
        let early = self.early.map(|values| compress(values.unwrap_or([MISSING; OF_EARLY.len()]), &OF_EARLY));
        let bands: [_; BANDS.len()] = array::from_fn(|band| compress(self.of_band(band), &OF_BAND));
        let model = self.of_model();
        let mut values = early.iter().flatten().chain(bands.iter().flatten()).chain(&model);
        array::from_fn(|_| values.next().copied().unwrap_or_default())
    }

    fn of_band(&self, band: usize) -> [f64; OF_BAND.len()] {
        let (Band { share, force_power, path_power, product }, [first, beyond]) = (self.bands[band], BANDS[band]);
        let count = self.spectra * (beyond - first) as f64;
        if count == 0.0 {
            return [MISSING; OF_BAND.len()];
        }
        [
            math::ln(share / count + LEAST_SHARE),
            math::ln(path_power / count + LEAST_POWER_M2),
            product.re / (path_power + 1e2 * LEAST_POWER_M2),
            math::atan2(product.im, product.re),
            product.norm_sqr().sqrt() / (force_power * path_power).sqrt().max(f64::MIN_POSITIVE),
        ]
    }

    fn of_model(&self) -> [f64; OF_MODEL] {
        let among = self.products.fixed_view::<TERMS, TERMS>(0, 0).into_owned();
        let with_step = self.products.fixed_view::<TERMS, 1>(0, TERMS).into_owned();
        let solved = (among + SMatrix::from_diagonal_element(RIDGE)).cholesky().filter(|_| self.steps >= FEWEST_STEPS);
        let Some(found) = solved.map(|factor| factor.solve(&with_step)) else { return [MISSING; OF_MODEL] };
        // The mean of what is left, from the row of the constant, and its mean square.
        let left = with_step[TERMS - 1] - among.column(TERMS - 1).dot(&found);
        let mean_n = left / CONSTANT / self.steps;
        let squares = self.products[(TERMS, TERMS)] - 2.0 * found.dot(&with_step) + found.dot(&(among * found));
        let left_n = (squares / self.steps - mean_n * mean_n).max(0.0).sqrt();
        let share = math::ln(left_n * self.steps / self.sum_n + 1e-5);
        let [now, last, force, press, slide, constant] = found.into();
        [now, last, force, press, slide, constant, share, now + last]
    }
}

/// A signal without its linear trend, under Hann's window.
fn tapered(signal: [f64; WINDOW]) -> [f64; WINDOW] {
    let last = (WINDOW - 1) as f64;
    let place = |number: usize| 2.0 * number as f64 / last - 1.0;
    let mean = signal.iter().sum::<f64>() / WINDOW as f64;
    let square: f64 = (0..WINDOW).map(|number| place(number) * place(number)).sum();
    let slope = signal.iter().enumerate().map(|(number, value)| place(number) * value).sum::<f64>() / square;
    array::from_fn(|number| {
        let taper = 0.5 - 0.5 * math::cos(TAU * number as f64 / last);
        taper * (signal[number] - mean - slope * place(number))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The response to a skin that moves by `press_m` in each frame, with the force of each frame.
    fn response(frames: usize, press_m: impl Fn(usize) -> f64, force_n: impl Fn(usize) -> f64) -> Response {
        let mut response = Response::default();
        for frame in 0..frames {
            response.push(0.01 * frame as f64, force_n(frame), press_m(frame), 0.0);
        }
        response
    }

    /// Tests that a spring with a damper, k x + c dx/dt, that is shaken at a line of each band has the stiffness k, the phase
    /// atan(2π f c / k) and a coherence of one there.
    #[test]
    fn bands_tell_spring_and_damper() {
        let (stiffness, damping) = (80.0, 0.4);
        for (band, [first, beyond]) in BANDS.into_iter().enumerate().skip(1) {
            let rate = TAU * f64::from((first + beyond) as u32 / 2) / 0.64;
            let path_m = |frame: usize| 1e-3 * (0.01 * rate * frame as f64).sin();
            let speed = |frame: usize| 1e-3 * rate * (0.01 * rate * frame as f64).cos();
            let press_m = |frame: usize| if frame > 0 { path_m(frame) - path_m(frame - 1) } else { 0.0 };
            let force_n = |frame: usize| 2.0 + stiffness * path_m(frame) + damping * speed(frame);
            let [_, _, found, phase, coherence] = response(200, press_m, force_n).of_band(band);
            assert!((found / stiffness - 1.0).abs() < 0.01, "{band}: {found} N/m");
            assert!((phase.tan() / (rate * damping / stiffness) - 1.0).abs() < 0.01, "{band}: {phase}");
            assert!((coherence - 1.0).abs() < 1e-3, "{band}: {coherence}");
        }
    }

    /// Tests that the model finds the coefficients of a force that it describes exactly, up to the pull of the ridge, and that nothing
    /// is left.
    #[test]
    fn the_model_finds_its_own_coefficients() {
        let press_m = |frame: usize| 5e-3 * (1.3 * frame as f64).sin() + 2e-2 * (0.05 * frame as f64).cos();
        let mut forces_n = vec![5.0, 5.0];
        for frame in 2..4000 {
            let (now_mm, last_mm, force_n) = (1e3 * press_m(frame), 1e3 * press_m(frame - 1), forces_n[frame - 1]);
            forces_n.push(force_n + 0.08 * now_mm - 0.03 * last_mm - 0.1 * force_n + 0.5);
        }
        let found = response(forces_n.len(), press_m, |frame| forces_n[frame]).of_model();
        for (found, expected) in found.into_iter().zip([0.08, -0.03, -1.0, 0.0, 0.0, 5.0]) {
            assert!((found - expected).abs() < 0.02 * expected.abs().max(1.0), "{found}, expected {expected}");
        }
        assert!((found[TERMS + 1] - 0.05).abs() < 1e-3 && found[TERMS] < -6.0, "{found:?}");
    }

    /// Tests force, press and rise some frames after the first touch, and that they stay missing once a frame is missing.
    #[test]
    fn the_first_frames_are_kept() {
        let press_m = |_: usize| 1e-3;
        let force_n = |frame: usize| 0.1 + 0.05 * frame as f64;
        let whole = response(30, press_m, force_n);
        let [force_n, press_m, rise] = whole.early[3].unwrap();
        assert!((force_n - 0.6).abs() < 1e-12 && (press_m - 0.01).abs() < 1e-12 && (rise - 0.5 / 0.0102).abs() < 1e-9);
        assert_eq!(whole.early[5], None);
        let mut broken = Response::default();
        for time_s in [0.0, 0.01, 0.02, 0.05, 0.06, 0.07] {
            broken.push(time_s, 0.5, 1e-3, 0.0);
        }
        assert!(broken.early[0].is_some() && broken.early[1..].iter().all(Option::is_none));
    }
}
