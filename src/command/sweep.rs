//! `revolve sweep`.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use revolve::model::Precision;
use revolve::study::compare::Reference;
use revolve::study::grid::Grid;
use revolve::study::quantity::Quantity;
use revolve::study::{sweep, table};
use revolve::user::compile::Compiled;
use revolve::{deck, job, output};

use super::words::{self, say, tell};
use super::{HALTED, REFUSED, UserFiles, accepted, progress_bar};

/// Run a deck over values of its parameters: one table, CSV and picture.
#[derive(Args)]
pub struct Sweep {
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
    /// Precision of solid elements: double or single.
    #[arg(long, value_name = "DIGITS", default_value = "double")]
    precision: Precision,
    /// Threads (default: all cores).
    #[arg(long)]
    threads: Option<usize>,
    /// Print nothing but errors.
    #[arg(long)]
    quiet: bool,
}

impl Sweep {
    /// Carries it out.
    pub fn execute(self) -> Result<ExitCode, Box<dyn Error>> {
        let grid = Grid::parse(&self.set)?;
        let quantities = self.quantity.iter().map(|q| Quantity::parse(q)).collect::<Result<Vec<_>, _>>()?;
        let reference = self.compare.as_deref().map(Reference::read).transpose()?;
        if let (Some(path), Some(reference)) = (&self.compare, &reference) {
            sweep::comparable(&grid, path, reference)?;
        }
        let Some(compiled) = self.user.compiled(self.quiet) else { return Ok(ExitCode::from(REFUSED)) };
        let routines = Compiled::open_any(compiled.as_ref()).map_err(|fault| fault.message)?;
        let first = job::prepare_in(self.precision, &self.deck, &grid.combination(0), &routines);
        if !accepted(&first, self.quiet) {
            return Ok(ExitCode::from(REFUSED));
        }
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.unwrap_or(0))
            .build()
            .map_err(|e| e.to_string())?;
        let bar = progress_bar(grid.count() as u64, self.quiet);
        let deck = (&*self.deck, self.precision);
        let results = pool.install(|| sweep::run(deck, &grid, &quantities, compiled.as_ref(), &|| bar.inc(1)));
        bar.finish_and_clear();
        let sheet = sweep::sheet(&grid, &quantities, &results, reference.as_ref());
        let job = job::default_job(&self.deck, self.out).map_err(|finding| finding.message)?;
        write_sweep(&job, &first.deck, &grid, &quantities, &results, reference.as_ref(), &sheet)?;
        if !self.quiet {
            print_sweep(&sheet, &job);
        }
        Ok(report_failures(&results))
    }
}

fn print_sweep(sheet: &sweep::Sheet, job: &output::Job) {
    words::write(format_args!("{}", table::terminal(&sheet.header, &sheet.rows)), false);
    for (column, rms) in &sheet.rms {
        say!("rms difference from {column}: {rms:.4}");
    }
    say!("table {}, picture {}", job.path("_sweep.csv").display(), job.path("_sweep.png").display());
}

fn report_failures(results: &sweep::Results) -> ExitCode {
    let failed: Vec<_> = results.values.iter().filter_map(|v| v.as_ref().err()).collect();
    match failed.first() {
        None => ExitCode::SUCCESS,
        Some(reason) => {
            tell!("{} of {} runs gave no result; the first:\n{reason}", failed.len(), results.values.len());
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
) -> Result<(), Box<dyn Error>> {
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
    Ok(write("_sweep.png", &chart.png()?)?)
}
