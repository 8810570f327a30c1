//! The command line. Nothing but `command` prints.

mod command;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use command::words::tell;
use command::{REFUSED, chart, check, explain, new, report, run, shell, study, sweep};

/// Axisymmetric explicit finite elements with user-load hooks.
#[derive(Parser)]
#[command(version, long_version = shell::version(), arg_required_else_help = true)]
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
    Report(report::Report),
    Chart(chart::Chart),
    New(new::New),
    Completions(shell::Completions),
    Man(shell::Man),
}

fn main() -> ExitCode {
    revolve::model::silence_caught_panics();
    command::signals::outlive_limits();
    let result = match Arguments::parse().command {
        Command::Run(run) => run.execute(),
        Command::Study(study) => study.execute(),
        Command::Check(check) => check.execute(),
        Command::Explain(explain) => explain.execute(),
        Command::Sweep(sweep) => sweep.execute(),
        Command::Report(report) => report.execute(),
        Command::Chart(chart) => chart.execute(),
        Command::New(new) => new.execute(),
        Command::Completions(completions) => completions.execute::<Arguments>(),
        Command::Man(man) => man.execute::<Arguments>(),
    };
    match result {
        Ok(code) => code,
        Err(message) => {
            tell!("error: {message}");
            ExitCode::from(REFUSED)
        }
    }
}
