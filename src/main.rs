//! The program underbrush.

use std::process::ExitCode;

fn main() -> ExitCode {
    underbrush::run_command_line(std::env::args_os()).into()
}
