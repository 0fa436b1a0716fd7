//! The law of an end stop of a joint.

use super::law::mean_press;
use super::layer::Layer;
use crate::physics::Theta;

/// An end stop of a joint: a one-sided spring with loss on one velocity.
#[derive(Clone, Copy, Debug)]
pub struct Stop {
    /// Index of the velocity.
    pub index: usize,
    /// +1 if the stop is at the lower limit, −1 at the upper one.
    pub sign: f64,
    /// How far the joint is beyond the limit when the step begins, rad; negative inside.
    pub overlap_rad: f64,
    /// Stiffness, Nm/rad.
    pub stiffness_nm_per_rad: f64,
    /// Loss time, s.
    pub loss_time_s: f64,
    /// θ of the joint's tree.
    pub theta: Theta,
}

impl Stop {
    /// The impulse at the velocity `speed` away from the stop, and minus its derivative.
    pub(super) fn response(&self, speed: f64, step_s: f64) -> (f64, f64) {
        let (pressed, slope) =
            mean_press(self.overlap_rad, speed, &Layer::LINEAR, self.loss_time_s, step_s, self.theta);
        let modulus = step_s * self.stiffness_nm_per_rad;
        if pressed > 0.0 { (modulus * pressed, -modulus * slope) } else { (0.0, 0.0) }
    }
}
