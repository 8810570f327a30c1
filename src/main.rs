//! Main function of the program `revolve`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(revolve::command_line(std::env::args_os()).0)
}
