//! A compliant arm with tactile skin reaches through simulated foliage: scene → clutter → world → reach → recording.

pub mod arm;
pub mod campaign;
pub mod clutter;
pub mod controller;
pub mod geometry;
mod monitor;
pub mod object;
pub mod physics;
pub mod reach;
pub mod scene;
pub mod seed;
pub mod sensor;
pub mod skin;
pub mod snapshot;
pub mod touch;
pub mod world;
