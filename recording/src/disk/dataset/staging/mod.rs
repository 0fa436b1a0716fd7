//! Writes a data set: reaches are staged one by one, and then assembled.

mod assembled;
mod card;
mod finish;
pub(super) mod folder;
pub(super) mod merge;
mod shared;
mod staged_reach;
mod statistics;
pub(super) mod table_files;
pub(super) mod writer;
