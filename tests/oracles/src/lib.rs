//! Closed-form solutions that judge the simulation and the models.
//!
//! This crate contains only formulas. It depends on no simulator, engine or classifier. Each formula is tested against
//! published figures or against a second way of computing it.
//!
//! | what | where |
//! |---|---|
//! | cantilevers under small and large loads; first frequency | [`beam`] |
//! | cantilevers as chains with hinges at Gauss-Legendre nodes | [`chain`] |
//! | damped oscillators, exact and under the θ-method | [`oscillator`] |
//! | an elastic layer over a hard body (Winkler) | [`foundation`] |
//! | foam: bars, sag, standard linear solids | [`foam`] |
//! | friction on a slope, stiffnesses in series, cylinders that tip over | [`statics`] |
//! | probability of a sequence as the sum over all paths | [`markov`] |
//! | bisection; orders of convergence | [`numeric`] |

pub mod beam;
pub mod chain;
pub mod foam;
pub mod foundation;
pub mod markov;
pub mod numeric;
pub mod oscillator;
pub mod statics;
