//! The engine's side of a simulation.

pub mod mechanism;
