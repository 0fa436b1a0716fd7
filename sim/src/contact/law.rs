//! The contact law of one patch over one step, and that of an end stop of a joint.
//!
//! A patch is an elastic foundation with loss: in a column of area a with the overlap h the pressure is p(h) + τ dp/dt, and
//! never negative. At small overlaps p is k h (Kelvin-Voigt); [`super::surface`] describes larger ones. Within a step the
//! surfaces part with a constant speed v, so the overlap changes linearly from h to h − Δt v. The impulse of the column is
//! Δt a times the mean of the pressure over the step. This is the discrete gradient of the column's potential, so columns
//! make no energy. Where one of the two trees takes its forces at θ of the step (see [`crate::dynamics`]), the mean is that
//! over the part of the step after (2 θ − 1) Δt: over the whole step for θ = ½, and the value at its end for θ = 1. All are
//! slopes of convex functions of v.
//!
//! Friction acts at the patch's centre of pressure, on the slip (v₁, v₂) there and on the angular velocity ω about the
//! normal. It is Coulomb friction for a patch whose limit surface is an ellipsoid (Howe & Cutkosky, "Practical
//! force-motion models for sliding manipulation", 1996): the vector (f₁, f₂, moment/r) is opposite to (v₁, v₂, r ω) and
//! has the magnitude μ N, where r is the mean distance of the pressure from its centre. A patch that sticks gives way
//! elastically by [`STICTION_M`] before it slips, as surfaces with asperities do. The displacement is kept from step to
//! step, so a patch that sticks does not creep.

use glam::DVec2;
use nalgebra::{Matrix3, Vector3};

use super::patch::Node;
use super::surface::{Interface, Layer};
use crate::physics::Theta;

/// Tangential displacement at which a patch begins to slip, m. Choice: asperities slide after 1 to 100 µm; it is well below
/// what a taxel resolves, and the arm passes it within one step of 5 ms at 2 mm/s.
pub const STICTION_M: f64 = 1e-5;

/// The speeds at which two bodies part at a patch: along the normal (m/s), and the angular velocities about the two tangents
/// (rad/s), of the first body relative to the second.
pub type NormalSpeeds = Vector3<f64>;

/// Slip of the first body against the second along the two tangents, m/s, and r times the angular velocity about the normal.
pub type SlipSpeeds = Vector3<f64>;

/// What the law returns for a velocity: the impulse on the first body (N s, and N m s), and minus its derivative with
/// respect to the velocity, which is symmetric and positive semidefinite.
#[derive(Clone, Copy, Debug, Default)]
pub struct Response {
    /// Impulse.
    pub impulse: Vector3<f64>,
    /// Minus its derivative.
    pub stiffness: Matrix3<f64>,
}

/// The constants of a patch in one step.
#[derive(Clone, Copy, Debug)]
pub struct Law {
    /// The two surfaces.
    pub interface: Interface,
    /// Length of the step, s.
    pub step_s: f64,
    /// θ of the tree that damps more.
    pub theta: Theta,
}

/// Places of two Gauss-Legendre nodes on a way of length 1.
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

/// The mean of the pressure (as a length, see [`Layer`]) over the part of a step after (2 θ − 1) Δt, and its derivative with
/// respect to v, for the overlap h − v t. Loss acts on the way on which the two are closed, over the whole step. Two Gauss nodes
/// give the mean: exactly where p is linear, and within 2·10⁻⁴ where a step changes the overlap by a third of a thickness.
fn mean_press(overlap: f64, speed: f64, layer: &Layer, loss_time_s: f64, step_s: f64, theta: Theta) -> (f64, f64) {
    let from_s = (2.0 * theta.value() - 1.0) * step_s;
    // Surfaces that part press until h falls to τ v.
    let lag_s = if speed > 0.0 { loss_time_s } else { 0.0 };
    let (first_s, last_s) = (from_s + lag_s, step_s + lag_s);
    let (first, last) = (overlap - first_s * speed, overlap - last_s * speed);
    let (high, low, high_s, low_s) =
        if speed > 0.0 { (first, last, first_s, last_s) } else { (last, first, last_s, first_s) };
    if high <= 0.0 {
        return (0.0, 0.0);
    }
    // The closed part of the way, and of the time.
    let share = if low >= 0.0 { 1.0 } else { high / (high - low) };
    let (mut mean, mut slope) = (0.0, 0.0);
    for place in GAUSS {
        let (pressed, rate) = layer.pressed(high + place * (low.max(0.0) - high));
        mean += 0.5 * share * pressed;
        slope -= 0.5 * share * rate * (high_s + place * share * (low_s - high_s));
    }
    if speed <= 0.0 {
        // Loss on the way from max(0, h).
        let (pressed, rate) = layer.pressed(last);
        mean += loss_time_s / step_s * (pressed - layer.pressed(overlap).0);
        slope -= loss_time_s * rate;
    }
    (mean, slope)
}

impl Law {
    /// The overlap at the start of the step beyond which a column presses at the parting speed `speed`, m.
    pub fn closing_m(&self, speed: f64) -> f64 {
        let from_s = (2.0 * self.theta.value() - 1.0) * self.step_s;
        if speed < 0.0 { self.step_s * speed } else { (from_s + self.interface.loss_time_s) * speed }
    }

    fn mean_press(&self, node: &Node, speeds: &NormalSpeeds) -> (f64, f64) {
        let Interface { layer, loss_time_s, .. } = &self.interface;
        mean_press(node.overlap_m, node.parting(speeds), layer, *loss_time_s, self.step_s, self.theta)
    }

    /// Normal impulse and moments about the tangents.
    pub fn normal(&self, nodes: &[Node], speeds: &NormalSpeeds) -> Response {
        let scale = self.step_s * self.interface.stiffness_n_per_m3;
        let mut impulse = [0.0; 3];
        let mut stiffness = [0.0; 6];
        for node in nodes {
            let DVec2 { x, y } = node.place;
            let (pressed, pressed_slope) = self.mean_press(node, speeds);
            if pressed > 0.0 {
                let modulus = scale * node.area_m2;
                let force = modulus * pressed;
                impulse[0] += force;
                impulse[1] += force * y;
                impulse[2] -= force * x;
                let slope = -modulus * pressed_slope;
                stiffness[0] += slope;
                stiffness[1] += slope * y;
                stiffness[2] -= slope * x;
                stiffness[3] += slope * y * y;
                stiffness[4] -= slope * x * y;
                stiffness[5] += slope * x * x;
            }
        }
        let [a, b, c, d, e, f] = stiffness;
        Response { impulse: Vector3::from(impulse), stiffness: Matrix3::new(a, b, c, b, d, e, c, e, f) }
    }

    /// Friction at most `limit` (N s) large. `deflection` is the elastic displacement at the start of the step, m, and
    /// `before` the slip there. Friction is that of the slip at the end of the step: asperities are far stiffer than what
    /// a step resolves, and at the mean slip they would let it ring.
    pub fn friction(
        &self,
        deflection: &Vector3<f64>,
        limit: f64,
        before: &SlipSpeeds,
        speeds: &SlipSpeeds,
    ) -> Response {
        let theta = self.theta.value();
        let at_end = (speeds - before * (1.0 - theta)) / theta;
        let displaced = deflection + at_end * self.step_s;
        let distance = displaced.norm();
        let softness = limit / distance.max(STICTION_M);
        let rate = softness * self.step_s / theta;
        let mut stiffness = Matrix3::from_diagonal_element(rate);
        if distance > STICTION_M {
            stiffness -= displaced * displaced.transpose() * (rate / (distance * distance));
        }
        Response { impulse: displaced * -softness, stiffness }
    }

    /// The elastic displacement at the end of the step.
    pub fn deflection_after(&self, deflection: &Vector3<f64>, speeds: &SlipSpeeds) -> Vector3<f64> {
        let displaced = deflection + speeds * self.step_s;
        displaced * (STICTION_M / displaced.norm().max(STICTION_M))
    }

    /// Centre of pressure in the tangent plane, m, and the mean distance r of the pressure from it, m, at the parting
    /// speeds `speeds`. If nothing presses at these speeds, the columns' areas count instead of the pressures.
    pub fn center_and_radius(&self, nodes: &[Node], speeds: &NormalSpeeds) -> (DVec2, f64) {
        let force = |node: &Node| node.area_m2 * self.mean_press(node, speeds).0;
        let pressed = weigh(nodes, force);
        let is_pressed = pressed.0 > 0.0;
        let weight = |node: &Node| if is_pressed { force(node) } else { node.area_m2 };
        let (sum, moment) = if is_pressed { pressed } else { weigh(nodes, weight) };
        if sum <= 0.0 {
            return (DVec2::ZERO, 0.0);
        }
        let center = moment / sum;
        let radius = nodes.iter().map(|node| node.place.distance(center) * weight(node)).sum::<f64>() / sum;
        (center, radius)
    }
}

/// The sum of the weights, and of the places times their weights, m.
fn weigh(nodes: &[Node], weight: impl Fn(&Node) -> f64) -> (f64, DVec2) {
    nodes.iter().fold((0.0, DVec2::ZERO), |(sum, moment), node| {
        let weight = weight(node);
        (sum + weight, moment + node.place * weight)
    })
}

/// The place where a normal impulse with its moments about the tangents acts, in the tangent plane, m.
pub fn center_of_pressure(impulse: &Vector3<f64>) -> DVec2 {
    DVec2::new(-impulse[2], impulse[1]) / impulse[0]
}

/// An end stop of a joint: a one-sided spring with loss on one velocity.
#[derive(Clone, Copy, Debug)]
pub struct Stop {
    /// Index of the velocity.
    pub index: usize,
    /// +1 if the stop is at the lower limit, −1 at the upper one.
    pub sign: f64,
    /// How far the joint is beyond the limit when the step begins, rad; negative inside.
    pub overlap_rad: f64,
    /// Stiffness, N m/rad.
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

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const STEP_S: f64 = 0.005;

    proptest! {
        /// Tests the mean pressure of a column along its path against a sum over 20,000 moments of the step: it is closed where
        /// h > 0, presses with p(h) + τ dp/dt while it closes, and with p(h + τ dh/dt) while it opens.
        #[test]
        fn a_column_presses_with_the_mean_along_its_path(
            overlap_m in -2e-3..2e-3f64,
            speed in -0.5..0.5f64,
            loss_time_s in 0.0..0.01f64,
            hardens in any::<bool>(),
        ) {
            let layer = if hardens { Layer::new(3e-3, 0.1) } else { Layer::LINEAR };
            let (found, _) = mean_press(overlap_m, speed, &layer, loss_time_s, STEP_S, Theta::MIDPOINT);
            let moments = 20_000;
            let sum: f64 = (0..moments)
                .map(|moment| overlap_m - speed * STEP_S * (f64::from(moment) + 0.5) / f64::from(moments))
                .filter(|overlap| *overlap > 0.0)
                .map(|overlap| match speed > 0.0 {
                    true => layer.pressed(overlap - loss_time_s * speed).0,
                    false => {
                        let (pressed, rate) = layer.pressed(overlap);
                        pressed - loss_time_s * rate * speed
                    }
                })
                .sum();
            // The sum may miss the moment at which the column closes by half of its steps, at the largest rate.
            let way = (STEP_S + loss_time_s) * speed.abs();
            let most = layer.pressed(overlap_m.max(0.0) + way);
            let resolution = (overlap_m.abs() + way) * most.1 / f64::from(moments);
            // Two Gauss nodes on a way s are off by s⁴ / 4320 times the fourth derivative, which is below 70 / L³ for this layer.
            let quadrature = 70.0 / 4320.0 * (STEP_S * speed).powi(4) / (3e-3f64 / 0.9).powi(3);
            prop_assert!((found - sum / f64::from(moments)).abs() < resolution + quadrature, "{found}");
        }

        /// Tests that a column makes no energy: in a step the bodies lose at least what its potential gains, and exactly that at
        /// θ = ½ without loss. With the layer that hardens this holds within the error of [`mean_press`], in steps that change the
        /// overlap by up to a third of its thickness. Tests also that pressures fall with the parting speed, so that the step is
        /// the minimum of a convex function.
        #[test]
        fn a_column_makes_no_energy(
            overlap_m in -1e-3..8e-3f64,
            ways_m in prop::array::uniform2(-1e-3..1e-3f64),
            step_s in 1e-4..1e-2f64,
            loss_time_s in 0.0..0.01f64,
            phase in 0.5..2.0f64,
            hardens in any::<bool>(),
        ) {
            let layer = if hardens { Layer::new(3e-3, 0.1) } else { Layer::LINEAR };
            // The sum is exact for a linear layer, and within 1e-6 for the other.
            let potential = |depth_m: f64| {
                let part_m = depth_m.max(0.0) / 1000.0;
                (0..1000).map(|part| part_m * layer.pressed(part_m * (f64::from(part) + 0.5)).0).sum::<f64>()
            };
            let [(mean, slope), (other, _)] = ways_m.map(|way_m| {
                mean_press(overlap_m, way_m / step_s, &layer, loss_time_s, step_s, Theta::of_phase(phase, Theta::EULER))
            });
            let gain = potential(overlap_m - ways_m[0]) - potential(overlap_m);
            let error = |work: f64| 1e-16 + work.abs() * if hardens { 2e-4 } else { 0.0 };
            let work = -mean * ways_m[0];
            prop_assert!(work >= gain - error(work), "{work} {gain}");
            let (lossless, _) = mean_press(overlap_m, ways_m[0] / step_s, &layer, 0.0, step_s, Theta::MIDPOINT);
            let work = -lossless * ways_m[0];
            prop_assert!((work - gain).abs() <= error(work), "{work} {gain}");
            prop_assert!(slope <= 0.0 && (mean - other) * (ways_m[0] - ways_m[1]) <= 1e-18, "{slope} {mean} {other}");
        }
    }
}
