//! Writes a data set: reaches are staged one by one, and then assembled.

mod finish;
pub(super) mod folder;
mod packed;
pub(super) mod parts;
mod statistics;
pub(super) mod table_files;
pub(super) mod writer;
