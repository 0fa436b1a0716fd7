//! Tests of what users see: the command line end to end, bad input, the scenes that ship, and agreement with
//! log-likelihoods from another program.
#![allow(clippy::unwrap_used, reason = "a test or bench may end in a panic")]

mod bad_input;
mod cli;
mod library;
mod support;
