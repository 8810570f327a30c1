//! The command line: which command is meant. The program and the Python package enter here.

use std::ffi::OsString;

use clap::{Parser, Subcommand};

use super::{
    REFUSED, Status, chart, check, explain, identify, limit, mesh, new, print_error, report, resistance, run, scatter,
    shell, study, sweep,
};

/// Axisymmetric explicit finite elements with user-load hooks.
#[derive(Parser)]
#[command(name = "revolve", bin_name = "revolve", version, long_version = shell::version(), arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Run(run::Run),
    Study(study::Study),
    Check(check::Check),
    Explain(explain::Explain),
    Sweep(sweep::Sweep),
    Scatter(scatter::Scatter),
    Limit(limit::Limit),
    Identify(identify::Identify),
    Report(report::Report),
    Resistance(resistance::Resistance),
    Chart(chart::Chart),
    New(new::New),
    Mesh(mesh::Mesh),
    Completions(shell::Completions),
    Man(shell::Man),
}

/// Carries out a command line, of which the first argument is the name of the program; prints as the program does. It takes
/// over signals, so a process should do it once.
pub fn command_line(arguments: impl IntoIterator<Item = OsString>) -> Status {
    let command = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments.command,
        Err(told) => {
            // Help that cannot be printed is of no use to anybody.
            let _ = told.print();
            return Status(told.exit_code() as u8);
        }
    };
    crate::model::silence_caught_panics();
    crate::platform::signals::outlive_limits();
    let result = match command {
        Command::Run(run) => run.execute(),
        Command::Study(study) => study.execute(),
        Command::Check(check) => check.execute(),
        Command::Explain(explain) => explain.execute(),
        Command::Sweep(sweep) => sweep.execute(),
        Command::Scatter(scatter) => scatter.execute(),
        Command::Limit(limit) => limit.execute(),
        Command::Identify(identify) => identify.execute(),
        Command::Report(report) => report.execute(),
        Command::Resistance(resistance) => resistance.execute(),
        Command::Chart(chart) => chart.execute(),
        Command::New(new) => new.execute(),
        Command::Mesh(mesh) => mesh.execute(),
        Command::Completions(completions) => completions.execute::<Arguments>(),
        Command::Man(man) => man.execute::<Arguments>(),
    };
    result.unwrap_or_else(|error| {
        print_error(&*error);
        Status(REFUSED)
    })
}
