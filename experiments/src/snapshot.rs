//! One moment of a reach with the verdicts on its taxels (paper, Figs. 12 and 14).

use std::collections::{BTreeMap, BTreeSet};

use underbrush_classifier::HmmClassifier;
use underbrush_classifier::decision::{Rule, Verdict};
use underbrush_classifier::online::OnlineClassifier;
use underbrush_recording::{Frame, SkinLayout};
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::snapshot::Snapshot;

use crate::data;
use crate::error::ExperimentError;
use crate::online::{self, Classified};

/// Arm, clutter and verdicts at one moment.
pub struct Moment {
    pub snapshot: Snapshot,
    pub layout: SkinLayout,
    /// Index of the patch that is classified.
    pub patch: usize,
    /// Verdict by taxel of that patch.
    pub verdicts: BTreeMap<usize, Verdict>,
    /// Taxels of that patch that an object truly presses on; the others in contact are strays, creep or crosstalk.
    pub pressed: BTreeSet<usize>,
    pub scene: String,
    pub reach_index: u64,
}

/// Runs a reach of a plan once more and stops it where most taxels are in contact: the moment is chosen by how much there
/// is to see, not by how well it is classified. `None` where there is no such reach.
pub fn take(
    models: &HmmClassifier,
    shown: Option<&Classified>,
    plan: &ReachPlan,
    rule: Rule,
) -> Result<Option<Moment>, ExperimentError> {
    let Some(shown) = shown else { return Ok(None) };
    let most = shown
        .stream
        .frames
        .iter()
        .enumerate()
        .max_by_key(|(index, frame)| (frame.in_contact, std::cmp::Reverse(*index)));
    let Some((chosen, _)) = most else { return Ok(None) };
    let options = online::options(rule);
    let layout = plan.arm.skin.layout.clone();
    let mut classifier = OnlineClassifier::new(models, &layout, &options)?;
    let (mut index, mut taken, mut fault) = (0, None, None);
    plan.run(shown.reach_index, &mut |simulation, frame| {
        if index <= chosen && fault.is_none() {
            match classifier.update(frame) {
                Ok(judged) if index == chosen => {
                    let verdicts = judged.map(|taxel| (taxel.taxel, taxel.verdict.clone())).collect();
                    taken = Some((Snapshot::take(simulation, frame), verdicts));
                }
                Ok(_) => {}
                Err(error) => fault = Some(error),
            }
        }
        index += 1;
    })?;
    if let Some(error) = fault {
        return Err(error.into());
    }
    let patch = layout
        .chosen_patch(data::trial_options().patch.as_deref())
        .unwrap_or_default();
    Ok(taken.map(|(snapshot, verdicts)| Moment {
        pressed: pressed(&snapshot.frame, patch),
        snapshot,
        layout,
        patch,
        verdicts,
        scene: shown.scene.clone(),
        reach_index: shown.reach_index,
    }))
}

/// The taxels of a patch that an object presses on.
fn pressed(frame: &Frame, patch: usize) -> BTreeSet<usize> {
    let own = frame.taxels.iter().filter(|own| usize::from(own.patch) == patch);
    own.filter(|own| own.object.is_some())
        .map(|own| usize::from(own.taxel))
        .collect()
}
