//! A mass on a spring and a damper: its step response, exact and under the θ-method.

use std::f64::consts::{PI, TAU};

use crate::numeric::halved;

/// A damped oscillator with damping ratio below 1.
///
/// ```
/// use underbrush_oracles::oscillator::Oscillator;
///
/// // 1 kg on 100 N/m with 2 N s/m: ω₀ = 10 rad/s, ζ = 0.1.
/// let oscillator = Oscillator::new(1.0, 100.0, 2.0);
/// assert!((oscillator.frequency_rad_per_s - 10.0).abs() < 1e-12);
/// assert!((oscillator.damping_ratio - 0.1).abs() < 1e-12);
/// assert!((oscillator.overshoot() - 0.729).abs() < 1e-3);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillator {
    /// Undamped natural frequency ω₀, rad/s.
    pub frequency_rad_per_s: f64,
    /// Damping ratio ζ, 0 to below 1.
    pub damping_ratio: f64,
}

impl Oscillator {
    /// The oscillator of an inertia (kg m² or kg), a stiffness (N m/rad or N/m) and a damping (N m s/rad or N s/m).
    pub fn new(inertia: f64, stiffness: f64, damping: f64) -> Self {
        Oscillator {
            frequency_rad_per_s: (stiffness / inertia).sqrt(),
            damping_ratio: damping / (2.0 * (stiffness * inertia).sqrt()),
        }
    }

    /// Frequency of the damped vibration, rad/s: ω₀ √(1 − ζ²).
    pub fn damped_frequency_rad_per_s(&self) -> f64 {
        self.frequency_rad_per_s * (1.0 - self.damping_ratio.powi(2)).sqrt()
    }

    /// Period of the damped vibration, s.
    pub fn period_s(&self) -> f64 {
        TAU / self.damped_frequency_rad_per_s()
    }

    /// Natural logarithm of the ratio of two successive peaks: 2π ζ / √(1 − ζ²).
    pub fn log_decrement(&self) -> f64 {
        TAU * self.damping_ratio / (1.0 - self.damping_ratio.powi(2)).sqrt()
    }

    /// Overshoot of the step response, relative to the step: exp(−π ζ / √(1 − ζ²)).
    pub fn overshoot(&self) -> f64 {
        (-PI * self.damping_ratio / (1.0 - self.damping_ratio.powi(2)).sqrt()).exp()
    }

    /// Response at `time_s` to a unit step of the rest position, from rest.
    pub fn step_response(&self, time_s: f64) -> f64 {
        let decay = self.damping_ratio * self.frequency_rad_per_s;
        let damped = self.damped_frequency_rad_per_s();
        1.0 - (-decay * time_s).exp() * ((damped * time_s).cos() + decay / damped * (damped * time_s).sin())
    }

    /// The rebound of a mass that meets a spring with loss at `speed` and leaves it when k (x + τ dx/dt), with the loss
    /// time τ, falls to zero. Returns the largest displacement and the speed on leaving, for x = v/ω_d e^(−ζω₀t)
    /// sin ω_d t.
    pub fn rebound(&self, speed: f64, loss_time_s: f64) -> (f64, f64) {
        let decay = self.damping_ratio * self.frequency_rad_per_s;
        let damped = self.damped_frequency_rad_per_s();
        let place = |time: f64| speed / damped * (-decay * time).exp() * (damped * time).sin();
        let velocity = |time: f64| {
            speed * (-decay * time).exp() * ((damped * time).cos() - decay / damped * (damped * time).sin())
        };
        let turning = (damped / decay).atan() / damped;
        let presses = |time: f64| place(time) + loss_time_s * velocity(time) > 0.0;
        let [end, _] = halved([turning, PI / damped], 60, presses);
        (place(turning), -velocity(end))
    }

    /// How many times as fast as after [`Oscillator::rebound`], with the loss time 2 ζ / ω₀ of its own damper, the mass leaves in steps of the
    /// implicit midpoint rule. In the eigenvectors of the motion, displacement and velocity, the rule has only other
    /// eigenvalues, so the mass leaves at the same phase, π − 2 asin ζ. Until then the speed decays with the rule's damping ratio,
    /// which is lower by the factor 1 − (ω₀ Δt)² / 6 to second order.
    pub fn rebound_gain(&self, step_s: f64) -> f64 {
        let decay_per_rad = |own: &Oscillator| own.log_decrement() / TAU;
        let less_decay = decay_per_rad(self) - decay_per_rad(&self.under_theta_method(0.5, step_s));
        (less_decay * (PI - 2.0 * self.damping_ratio.asin())).exp()
    }

    /// The oscillator that the θ-method with a step of `step_s` simulates: the eigenvalue s = −ζω₀ ± iω_d becomes the
    /// factor (1 + (1 − θ) s Δt) / (1 − θ s Δt) per step, which is also the factor of an oscillator. θ = 1 is implicit
    /// Euler.
    pub fn under_theta_method(&self, theta: f64, step_s: f64) -> Oscillator {
        let decay = self.damping_ratio * self.frequency_rad_per_s;
        // 1 − x s Δt, with the positive imaginary part of −s.
        let term = |x: f64| (1.0 + x * decay * step_s, x * self.damped_frequency_rad_per_s() * step_s);
        let (below, above) = (term(theta), term(theta - 1.0));
        let seen_decay = (below.0.hypot(below.1) / above.0.hypot(above.1)).ln() / step_s;
        let seen_frequency = (below.1.atan2(below.0) - above.1.atan2(above.0)) / step_s;
        let natural = seen_decay.hypot(seen_frequency);
        Oscillator { frequency_rad_per_s: natural, damping_ratio: seen_decay / natural }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    const EXAMPLE: Oscillator = Oscillator { frequency_rad_per_s: 11.5, damping_ratio: 0.12 };

    /// Tests the step response against a fine Runge-Kutta integration of ẍ + 2ζω ẋ + ω² (x − 1) = 0.
    #[test]
    fn step_response_solves_its_equation() {
        let (w, z) = (EXAMPLE.frequency_rad_per_s, EXAMPLE.damping_ratio);
        let slope = |[x, v]: [f64; 2]| [v, w * w * (1.0 - x) - 2.0 * z * w * v];
        let (mut state, step) = ([0.0, 0.0], 1e-4);
        for index in 1..=10_000 {
            let add = |s: [f64; 2], k: [f64; 2], by: f64| [s[0] + by * k[0], s[1] + by * k[1]];
            let a = slope(state);
            let b = slope(add(state, a, step / 2.0));
            let c = slope(add(state, b, step / 2.0));
            let d = slope(add(state, c, step));
            state = [0, 1].map(|i| state[i] + step / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
            let expected = EXAMPLE.step_response(f64::from(index) * step);
            assert!((state[0] - expected).abs() < 1e-10);
        }
    }

    /// Tests the rebound: with hardly any loss, the speed returns and the depth is v/ω₀; with loss, both agree with a
    /// fine numerical integration.
    #[test]
    fn a_rebound_keeps_what_the_loss_leaves() {
        let elastic = Oscillator::new(0.5, 1e4, 1e-6);
        let (depth, speed) = elastic.rebound(0.2, 1e-10);
        assert_relative_eq!(speed, 0.2, max_relative = 1e-6);
        assert_relative_eq!(depth, 0.2 / elastic.frequency_rad_per_s, max_relative = 1e-6);
        let (stiffness, mass, loss) = (1.2e4, 0.5, 0.002);
        let (depth, speed) = Oscillator::new(mass, stiffness, stiffness * loss).rebound(0.2, loss);
        let (mut x, mut v, step, mut deepest) = (0.0, 0.2, 1e-7, 0.0_f64);
        while x + loss * v > 0.0 {
            v -= step * stiffness / mass * (x + loss * v);
            x += step * v;
            deepest = deepest.max(x);
        }
        assert_relative_eq!(depth, deepest, max_relative = 1e-4);
        assert_relative_eq!(speed, -v, max_relative = 1e-4);
    }

    /// Tests the gain of a rebound against steps of the midpoint rule, twenty of which end where the mass leaves.
    #[test]
    fn a_rebound_in_steps_keeps_more_speed() {
        let (w, z) = (EXAMPLE.frequency_rad_per_s, EXAMPLE.damping_ratio);
        let (speed, loss) = (0.2, 2.0 * z / w);
        let phase = |step: f64| 20.0 * step * EXAMPLE.under_theta_method(0.5, step).damped_frequency_rad_per_s();
        let [step, _] = halved([1e-3, 0.1], 60, |step| phase(step) < PI - 2.0 * z.asin());
        let (mut x, mut v) = (0.0, speed);
        for _ in 0..20 {
            let part = 0.5 * step;
            let mean = (v - part * w * w * x) / (1.0 + 2.0 * z * w * part + w * w * part * part);
            (x, v) = (x + step * mean, 2.0 * mean - v);
        }
        assert!((x + loss * v).abs() < 1e-12, "{x} {v}");
        let gain = EXAMPLE.rebound_gain(step);
        assert_relative_eq!(-v / EXAMPLE.rebound(speed, loss).1, gain, max_relative = 1e-9);
        let leading = (PI - 2.0 * z.asin()) * z * (w * step).powi(2) / 6.0;
        assert_relative_eq!(gain - 1.0, leading, max_relative = 0.05);
    }

    /// Tests overshoot and decrement as extremes of the step response half a period apart.
    #[test]
    fn overshoot_is_the_first_extreme() {
        let half = EXAMPLE.period_s() / 2.0;
        assert_relative_eq!(EXAMPLE.step_response(half) - 1.0, EXAMPLE.overshoot(), epsilon = 1e-12);
        let third = EXAMPLE.step_response(3.0 * half) - 1.0;
        assert_relative_eq!((EXAMPLE.overshoot() / third).ln(), EXAMPLE.log_decrement(), epsilon = 1e-9);
    }

    /// Tests the oscillator that the θ-method simulates against its steps: period and decay of the free vibration.
    #[test]
    fn the_theta_method_is_an_oscillator_of_its_own() {
        for theta in [0.5, 0.7, 1.0] {
            check_theta_method(theta);
        }
    }

    fn check_theta_method(theta: f64) {
        let (w, z, step) = (EXAMPLE.frequency_rad_per_s, EXAMPLE.damping_ratio, 0.01);
        let (mut x, mut v) = (0.0, 1.0);
        let mut crossings = Vec::new();
        let mut at = Vec::new();
        for index in 0..2000 {
            // The velocity at θ of the step: one of implicit Euler that is θ as long.
            let part = theta * step;
            let mean = (v - part * w * w * x) / (1.0 + 2.0 * z * w * part + w * w * part * part);
            let (moved, next) = (x + step * mean, v + (mean - v) / theta);
            if x < 0.0 && moved >= 0.0 {
                crossings.push(f64::from(index) * step - x / (moved - x) * step);
            }
            (x, v) = (moved, next);
            at.push(x * x + (v / w).powi(2));
        }
        let seen = EXAMPLE.under_theta_method(theta, step);
        let periods = crossings.len() as f64 - 1.0;
        let period = (crossings[crossings.len() - 1] - crossings[0]) / periods;
        assert_relative_eq!(period, seen.period_s(), max_relative = 1e-3);
        // Amplitudes 1000 steps apart; the phase changes their ratio by less than a period's decrement.
        let decay = (at[500] / at[1500]).ln() / 2.0 / (1000.0 * step);
        assert_relative_eq!(decay, seen.damping_ratio * seen.frequency_rad_per_s, max_relative = 0.05);
        // To first order the step adds (θ − ½) ω Δt to the damping ratio.
        let small = EXAMPLE.under_theta_method(theta, 1e-5);
        let added = (theta - 0.5) * w * 1e-5;
        assert_relative_eq!(small.damping_ratio - z, added, max_relative = 0.05, epsilon = 1e-8);
    }
}
