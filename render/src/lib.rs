//! Pictures of a reach, drawn by the processor: in colour with shadows, depth, and which body is where.
//!
//! A [`Stage`] holds the shapes of a recording or of a running simulation. [`Stage::moment`] places them as they are in a
//! frame, and the [`Scene`] that it returns is drawn from a [`Camera`]. Only additions, multiplications, divisions and roots
//! are used, so that the same moment gives the same bytes on every machine.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod camera;
mod colour;
mod film;
mod marks;
mod mesh;
mod raster;
mod scene;
mod shadow;
mod stage;
#[cfg(test)]
mod tests;

pub use camera::{Camera, RenderError, Size};
pub use film::Film;
pub use scene::Scene;
pub use stage::{Stage, fullest};
