//! Recovery of an arm that got stuck (Jain et al. 2013): 5 cm back, then 10 cm to the side, then again to the goal.

use glam::DVec3;
use underbrush_recording::Outcome;

const BACK_OFF_M: f64 = 0.05;
const SIDESTEP_M: f64 = 0.10;
/// Time limit for each of these two moves, s. Choice: at the slowest published hand speed, 0.2 m/s, they take half a
/// second at most.
pub(super) const TIME_S: f64 = 2.0;

/// One leg of the recovery.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Way {
    /// To the goal.
    ToGoal,
    /// Back from the point where the arm got stuck.
    Back,
    /// To one side from there.
    Aside,
}

/// How a leg ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct End {
    pub(super) outcome: Outcome,
    /// Whether the controller gave it up.
    pub(super) is_given_up: bool,
}

/// Drives to a goal and backs off and tries again each time the arm gets stuck, at most `retries` times. `drive`
/// returns how a leg ended. The points behind and beside need not be reached, but an abort ends everything. A goal that
/// the controller gave up is not tried again.
pub(super) fn pursue<E>(retries: u32, mut drive: impl FnMut(Way) -> Result<End, E>) -> Result<Outcome, E> {
    let mut end = drive(Way::ToGoal)?;
    for _ in 0..retries {
        if end.outcome != Outcome::Stuck || end.is_given_up {
            break;
        }
        for way in [Way::Back, Way::Aside] {
            if drive(way)?.outcome == Outcome::Aborted {
                return Ok(Outcome::Aborted);
            }
        }
        end = drive(Way::ToGoal)?;
    }
    Ok(end.outcome)
}

/// The points behind and beside an end effector that got stuck on its way to a goal, m, world frame, at the same
/// height.
pub(super) fn waypoints(end_effector_world: DVec3, goal_world: DVec3) -> [DVec3; 2] {
    let forward = (goal_world - end_effector_world).with_z(0.0).normalize_or(DVec3::X);
    let back = end_effector_world - forward * BACK_OFF_M;
    // Choice: to the left.
    [back, back + DVec3::Z.cross(forward) * SIDESTEP_M]
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;
    use Outcome::{Aborted, Reached, Stuck, TimedOut};
    use Way::{Aside, Back, ToGoal};

    /// The legs driven and the outcome, for legs that end with these outcomes one after the other.
    fn ways(retries: u32, ends: &[Outcome]) -> (Vec<Way>, Outcome) {
        let mut taken = Vec::new();
        let outcome = pursue(retries, |way| {
            taken.push(way);
            Ok::<_, Infallible>(End { outcome: ends[taken.len() - 1], is_given_up: false })
        })
        .unwrap();
        assert_eq!(taken.len(), ends.len(), "not all of the ways were taken");
        (taken, outcome)
    }

    /// Tests that only a stuck arm tries again, as often as allowed, whether or not it reached the points behind and
    /// beside.
    #[test]
    fn a_stuck_arm_tries_again() {
        for end in [Reached, TimedOut, Aborted] {
            assert_eq!(ways(3, &[end]), (vec![ToGoal], end));
        }
        assert_eq!(ways(0, &[Stuck]), (vec![ToGoal], Stuck));
        let twice = vec![ToGoal, Back, Aside, ToGoal];
        assert_eq!(ways(1, &[Stuck, Reached, TimedOut, Stuck]), (twice.clone(), Stuck));
        assert_eq!(ways(5, &[Stuck, Stuck, Reached, Reached]), (twice, Reached));
        let thrice = vec![ToGoal, Back, Aside, ToGoal, Back, Aside, ToGoal];
        let ends = [Stuck, Reached, Reached, Stuck, Reached, Reached, TimedOut];
        assert_eq!(ways(2, &ends), (thrice, TimedOut));
    }

    /// Tests that a goal that the controller gave up is not tried again.
    #[test]
    fn a_goal_that_was_given_up_is_left() {
        let mut legs = 0;
        let outcome = pursue(3, |_| {
            legs += 1;
            Ok::<_, Infallible>(End { outcome: Stuck, is_given_up: true })
        });
        assert_eq!((outcome, legs), (Ok(Stuck), 1));
    }

    /// Tests that an abort on the way back or to the side ends the reach.
    #[test]
    fn an_abort_while_backing_off_ends_all() {
        assert_eq!(ways(2, &[Stuck, Aborted]), (vec![ToGoal, Back], Aborted));
        assert_eq!(ways(2, &[Stuck, Reached, Aborted]), (vec![ToGoal, Back, Aside], Aborted));
    }

    /// Tests the two points: 5 cm back from the goal, measured horizontally, and then 10 cm to the left.
    #[test]
    fn points_lie_behind_and_to_the_left() {
        let stuck_at = DVec3::new(0.3, 0.1, 0.2);
        let close = |[back, aside]: [DVec3; 2], expected: [DVec3; 2]| {
            back.distance(expected[0]) < 1e-12 && aside.distance(expected[1]) < 1e-12
        };
        // The goal ahead and higher: height does not matter.
        let ahead = waypoints(stuck_at, DVec3::new(0.6, 0.1, 0.5));
        assert!(close(ahead, [DVec3::new(0.25, 0.1, 0.2), DVec3::new(0.25, 0.2, 0.2)]), "{ahead:?}");
        // The goal to the right: left of this direction is ahead.
        let right = waypoints(stuck_at, DVec3::new(0.3, -0.4, 0.2));
        assert!(close(right, [DVec3::new(0.3, 0.15, 0.2), DVec3::new(0.4, 0.15, 0.2)]), "{right:?}");
        // A goal straight above gives no horizontal direction, so the direction ahead is used.
        let above = waypoints(stuck_at, DVec3::new(0.3, 0.1, 0.9));
        assert!(close(above, ahead), "{above:?}");
    }
}
