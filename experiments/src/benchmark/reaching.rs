//! Track 3: how a controller reaches through clutter, and how hard it presses on the objects there.

use std::collections::BTreeMap;

use glam::Vec3;
use serde::{Deserialize, Serialize};
use underbrush_classifier::evaluate::share;
use underbrush_recording::{Category, FRAME_PERIOD_S, Frame, Outcome, Recording};

use super::frozen::GENTLE_N;
use crate::resampled::{Estimate, Ranking};

/// The figures of the track. Forces are the true forces between one patch of skin, or the bare part of a link, and one
/// object.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reaching {
    /// Number of reaches.
    pub reaches: usize,
    /// Number of goals, including those that were not tried because of a safety stop.
    pub goals: usize,
    /// Share of the goals that were reached without a force above 5 N on a trunk until then, in any frame from the start
    /// towards the goal.
    pub reached_gently: Estimate,
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

/// The part of a reach that figures of controllers need.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Reach {
    pub(crate) goals: usize,
    pub(crate) reached: usize,
    reached_gently: usize,
    pub(crate) seconds: f64,
    pub(crate) trunk_peak_n: f64,
    leaf_impulse_n_s: f64,
    pub(crate) safety_stops: usize,
}

impl Reach {
    /// The part of a recording that had this many goals to reach. Those that were not tried because of a safety stop count
    /// as not reached.
    pub(crate) fn of(drawn_goals: u32, recording: &Recording) -> Self {
        let outcomes = recording.goal_outcomes();
        let mut reach = Reach {
            goals: drawn_goals as usize,
            reached: outcomes.reached,
            trunk_peak_n: recording.contact_forces(Some(Category::TRUNK)).peak_n,
            safety_stops: outcomes.aborted,
            ..Reach::default()
        };
        for (index, goal) in recording.goals.iter().enumerate() {
            reach.seconds += goal.end_time_s - goal.start_time_s;
            if goal.outcome == Outcome::Reached {
                let frames = recording.frames.iter().filter(|frame| usize::from(frame.goal_index) == index);
                let force_n = frames.map(|frame| on_trunk_n(frame, recording)).fold(0.0, f64::max);
                reach.reached_gently += usize::from(force_n <= GENTLE_N);
            }
        }
        for contact in &recording.contacts {
            if recording.category_of(contact.object) == Some(Category::LEAF) {
                let frames = f64::from(contact.last_frame - contact.first_frame + 1);
                reach.leaf_impulse_n_s += contact.mean_force_n * frames * FRAME_PERIOD_S;
            }
        }
        reach
    }
}

/// The largest force between one patch or bare part of a link and one trunk in a frame, N.
fn on_trunk_n(frame: &Frame, recording: &Recording) -> f64 {
    let mut forces: BTreeMap<_, Vec3> = BTreeMap::new();
    for contact in &frame.contact_points {
        let Some(object) = contact.object else { continue };
        if recording.category_of(object) == Some(Category::TRUNK) {
            *forces.entry((contact.link, contact.patch, object)).or_default() += contact.force_world;
        }
    }
    forces.into_values().map(|force| f64::from(force.length())).fold(0.0, f64::max)
}

/// The ranking by the share of goals that were reached gently.
pub(super) fn ranking(halves: [&[Reach]; 2]) -> Ranking {
    let halves = halves.map(|half| [half.to_vec()]);
    Ranking::of([&halves[0], &halves[1]], |groups| {
        let sum = |of: fn(&Reach) -> usize| groups[0].iter().map(|reach| of(reach)).sum::<usize>();
        share(sum(|reach| reach.reached_gently), sum(|reach| reach.goals))
    })
}

/// The figures of some reaches.
pub(super) fn figures(reaches: &[Reach]) -> Reaching {
    let ratio = |above: fn(&Reach) -> f64, below: fn(&Reach) -> f64| Estimate::of_ratio(reaches, above, below);
    Reaching {
        reaches: reaches.len(),
        goals: reaches.iter().map(|reach| reach.goals).sum(),
        reached_gently: ratio(|reach| reach.reached_gently as f64, |reach| reach.goals as f64),
        reached: ratio(|reach| reach.reached as f64, |reach| reach.goals as f64),
        seconds_for_each: ratio(|reach| reach.seconds, |reach| reach.reached as f64),
        trunk_peak_n: ratio(|reach| reach.trunk_peak_n, |_| 1.0),
        leaf_impulse_n_s: ratio(|reach| reach.leaf_impulse_n_s, |_| 1.0),
        largest_on_trunk_n: reaches.iter().map(|reach| reach.trunk_peak_n).fold(0.0, f64::max),
    }
}
