//! Contact between bodies with compliant surfaces: the law, the patch it acts on, and the velocities that follow.
//!
//! Nothing here knows of the engine. [`crate::simulation`] takes shapes, poses, Jacobians and mass matrices from it, and gives
//! it back what contacts change. `docs/physics.md` derives the method.

pub mod chord;
mod envelope;
pub mod law;
pub mod patch;
pub mod solver;
pub mod stop;
pub mod surface;

#[cfg(test)]
mod tests;
