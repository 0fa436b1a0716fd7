//! From a posture in contact to a way to the goal: back the way the arm came, then a plan, with less and less caution.

use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::planner::{MARGIN_M, Postures};
use super::{BUDGET, Caution, Mapped, NoWay, Planner, Pursuit, largest_change_rad};

/// How far a way stays from obstacles at the first attempt, m: short ways lead along obstacles, and compliant arms cut corners.
const WIDE_MARGIN_M: f64 = 0.01;
/// Caution and margin, m, from one attempt to the next.
const ATTEMPTS: [(Caution, f64); 6] = [
    (Caution::NONE, WIDE_MARGIN_M),
    (Caution::NONE, MARGIN_M),
    (Caution::NONE, 0.0),
    (Caution { is_thin: true, is_low: false }, 0.0),
    (Caution { is_thin: false, is_low: true }, 0.0),
    (Caution { is_thin: true, is_low: true }, 0.0),
];
/// Obstacles that are forgotten at most for one plan. Choice: as many as a workspace holds.
const FORGOTTEN: usize = 8;
/// How far the arm goes back along the way it came, rad. Choice: half a reach.
const BACK_RAD: f64 = 0.8;
/// A wedged arm leaves straight, by at most this, rad, in one of so many directions.
const OUT_RAD: f64 = 0.5;
const DIRECTIONS: usize = 100;

impl Mapped {
    /// A way to the goal of a pursuit from the posture `from_rad`, at first back by at least `back_rad` along the way the
    /// arm came. Also returns how many postures were evaluated. Without a way, obstacles are seen as thinner and lower, and
    /// then forgotten one by one.
    pub(super) fn route(
        &mut self,
        own: &mut Pursuit,
        from_rad: &[f64],
        back_rad: f64,
        random: &mut ChaCha8Rng,
    ) -> (Result<Postures, NoWay>, usize) {
        let joints = &self.arm.joints;
        let within = |posture: &[f64]| -> Vec<f64> {
            joints.iter().zip(posture).map(|(joint, angle)| joint.within_limits(*angle)).collect()
        };
        let from_rad = within(from_rad);
        let back: Postures = self.trail.iter().map(|posture| within(posture)).collect();
        let (mut evaluations, mut forgotten) = (0, 0);
        loop {
            let mut reason = NoWay::NotFound;
            for (number, (caution, margin_m)) in ATTEMPTS.into_iter().enumerate() {
                let left = BUDGET.saturating_sub(evaluations);
                if left == 0 || (number > 2 && self.map.obstacles.iter().all(|obstacle| obstacle.is_known)) {
                    break;
                }
                let obstacles = self.map.capsules(caution, self.top_m);
                let budget = left.min(if number == 0 { BUDGET / 2 } else { BUDGET / 5 });
                let planner = Planner::new(&self.arm, &self.shapes, &obstacles, budget);
                let mut planner = Planner { margin_m, forbidden: &own.forbidden, ..planner };
                let found = out_and_on(&mut planner, &from_rad, &back, own.goal, back_rad, random);
                evaluations += planner.evaluations;
                match found {
                    Ok(path) => return (Ok(path), evaluations),
                    Err(NoWay::OutOfReach) => return (Err(NoWay::OutOfReach), evaluations),
                    Err(other) if number == 0 => reason = other,
                    Err(_) => {}
                }
            }
            if !own.forbidden.is_empty() {
                own.forbidden.remove(0);
            } else if forgotten < FORGOTTEN && self.map.forget_one() {
                forgotten += 1;
            } else {
                return (Err(reason), evaluations);
            }
            if evaluations >= BUDGET {
                return (Err(reason), evaluations);
            }
        }
    }
}

/// Back along the postures `back` to the first free one, or straight out, and from there to the goal.
fn out_and_on(
    planner: &mut Planner,
    from_rad: &[f64],
    back: &[Vec<f64>],
    goal: DVec3,
    back_rad: f64,
    random: &mut ChaCha8Rng,
) -> Result<Postures, NoWay> {
    if back_rad == 0.0 && planner.is_free(from_rad) {
        return planner.plan(from_rad, goal, random);
    }
    let (mut path, mut moved_rad) = (vec![from_rad.to_vec()], 0.0);
    for posture in back {
        moved_rad += path.last().map_or(0.0, |last| largest_change_rad(last, posture));
        if moved_rad > BACK_RAD {
            break;
        }
        path.push(posture.clone());
        if moved_rad >= back_rad && planner.is_free(posture) {
            path.extend(planner.plan(posture, goal, random)?.into_iter().skip(1));
            return Ok(path);
        }
    }
    let out = straight_out(planner, from_rad, random).ok_or(NoWay::Wedged)?;
    let mut path = vec![from_rad.to_vec()];
    path.extend(planner.plan(&out, goal, random)?);
    Ok(path)
}

/// The nearest free posture that is found in random directions.
fn straight_out(planner: &mut Planner, from_rad: &[f64], random: &mut ChaCha8Rng) -> Option<Vec<f64>> {
    (1..=DIRECTIONS).find_map(|number| {
        let size_rad = OUT_RAD * number as f64 / DIRECTIONS as f64;
        let joints = planner.arm.joints.iter().zip(from_rad);
        let moved =
            joints.map(|(joint, angle)| joint.within_limits(angle + size_rad * (2.0 * random.random::<f64>() - 1.0)));
        let posture: Vec<f64> = moved.collect();
        planner.is_free(&posture).then_some(posture)
    })
}
