//! How the reaches of a data set ended (goals reached, what aborted a reach, and what was truly touched), and their audit: the
//! worst residuals with their reaches, and warnings if they exceed their bounds.

use std::collections::BTreeMap;

use serde::Serialize;
use underbrush_recording::disk::Episode;
use underbrush_recording::limits::two_digits;
use underbrush_recording::{Audit, GoalOutcomes, NamedStop, Recording, SkinLayout};
use underbrush_sim::audit::{Bound, bounds, exceeds};

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
        let listed = self.aborted.iter().take(LISTED);
        text.extend(listed.map(|own| format!("\naborted: reach {} of {}: {}", own.reach_index, own.scene, own.stop)));
        if self.aborted.len() > LISTED {
            text.push_str(&format!("\naborted: {} more reaches", self.aborted.len() - LISTED));
        }
        text
    }
}

/// The worst value of one residual, with its reach.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Worst {
    /// The value.
    pub value: f64,
    /// Its bound, if it has one.
    pub bound: Option<f64>,
    /// Scene of the reach.
    pub scene: String,
    /// Index of the reach in its scene.
    pub reach_index: u64,
}

/// The worst value of every residual over some reaches, by name.
pub fn worst(episodes: &[Episode], layout: &SkinLayout) -> BTreeMap<&'static str, Worst> {
    let bounds: Vec<Bound> = bounds(layout).collect();
    let of_field = |name: &str, get: fn(&Audit) -> f64| {
        // The sign of NaN says nothing.
        let size = |episode: &Episode| get(&episode.audit).abs();
        let worst = episodes.iter().max_by(|a, b| size(a).total_cmp(&size(b)))?;
        Some(Worst {
            value: get(&worst.audit),
            bound: bounds.iter().find(|bound| bound.field.name == name).map(|bound| bound.max),
            scene: worst.scene.clone(),
            reach_index: worst.reach_index,
        })
    };
    Audit::FIELDS.into_iter().filter_map(|field| Some((field.name, of_field(field.name, field.get)?))).collect()
}

/// The counts of the audit, summed over some reaches, by name.
pub fn counts(episodes: &[Episode]) -> BTreeMap<&'static str, u64> {
    let sum = |get: fn(&Audit) -> u32| episodes.iter().map(|episode| u64::from(get(&episode.audit))).sum();
    Audit::COUNTS.into_iter().map(|field| (field.name, sum(field.get))).collect()
}

/// Scene, index and audit of a reach.
type Audited<'a> = (&'a str, u64, &'a Audit);

/// The bounds that the audit of a reach exceeds, each as a sentence.
///
/// ```
/// use underbrush_experiments::audit::exceeded_bounds;
/// use underbrush_recording::{Audit, SkinLayout};
///
/// let layout = SkinLayout::default();
/// assert!(exceeded_bounds(&Audit::default(), &layout).is_empty());
/// let bad = Audit { largest_contact_residual: 0.5, ..Audit::default() };
/// assert!(exceeded_bounds(&bad, &layout)[0].starts_with("largest_contact_residual is 0.5; the bound is "));
/// ```
pub fn exceeded_bounds(audit: &Audit, layout: &SkinLayout) -> Vec<String> {
    let values = bounds(layout).map(|Bound { field, max, .. }| (field.name, (field.get)(audit), max));
    let exceeded = values.filter(|(_, value, max)| exceeds(*value, *max));
    exceeded
        .map(|(name, value, max)| format!("{name} is {}; the bound is {}", two_digits(value), two_digits(max)))
        .collect()
}

/// Warnings about reaches of a data set that exceed a bound of the audit, with the worst value, and about skin that nothing
/// touched.
pub fn warnings(episodes: &[Episode], layout: &SkinLayout) -> Vec<String> {
    let audited: Vec<Audited> = episodes.iter().map(|own| (own.scene.as_str(), own.reach_index, &own.audit)).collect();
    let touched = episodes.iter().flat_map(|episode| episode.touched_frames.values());
    passed_bounds(&audited, layout).into_iter().chain(untouched(touched, episodes.len(), layout)).collect()
}

/// Warnings about the bounds of the audit that a single reach exceeds, and about skin that nothing touched.
pub fn reach_warnings(recording: &Recording) -> Vec<String> {
    let audited = (recording.scene.as_str(), recording.reach_index, &recording.audit);
    let untouched = untouched(recording.touched_frames().values(), 1, &recording.layout);
    passed_bounds(&[audited], &recording.layout).into_iter().chain(untouched).collect()
}

/// A warning if nothing touched the skin of an arm that has some, in any frame.
fn untouched<'a>(
    mut touched_frames: impl Iterator<Item = &'a u32>,
    reaches: usize,
    layout: &SkinLayout,
) -> Option<String> {
    (reaches > 0 && layout.taxel_count() > 0 && touched_frames.all(|frames| *frames == 0)).then(|| {
        let which = if reaches == 1 { "the reach".into() } else { format!("any of the {reaches} reaches") };
        format!(
            "warning: nothing touched the skin in any frame of {which}; put skin on links that get near the objects, or \
             objects where the skin can touch them (`underbrush inspect ARM.toml --still arm.png` shows the skin)"
        )
    })
}

/// One warning for each bound that some of these reaches exceed, and one if the controller's program could not be
/// solved.
fn passed_bounds(reaches: &[Audited], layout: &SkinLayout) -> Vec<String> {
    let warning = |Bound { field, max, reason }: Bound| {
        let value = |(_, _, audit): &Audited| (field.get)(audit);
        let exceeding: Vec<&Audited> = reaches.iter().filter(|reach| exceeds(value(reach), max)).collect();
        let worst = exceeding.iter().max_by(|a, b| value(a).abs().total_cmp(&value(b).abs()))?;
        let (name, count, all, largest) = (field.name, exceeding.len(), reaches.len(), value(worst));
        let (scene, reach_index, _) = worst;
        Some(format!(
            "warning: {name} exceeds {} in {count} of {all} reaches, most in reach {reach_index} of {scene}: {} (the bound: \
             {reason})",
            two_digits(max),
            two_digits(largest)
        ))
    };
    let failed: u64 = reaches.iter().map(|(_, _, audit)| u64::from(audit.failed_controller_steps)).sum();
    let failed = (failed > 0).then(|| {
        format!(
            "warning: the controller's quadratic program could not be solved in {failed} steps; in these the equilibrium angles \
             did not change"
        )
    });
    bounds(layout).filter_map(warning).chain(failed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that a figure that is NaN, whatever its sign, exceeds its bound and is the worst.
    #[test]
    fn nan_is_the_worst() {
        let layout = SkinLayout::default();
        let [large, nan] = [0.5, -f64::NAN].map(|energy_residual| Audit { energy_residual, ..Audit::default() });
        assert_eq!(exceeded_bounds(&nan, &layout), ["energy_residual is NaN; the bound is 0.02"]);
        let found = passed_bounds(&[("leaf", 0, &nan), ("leaf", 1, &large)], &layout);
        assert!(found.len() == 1 && found[0].contains("in 2 of 2 reaches, most in reach 0 of leaf: NaN"), "{found:?}");
    }

    /// Tests that the worst of several reaches that exceed a bound is named with residual, bound and value, and that
    /// reaches within all bounds are not mentioned.
    #[test]
    fn every_broken_bound_is_named() {
        let layout = SkinLayout::default();
        let sound = Audit::default();
        let deep = |deepest_penetration_m| Audit { deepest_penetration_m, ..Audit::default() };
        let (deeper, deepest) = (deep(0.5), deep(0.75));
        let reach = |reach_index, audit| ("leaf", reach_index, audit);
        assert_eq!(passed_bounds(&[reach(0, &sound)], &layout), Vec::<String>::new());
        let found = passed_bounds(&[reach(0, &sound), reach(1, &deepest), reach(2, &deeper)], &layout);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(
            found[0].starts_with(
                "warning: deepest_penetration_m exceeds 0.01 in 2 of 3 reaches, most in reach 1 of leaf: 0.75"
            ),
            "{found:?}"
        );
        let failed = Audit { failed_controller_steps: 3, ..Audit::default() };
        let found = passed_bounds(&[reach(0, &sound), reach(1, &failed)], &layout);
        assert!(found.len() == 1 && found[0].contains("could not be solved in 3 steps"), "{found:?}");
    }
}
