//! Track 3: how a controller reaches through clutter, and how hard it presses on the objects there.

use serde::{Deserialize, Serialize};
use underbrush_recording::{Category, Contact, FRAME_PERIOD_S, GoalRecord, ObjectRecord, Outcome};

use crate::resampled::Estimate;

/// The figures of the track. Forces are the true forces between one link and one object, on skin and bare parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reaching {
    /// Number of reaches.
    pub reaches: usize,
    /// Number of goals, including those that were not tried because of a safety stop.
    pub goals: usize,
    /// Share of the goals that were reached.
    pub reached: Estimate,
    /// Time spent on all goals, divided by the number of goals that were reached, s.
    pub seconds_for_each: Estimate,
    /// Mean over reaches of the largest force on a trunk, N. A reach that touches no trunk counts as 0.
    pub trunk_peak_n: Estimate,
    /// Mean over reaches of the impulse on all leaves, N s.
    pub leaf_impulse_n_s: Estimate,
    /// The largest force on a trunk in any reach, N.
    pub largest_on_trunk_n: f64,
}

/// The part of a reach that the figures need.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Reach {
    goals: usize,
    reached: usize,
    seconds: f64,
    trunk_peak_n: f64,
    leaf_impulse_n_s: f64,
}

impl Reach {
    pub(super) fn of(drawn_goals: u32, goals: &[GoalRecord], contacts: &[Contact], objects: &[ObjectRecord]) -> Self {
        let mut reach = Reach { goals: drawn_goals as usize, ..Reach::default() };
        for goal in goals {
            reach.reached += usize::from(goal.outcome == Outcome::Reached);
            reach.seconds += goal.end_time_s - goal.start_time_s;
        }
        for contact in contacts {
            let object = objects.get(usize::from(contact.object));
            match object.map(|object| object.category) {
                Some(Category::TRUNK) => reach.trunk_peak_n = reach.trunk_peak_n.max(contact.peak_force_n),
                Some(Category::LEAF) => {
                    let frames = f64::from(contact.last_frame - contact.first_frame + 1);
                    reach.leaf_impulse_n_s += contact.mean_force_n * frames * FRAME_PERIOD_S;
                }
                _ => {}
            }
        }
        reach
    }
}

/// The figures of some reaches.
pub(super) fn figures(reaches: &[Reach]) -> Reaching {
    let ratio = |above: fn(&Reach) -> f64, below: fn(&Reach) -> f64| {
        Estimate::of(reaches, move |own| {
            let sum = |of: fn(&Reach) -> f64| own.iter().map(|reach| of(reach)).sum::<f64>();
            let ratio = sum(above) / sum(below);
            ratio.is_finite().then_some(ratio)
        })
    };
    Reaching {
        reaches: reaches.len(),
        goals: reaches.iter().map(|reach| reach.goals).sum(),
        reached: ratio(|reach| reach.reached as f64, |reach| reach.goals as f64),
        seconds_for_each: ratio(|reach| reach.seconds, |reach| reach.reached as f64),
        trunk_peak_n: ratio(|reach| reach.trunk_peak_n, |_| 1.0),
        leaf_impulse_n_s: ratio(|reach| reach.leaf_impulse_n_s, |_| 1.0),
        largest_on_trunk_n: reaches.iter().map(|reach| reach.trunk_peak_n).fold(0.0, f64::max),
    }
}
