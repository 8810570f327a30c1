//! Main function of the program `revolve`.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(revolve::command_line(std::env::args_os()).0)
}
