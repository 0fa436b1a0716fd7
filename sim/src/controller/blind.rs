//! The baseline: the same controller without its skin.

use super::{Controller, ControllerInput, ControllerOutput, ModelPredictive, Preset};
use crate::arm::Arm;

/// The model-predictive controller as it would move if it felt nothing.
#[derive(Clone, Debug)]
pub struct Blind(ModelPredictive);

impl Blind {
    /// The baseline of a preset.
    pub fn new(preset: Preset, arm: &Arm) -> Self {
        Blind(ModelPredictive::new(preset, arm))
    }
}

impl Controller for Blind {
    fn name(&self) -> &str {
        "blind"
    }

    fn preset(&self) -> &Preset {
        self.0.preset()
    }

    fn control(&self, input: &ControllerInput<'_>) -> ControllerOutput {
        self.0.control(&ControllerInput {
            contacts: &[],
            ..input.clone()
        })
    }
}
