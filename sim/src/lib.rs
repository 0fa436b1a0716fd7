//! A compliant arm with tactile skin reaches through simulated foliage: scene → clutter → world → reach → recording.

pub mod arm;
pub mod clutter;
pub mod controller;
pub mod geometry;
pub mod object;
pub mod physics;
pub mod scene;
pub mod seed;
pub mod sensor;
pub mod world;
