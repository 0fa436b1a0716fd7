//! `underbrush push` and `pull` in a program that was built without them.

use std::ffi::OsString;

use clap::Args;

use crate::failure::Failure;

/// Any arguments of these commands.
#[derive(Args)]
#[command(disable_help_flag = true)]
pub struct Options {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<OsString>,
}

/// Fails with a message that says how to get these commands.
pub fn run(_: Options) -> Result<(), Failure> {
    Err(Failure::usage(
        "this program was built without push and pull, which copy data sets to and from S3-like storage; build it with `cargo \
         build --release --features cloud`",
    ))
}
