//! How the reaches of a data set ended, as readable text: goals reached, what aborted a reach, and what was truly
//! touched.

use std::collections::BTreeMap;

use serde::Serialize;
use underbrush_recording::disk::Episode;
use underbrush_recording::{GoalOutcomes, NamedStop};

/// Summary of how some reaches ended.
#[derive(Clone, Serialize)]
pub struct Ends {
    /// The number of goals with each outcome.
    pub goals: GoalOutcomes,
    /// The aborted reaches.
    pub aborted: Vec<AbortedReach>,
    /// For each patch, by name, the number of reaches in which an object truly pressed on it.
    pub touched_reaches: BTreeMap<String, usize>,
    #[serde(skip)]
    reaches: usize,
}

/// A reach that was aborted, and why.
#[derive(Clone, Serialize)]
pub struct AbortedReach {
    /// The scene.
    pub scene: String,
    /// Index of the reach in its scene.
    pub reach_index: u64,
    /// The contact whose force exceeded the stop force.
    pub stop: NamedStop,
}

/// Maximum number of aborted reaches that are listed one by one; for the rest only their number is given.
const LISTED: usize = 5;

impl Ends {
    /// Sums up some reaches.
    pub fn of(episodes: &[Episode]) -> Self {
        let mut touched_reaches = BTreeMap::new();
        for (patch, frames) in episodes.iter().flat_map(|episode| &episode.touched_frames) {
            *touched_reaches.entry(patch.clone()).or_default() += usize::from(*frames > 0);
        }
        let aborted = episodes.iter().filter_map(|episode| {
            Some(AbortedReach {
                scene: episode.scene.clone(),
                reach_index: episode.reach_index,
                stop: episode.safety_stop.clone()?,
            })
        });
        Ends {
            goals: episodes.iter().map(|episode| episode.goal_outcomes).sum(),
            aborted: aborted.collect(),
            touched_reaches,
            reaches: episodes.len(),
        }
    }

    /// What was truly touched, by patch: `true contact: forearm in 6 of 9 reaches, flipper in 9 of 9`.
    pub fn touched_text(&self) -> String {
        let patches = self.touched_reaches.iter();
        let counts: Vec<String> =
            patches.map(|(patch, reaches)| format!("{patch} in {reaches} of {} reaches", self.reaches)).collect();
        format!("true contact: {}", counts.join(", "))
    }

    /// The summary as text of several lines.
    pub fn text(&self) -> String {
        let mut text = format!("{}\n{}", self.goals, self.touched_text());
        for AbortedReach { scene, reach_index, stop } in self.aborted.iter().take(LISTED) {
            text.push_str(&format!("\naborted: reach {reach_index} of {scene}: {stop}"));
        }
        if self.aborted.len() > LISTED {
            text.push_str(&format!("\naborted: {} more reaches", self.aborted.len() - LISTED));
        }
        text
    }
}
