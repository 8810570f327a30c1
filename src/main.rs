//! The command line: arguments, printing, exit status. Nothing else prints.

use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{Args, Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use revolve::job::{self, Prepared, Summary};
use revolve::study::compare::Reference;
use revolve::study::grid::Grid;
use revolve::study::quantity::Quantity;
use revolve::study::{sweep, table};
use revolve::user::compile::{Compiled, compile};
use revolve::user::{Routines, host};
use revolve::{deck, explain, output};

/// Axisymmetric explicit finite elements with user-load hooks.
#[derive(Parser)]
#[command(version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

/// Files with the user's routines.
#[derive(Args)]
struct UserFiles {
    /// File with user subroutines (vdload, vuamp, vdisp, vumat, vexternaldb): Fortran, C or a shared library; may be given
    /// several times.
    #[arg(long = "user", value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Build them with bounds checks: slower, and an index out of bounds is told.
    #[arg(long, requires = "files")]
    check_user: bool,
}

impl UserFiles {
    /// Compiles them, if there are any; `None` if they were refused (told).
    fn compiled(&self, quiet: bool) -> Option<Option<Compiled>> {
        if self.files.is_empty() {
            return Some(None);
        }
        let print = |found: &deck::Diagnostics| {
            if !found.is_empty() {
                eprintln!("{}", found.render(&deck::Sources::default()).trim_end());
            }
        };
        match compile(&self.files, self.check_user) {
            Ok(compiled) => {
                if !quiet {
                    print(&compiled.notes);
                }
                Some(Some(compiled))
            }
            Err(faults) => {
                print(&faults);
                None
            }
        }
    }

    /// Compiles and opens them.
    fn routines(&self, quiet: bool) -> Option<Routines> {
        let Some(compiled) = self.compiled(quiet)? else { return Some(Routines::none()) };
        match compiled.open() {
            Ok(routines) => Some(routines),
            Err(fault) => {
                let mut faults = deck::Diagnostics::default();
                faults.push(fault);
                eprintln!("{}", faults.render(&deck::Sources::default()).trim_end());
                None
            }
        }
    }
}

#[derive(Subcommand)]
enum Command {
    /// Run a deck and write frames, histories and a summary.
    Run {
        /// The input deck.
        deck: PathBuf,
        /// Replace the value of a *PARAMETER: NAME=VALUE.
        #[arg(long = "set", value_name = "NAME=VALUE")]
        set: Vec<String>,
        #[command(flatten)]
        user: UserFiles,
        /// Folder for the results (default out/<deck name>).
        #[arg(long)]
        out: Option<PathBuf>,
        /// Print nothing but errors.
        #[arg(long)]
        quiet: bool,
    },
    /// Check a deck: diagnostics and the ledger of what it would simulate.
    Check {
        /// The input deck.
        deck: PathBuf,
        /// Replace the value of a *PARAMETER: NAME=VALUE.
        #[arg(long = "set", value_name = "NAME=VALUE")]
        set: Vec<String>,
        #[command(flatten)]
        user: UserFiles,
    },
    /// Explain a keyword or a diagnostic code; `keywords` prints the whole manual.
    Explain {
        /// Keyword or code.
        word: Vec<String>,
    },
    /// Run a deck over values of its parameters: one table, CSV and picture.
    Sweep {
        /// The input deck.
        deck: PathBuf,
        /// NAME=v1,v2,… or NAME=start:stop:step or NAME=start:stop:#count; several make a grid.
        #[arg(long = "set", value_name = "NAME=VALUES", required = true)]
        set: Vec<String>,
        /// Expression over history columns, such as "-1000*final(U2@REF)"; may be given several times.
        #[arg(long, required = true, allow_hyphen_values = true)]
        quantity: Vec<String>,
        /// CSV file with reference columns over the first parameter.
        #[arg(long)]
        compare: Option<PathBuf>,
        #[command(flatten)]
        user: UserFiles,
        /// Folder for table and picture (default out/<deck name>).
        #[arg(long)]
        out: Option<PathBuf>,
        /// Threads (default: all cores).
        #[arg(long)]
        threads: Option<usize>,
        /// Print nothing but errors.
        #[arg(long)]
        quiet: bool,
    },
}

/// Deck or arguments refused.
const REFUSED: u8 = 2;
/// Halted during the run, state saved.
const HALTED: u8 = 1;

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Run { deck, set, user, out, quiet } => run(&deck, &set, &user, out, quiet),
        Command::Check { deck, set, user } => check(&deck, &set, &user),
        Command::Explain { word } => explain(&word.join(" ")),
        Command::Sweep { deck, set, quantity, compare, user, out, threads, quiet } => {
            run_sweep(&deck, &set, &quantity, compare.as_deref(), &user, out, threads, quiet)
        }
    };
    match result {
        Ok(code) => code,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(REFUSED)
        }
    }
}

fn pairs(settings: &[String]) -> Result<Vec<(String, String)>, String> {
    let pair = |s: &String| {
        let (name, value) = s.split_once('=').ok_or_else(|| format!("--set {s}: NAME=VALUE is the form"))?;
        Ok((name.trim().to_owned(), value.trim().to_owned()))
    };
    settings.iter().map(pair).collect()
}

/// Prints findings; whether the deck may run.
fn accepted(prepared: &Prepared, quiet: bool) -> bool {
    let errors = prepared.diagnostics.has_errors();
    if !prepared.diagnostics.is_empty() && (errors || !quiet) {
        let sources = &prepared.deck.sources;
        let styled = std::io::stderr().is_terminal();
        let text =
            if styled { prepared.diagnostics.render_styled(sources) } else { prepared.diagnostics.render(sources) };
        eprintln!("{}", text.trim_end());
    }
    !errors
}

fn check(deck: &Path, set: &[String], user: &UserFiles) -> Result<ExitCode, String> {
    let Some(routines) = user.routines(false) else { return Ok(ExitCode::from(REFUSED)) };
    let prepared = job::prepare(deck, &pairs(set)?, &routines);
    if !accepted(&prepared, false) {
        return Ok(ExitCode::from(REFUSED));
    }
    print!("{}", prepared.plan.ledger.render());
    Ok(ExitCode::SUCCESS)
}

fn run(deck: &Path, set: &[String], user: &UserFiles, out: Option<PathBuf>, quiet: bool) -> Result<ExitCode, String> {
    let Some(routines) = user.routines(quiet) else { return Ok(ExitCode::from(REFUSED)) };
    let mut prepared = job::prepare(deck, &pairs(set)?, &routines);
    if !accepted(&prepared, quiet) {
        return Ok(ExitCode::from(REFUSED));
    }
    if !quiet {
        println!("{}", prepared.plan.ledger.render());
    }
    let job = job::default_job(deck, out);
    let bar = progress_bar(1000, quiet);
    let mut progress = |step: &str, fraction: f64, increment: u64| {
        bar.set_position((1000.0 * fraction) as u64);
        bar.set_message(format!("{step}, increment {increment}"));
    };
    let summary = job::run_to_files(&mut prepared, &job, &mut progress).map_err(|e| e.to_string())?;
    bar.finish_and_clear();
    print_messages(&summary.messages, quiet);
    if !quiet {
        print_outcome(&summary, &job);
    }
    match &summary.reason {
        Some(reason) => {
            eprintln!("halted: {reason}\nthe last good state is in {}", job.path(".pvd").display());
            Ok(ExitCode::from(HALTED))
        }
        None => Ok(ExitCode::SUCCESS),
    }
}

/// What the user's routines had to say.
fn print_messages(messages: &[host::Message], quiet: bool) {
    for message in messages.iter().filter(|m| !quiet || m.level == host::Level::Error) {
        let level = format!("{:?}", message.level).to_lowercase();
        let times = if message.times > 1 { format!(" ({} times)", message.times) } else { String::new() };
        eprintln!("{level} from the user's routine: {}{times}", message.text);
    }
}

/// History columns that are printed after a run.
const SHOWN: usize = 24;

fn print_outcome(summary: &Summary, job: &output::Job) {
    if summary.ended_by_user {
        println!("the user's routine ended the analysis");
    }
    for rest in &summary.rests {
        println!("{} came to rest at time {:.6e}, displacement {:.6e}", rest.body, rest.time, rest.displacement);
    }
    for (name, column) in summary.history.0.iter().take(SHOWN) {
        println!("{name}: final {:.6e}, min {:.6e}, max {:.6e}", column.last, column.min, column.max);
    }
    if summary.history.0.len() > SHOWN {
        println!("… and {} more columns in {}", summary.history.0.len() - SHOWN, job.path("_history.csv").display());
    }
    for step in summary.steps.iter().filter(|s| s.limiting_element.is_some()) {
        let element = step.limiting_element.as_deref().unwrap_or_default();
        println!("{}: smallest increment {:.3e}, limited by element {element}", step.name, step.smallest_increment);
    }
    println!("energy drift {:.1e} of the largest energy", summary.energy.drift);
    for row in summary.ledger.effects.iter().filter(|r| r.share.is_some()) {
        println!("{}: {:.0} % of the time", row.effect, 100.0 * row.share.unwrap_or(0.0));
    }
    println!(
        "{} increments in {:.3} ms, results in {}",
        summary.timing.increments,
        1e3 * summary.timing.seconds,
        job.path(".pvd").display()
    );
}

fn progress_bar(length: u64, quiet: bool) -> ProgressBar {
    if quiet || !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let style =
        ProgressStyle::with_template("{bar:40} {percent} % {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(length).with_style(style)
}

fn explain(word: &str) -> Result<ExitCode, String> {
    match explain::explain(word) {
        Some(text) => {
            println!("{}", text.trim_end());
            Ok(ExitCode::SUCCESS)
        }
        None => {
            Err(format!("`{word}` is no keyword and no diagnostic code; `revolve explain keywords` lists all keywords"))
        }
    }
}

#[allow(clippy::too_many_arguments)] // One argument for each option of the command.
fn run_sweep(
    deck: &Path,
    set: &[String],
    quantity: &[String],
    compare: Option<&Path>,
    user: &UserFiles,
    out: Option<PathBuf>,
    threads: Option<usize>,
    quiet: bool,
) -> Result<ExitCode, String> {
    let grid = Grid::parse(set)?;
    let quantities = quantity.iter().map(|q| Quantity::parse(q)).collect::<Result<Vec<_>, _>>()?;
    let reference = compare.map(Reference::read).transpose()?;
    let Some(compiled) = user.compiled(quiet) else { return Ok(ExitCode::from(REFUSED)) };
    let routines = compiled.as_ref().map_or(Ok(Routines::none()), Compiled::open).map_err(|d| d.message)?;
    let first = job::prepare(deck, &grid.combination(0), &routines);
    if !accepted(&first, quiet) {
        return Ok(ExitCode::from(REFUSED));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build().map_err(|e| e.to_string())?;
    let bar = progress_bar(grid.count() as u64, quiet);
    let results = pool.install(|| sweep::run(deck, &grid, &quantities, compiled.as_ref(), &|| bar.inc(1)));
    bar.finish_and_clear();
    let sheet = sweep::sheet(&grid, &quantities, &results, reference.as_ref());
    let job = job::default_job(deck, out);
    write_sweep(&job, &first.deck, &grid, &quantities, &results, reference.as_ref(), &sheet)?;
    if !quiet {
        print_sweep(&sheet, &job);
    }
    Ok(report_failures(&results))
}

fn print_sweep(sheet: &sweep::Sheet, job: &output::Job) {
    print!("{}", table::terminal(&sheet.header, &sheet.rows));
    for (column, rms) in &sheet.rms {
        println!("rms difference from {column}: {rms:.4}");
    }
    println!("table {}, picture {}", job.path("_sweep.csv").display(), job.path("_sweep.png").display());
}

fn report_failures(results: &sweep::Results) -> ExitCode {
    let failed: Vec<_> = results.values.iter().filter_map(|v| v.as_ref().err()).collect();
    match failed.first() {
        None => ExitCode::SUCCESS,
        Some(reason) => {
            eprintln!("{} of {} runs gave no result; the first:\n{reason}", failed.len(), results.values.len());
            ExitCode::from(HALTED)
        }
    }
}

fn write_sweep(
    job: &output::Job,
    deck: &deck::Deck,
    grid: &Grid,
    quantities: &[Quantity],
    results: &sweep::Results,
    reference: Option<&Reference>,
    sheet: &sweep::Sheet,
) -> Result<(), String> {
    std::fs::create_dir_all(&job.folder)
        .map_err(|e| format!("cannot make the folder {}: {e}", job.folder.display()))?;
    let title = deck.sources.files().first().map_or("sweep", |f| f.name.as_str());
    let write = |ending: &str, bytes: &[u8]| output::write_whole(&job.path(ending), bytes).map_err(|e| e.to_string());
    write("_sweep.csv", table::csv(&sheet.header, &sheet.rows).as_bytes())?;
    if sheet.rows.is_empty() {
        return Ok(());
    }
    let chart = sweep::chart(title, grid, quantities, results, reference);
    write("_sweep.svg", chart.svg()?.as_bytes())?;
    write("_sweep.png", &chart.png()?)
}
