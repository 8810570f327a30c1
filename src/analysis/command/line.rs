//! Parsing of the command line and dispatch to the commands, for the program and the Python package.

use std::error::Error;
use std::ffi::OsString;

use crate::deck::untrusted;
use clap::{Parser, Subcommand};

use super::words::{print_err, record_command};
use super::{
    CommandStatus, chart, check, explain, fragments, identify, info, limit, lsp, material, mesh, new, print_error,
    report, resistance, run, scatter, sensitivity, shell, study, sweep, view,
};

/// Axisymmetric explicit finite-element code for ABAQUS-style decks with user subroutines.
#[derive(Parser)]
#[command(name = "revolve", bin_name = "revolve", version, long_version = shell::version(), arg_required_else_help = true)]
pub struct ProgramArguments {
    /// Restrict what a deck can do, for decks from unknown sources: no user subroutines, no files outside the folder of
    /// the deck, no lines of included files in messages, limits on elements, results and time. REVOLVE_UNTRUSTED=1 does
    /// the same.
    #[arg(long, global = true)]
    untrusted: bool,
    #[command(subcommand)]
    pub command: ProgramCommand,
}

/// Defines the commands and their dispatch.
macro_rules! program_commands {
    ($($name:ident: $command:ty,)*) => {
        #[derive(Subcommand)]
        pub enum ProgramCommand {
            $($name($command),)*
        }

        impl ProgramCommand {
            fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
                match self {
                    $(ProgramCommand::$name(command) => command.execute(),)*
                }
            }
        }
    };
}

program_commands! {
    Run: run::RunCommand,
    Study: study::StudyCommand,
    Check: check::CheckCommand,
    Explain: explain::ExplainCommand,
    Sweep: sweep::SweepCommand,
    Scatter: scatter::ScatterCommand,
    Sensitivity: sensitivity::SensitivityCommand,
    Limit: limit::LimitCommand,
    Identify: identify::IdentifyCommand,
    Report: report::ReportCommand,
    Fragments: fragments::FragmentsCommand,
    Info: info::InfoCommand,
    Rerun: info::RerunCommand,
    Resistance: resistance::ResistanceCommand,
    Material: material::MaterialCommand,
    Chart: chart::ChartCommand,
    View: view::ViewCommand,
    New: new::NewCommand,
    Mesh: mesh::MeshCommand,
    Lsp: lsp::LspCommand,
    Completions: shell::CompletionsCommand,
    Man: shell::ManCommand,
}

/// Runs a command line, whose first argument is the program name, with the output of the program, and returns its exit
/// status. It installs signal handlers; call it at most once per process.
pub fn command_line(arguments: impl IntoIterator<Item = OsString>) -> CommandStatus {
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    record_command(arguments.iter().skip(1).map(|word| word.to_string_lossy().into_owned()).collect());
    let command = match ProgramArguments::try_parse_from(arguments) {
        Ok(arguments) => {
            if (arguments.untrusted || untrusted::is_requested())
                && let Err(error) = restrict()
            {
                print_err!("error: {error}");
                return CommandStatus::REFUSED;
            }
            arguments.command
        }
        Err(error) => {
            // An error of standard output cannot be reported anywhere.
            let _ = error.print();
            return CommandStatus(error.exit_code() as u8);
        }
    };
    crate::model::silence_caught_panics();
    crate::platform::signals::outlive_limits();
    command.execute().unwrap_or_else(|error| {
        print_error(&*error);
        CommandStatus::REFUSED
    })
}

/// Turns the restrictions for decks from unknown sources on, and ends the process after the longest permitted time.
fn restrict() -> Result<(), String> {
    untrusted::restrict();
    let limit = untrusted::time_limit()?;
    let end = move || {
        std::thread::sleep(limit);
        print_err!("error: the time limit of --untrusted, {} s, is reached", limit.as_secs_f64());
        std::process::exit(i32::from(CommandStatus::HALTED.0));
    };
    let thread = std::thread::Builder::new().name("time limit".into()).spawn(end);
    thread
        .map(drop)
        .map_err(|error| format!("the time limit of --untrusted needs a thread, which cannot be started: {error}"))
}
