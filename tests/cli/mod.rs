//! The commands end to end, on small inputs.

mod classify;
mod evaluate;
mod flips;
mod generate;
mod inspect;
mod oracle;
mod provenance;
mod reach;
mod resume;
mod thresholds;
mod torn;
mod train;
mod trials;
mod validate;
