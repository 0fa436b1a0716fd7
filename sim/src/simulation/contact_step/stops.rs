//! End stops of joints, as rows of the contact solver.

use crate::contact::stop::Stop;
use crate::dynamics::{Coordinate, EndStop, Tree};

/// A stop is solved for when its joint is this close to a limit, rad: at 5 rad/s a joint covers it in a step of 10 ms.
const NEAR_STOP_RAD: f64 = 0.05;

/// The coordinates of a tree that may reach a limit in this step, with their indices.
pub(super) fn near(tree: &Tree) -> impl Iterator<Item = (usize, &Coordinate)> {
    tree.coordinates.iter().enumerate().filter(|(_, own)| {
        own.stop.is_some_and(|EndStop { limits_rad: [lower, upper], .. }| {
            own.position < lower + NEAR_STOP_RAD || own.position > upper - NEAR_STOP_RAD
        })
    })
}

/// The stops at both limits of a coordinate, whose velocity has this index in the solver.
pub(super) fn rows(index: usize, coordinate: &Coordinate, tree: &Tree) -> impl Iterator<Item = Stop> + use<> {
    let angle = coordinate.position - tree.ahead_s() * coordinate.velocity;
    let theta = tree.theta();
    coordinate.stop.into_iter().flat_map(move |stop| {
        let EndStop { limits_rad: [lower, upper], stiffness_nm_per_rad, loss_time_s } = stop;
        let sides = [(1.0, lower - angle), (-1.0, angle - upper)];
        sides.map(|(sign, overlap_rad)| Stop { index, sign, overlap_rad, stiffness_nm_per_rad, loss_time_s, theta })
    })
}
