//! The baseline: the same controller without tactile feedback.

use super::{Controller, ControllerInput, ControllerOutput, ModelPredictive, Preset};
use crate::arm::Arm;

/// The model-predictive controller with all contacts withheld.
#[derive(Clone, Debug)]
pub struct Blind(ModelPredictive);

impl Blind {
    /// The baseline for a set of parameters.
    pub fn new(preset: Preset, arm: &Arm) -> Self {
        Blind(ModelPredictive::new(preset, arm))
    }
}

impl Controller for Blind {
    fn name(&self) -> &str {
        "blind"
    }

    fn rate_hz(&self) -> f64 {
        self.0.rate_hz()
    }

    fn control(&mut self, input: &ControllerInput<'_>) -> ControllerOutput {
        self.0.control(&ControllerInput { contacts: &[], ..input.clone() })
    }
}
