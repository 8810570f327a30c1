//! The program: the command line and nothing else.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(revolve::command_line(std::env::args_os()).0)
}
