//! What a user would notice: the command line end to end, bad input, the scenes that ship, and agreement with
//! log-likelihoods that another program computed.

mod bad_input;
mod cli;
mod library;
mod support;
