//! Reads a finished data set.

mod columns;
pub(super) mod reader;
