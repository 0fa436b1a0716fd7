//! Maps the errors of this crate to [`Fault`].

use underbrush_recording::Fault;

use crate::campaign::CampaignError;
use crate::controller::UnknownController;
use crate::reach::ReachError;
use crate::simulation::StateError;

impl From<ReachError> for Fault {
    fn from(error: ReachError) -> Self {
        match error {
            ReachError::Input(input) => input.into(),
            ReachError::EquilibriumAngles { .. } | ReachError::NoAngle { .. } | ReachError::Stopped => {
                Fault::Run(error.to_string())
            }
        }
    }
}

impl From<CampaignError> for Fault {
    fn from(error: CampaignError) -> Self {
        match error {
            CampaignError::Reach(error) => error.into(),
            CampaignError::Engine { .. } => Fault::Run(error.to_string()),
        }
    }
}

impl From<StateError> for Fault {
    fn from(error: StateError) -> Self {
        Fault::Usage(error.to_string())
    }
}

impl From<UnknownController> for Fault {
    fn from(error: UnknownController) -> Self {
        Fault::Usage(error.to_string())
    }
}
