//! The audit of a data set for people: the worst figures, where they are, and warnings where they pass their bounds.

use std::collections::BTreeMap;

use serde::Serialize;
use underbrush_recording::Audit;
use underbrush_recording::disk::Episode;
use underbrush_sim::audit::bounds;

use crate::output;

/// The worst value of one figure and where it is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Worst {
    /// The value.
    pub value: f64,
    /// Scene of the reach.
    pub scene: String,
    /// Index of the reach in its scene.
    pub reach_index: u64,
}

/// The worst value of every figure over some reaches, by the figure's name.
pub fn worst(episodes: &[Episode]) -> BTreeMap<&'static str, Worst> {
    let of_field = |get: fn(&Audit) -> f64| {
        let worst = episodes.iter().max_by(|a, b| get(&a.audit).total_cmp(&get(&b.audit)))?;
        Some(Worst {
            value: get(&worst.audit),
            scene: worst.scene.clone(),
            reach_index: worst.reach_index,
        })
    };
    let fields = Audit::FIELDS.into_iter();
    fields
        .filter_map(|field| Some((field.name, of_field(field.get)?)))
        .collect()
}

/// The worst figures as a table.
pub fn text(worst: &BTreeMap<&'static str, Worst>) -> String {
    let rows: Vec<Vec<String>> = worst
        .iter()
        .map(|(name, worst)| {
            let bound = bounds().find(|bound| bound.field.name == *name);
            vec![
                (*name).into(),
                format!("{:.1e}", worst.value),
                bound.map_or("-".into(), |bound| format!("{:.1e}", bound.most)),
                format!("{} {}", worst.scene, worst.reach_index),
            ]
        })
        .collect();
    output::table(&["audit, worst of all reaches", "value", "bound", "reach"], &rows)
}

/// Says on stderr which reaches pass a bound of the audit, and by how much the worst does.
pub fn warn(episodes: &[Episode]) {
    for bound in bounds() {
        let get = bound.field.get;
        let beyond: Vec<&Episode> = episodes
            .iter()
            .filter(|episode| get(&episode.audit) > bound.most)
            .collect();
        let Some(worst) = beyond.iter().max_by(|a, b| get(&a.audit).total_cmp(&get(&b.audit))) else {
            continue;
        };
        output::remark(format!(
            "warning: {} passes {:.1e} in {} of {} reaches, most in reach {} of {}: {:.1e} (the bound: {})",
            bound.field.name,
            bound.most,
            beyond.len(),
            episodes.len(),
            worst.reach_index,
            worst.scene,
            get(&worst.audit),
            bound.reason
        ));
    }
}
