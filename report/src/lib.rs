//! Charts, tables, words, pages and pictures of what the simulator and the experiments give.
#![allow(missing_docs, reason = "the restructuring that follows documents what stays public")]

pub mod drawing;
pub mod figures;
pub mod page;
pub mod picture;
pub mod portrait;
pub mod skin_map;
pub mod tables;
pub mod text;
pub mod words;

#[cfg(test)]
mod tests;
