//! Contact between bodies with compliant surfaces: the law, the patch it acts on, and the velocities that follow.
//!
//! Nothing here depends on the engine. [`crate::simulation`] brings shapes together with the poses, Jacobians and mass
//! matrices of [`crate::dynamics`]. `docs/physics.md` derives the method.

mod block_matrix;
pub mod chord;
pub mod law;
pub mod outline;
pub mod patch;
pub mod plane;
pub mod settle;
pub mod solver;
pub mod surface;

#[cfg(test)]
mod continuity_tests;
#[cfg(test)]
mod tests;
