//! A compliant arm with tactile skin reaches through simulated foliage: scene → clutter → world → reach → recording.
//!
//! | step | where |
//! |---|---|
//! | a scene file with the ranges to draw from | [`scene`] |
//! | one draw of the scene from a seed | [`clutter`], [`object`], [`seed`] |
//! | the arm and its skin, from files | [`arm`] |
//! | arm and clutter in the physics engine: equilibrium angles in, one report of the frame out | [`simulation`] |
//! | how arm and objects move: joint trees and their contacts | [`dynamics`], [`contact`] |
//! | contacts spread over taxels, and the sensor's readings | [`skin`], [`sensor`] |
//! | equilibrium angles from the sensed forces | [`controller`] |
//! | the loop of one reach, and many reaches | [`reach`], [`campaign`] |
//! | a reach as an environment for an agent that learns | [`environment`] |

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod arm;
pub mod audit;
pub mod blade;
pub mod body_log;
pub mod campaign;
pub mod clutter;
pub mod contact;
pub mod controller;
pub mod dynamics;
pub mod environment;
mod friction_cone;
pub mod geometry;
pub mod materials;
mod newton;
pub mod object;
pub mod physics;
pub mod range;
pub mod reach;
pub mod scene;
pub mod seed;
pub mod sensor;
pub mod simulation;
pub mod skin;

pub use arm::Arm;
pub use clutter::{Clutter, PlacedObject};
pub use contact::surface::Surface;
pub use controller::{ControllerInput, ControllerKind};
pub use geometry::Footprint;
pub use physics::PhysicsOptions;
pub use range::{Draw, DrawError};
pub use reach::{Observed, ReachPlan, ReachSoFar};
pub use scene::Scene;
pub use sensor::SensorOptions;
pub use simulation::Simulation;
