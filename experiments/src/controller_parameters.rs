//! The parameters of a controller that data sets store.

use serde::Serialize;
use underbrush_sim::controller::Preset;
use underbrush_sim::reach::{ReachPlan, ReachRules};

use crate::verdict_controller::{VerdictControl, VerdictParameters};

/// The parameters of a scene's controller and of the rules that end its reaches, as stored in a data set.
#[derive(Serialize)]
pub(crate) struct ControllerParameters<'a> {
    #[serde(flatten)]
    preset: Option<&'a Preset>,
    #[serde(flatten)]
    rules: &'a ReachRules,
    #[serde(skip_serializing_if = "Option::is_none")]
    verdicts: Option<VerdictParameters<'a>>,
}

impl<'a> ControllerParameters<'a> {
    pub(crate) fn of(plan: &'a ReachPlan, verdicts: Option<&'a VerdictControl>) -> Self {
        ControllerParameters {
            preset: plan.controller.preset(),
            rules: &plan.rules,
            verdicts: verdicts.map(|verdicts| verdicts.parameters(&plan.scene)),
        }
    }
}
