//! The classifier `touch`, which judges frames instead of trials: options and work of the commands that use it.

mod decision;
mod evaluate;
mod simulated;
mod text;
mod train;

pub use decision::{RiskArguments, TouchDecisionArguments};
pub use evaluate::{Judge, evaluate};
pub use simulated::SimulatedArguments;
pub use train::train;
