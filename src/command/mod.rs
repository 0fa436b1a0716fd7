//! One file a subcommand.

pub mod classify;
pub mod evaluate;
pub mod generate;
pub mod inspect;
pub mod reach;
pub mod reproduce;
pub mod schema;
pub mod score;
pub mod train;
pub mod trials;
pub mod validate;
