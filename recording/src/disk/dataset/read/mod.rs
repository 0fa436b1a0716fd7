//! Reads a finished data set.

pub(super) mod reader;
mod some_columns;
