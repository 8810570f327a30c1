//! `revolve sweep`.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use revolve::study::compare::Reference;
use revolve::study::grid::Grid;
use revolve::study::quantity::Quantity;
use revolve::study::{sweep, table};
use revolve::user::compile::Compiled;
use revolve::{deck, job, output};

use super::words::{self, say, tell};
use super::{HALTED, REFUSED, UserFiles, accepted, folder_of, progress_bar, tell_warnings};

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
        if let Some(path) = self.compare.as_ref().filter(|_| reference.as_ref().is_some_and(|r| r.is_open)) {
            tell!(
                "warning: --compare {}: the last line has no end; if the file is cut off its last row is wrong",
                path.display()
            );
        }
        let Some(compiled) = self.user.compiled(self.quiet) else { return Ok(ExitCode::from(REFUSED)) };
        let routines = Compiled::open_any(compiled.as_ref()).map_err(|fault| fault.message)?;
        let first = job::prepare(&self.deck, &grid.combination(0), &routines);
        if !accepted(&first, self.quiet) {
            return Ok(ExitCode::from(REFUSED));
        }
        let Some((job, _lock)) = folder_of(&self.deck, self.out)? else { return Ok(ExitCode::from(REFUSED)) };
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.unwrap_or(0))
            .build()
            .map_err(|e| e.to_string())?;
        let bar = progress_bar(grid.count() as u64, self.quiet);
        let results = pool.install(|| sweep::run(&self.deck, &grid, &quantities, compiled.as_ref(), &|| bar.inc(1)));
        bar.finish_and_clear();
        let sheet = sweep::sheet(&grid, &quantities, &results, reference.as_ref());
        write_sweep(&job, &first.deck, &grid, &quantities, &results, reference.as_ref(), &sheet)?;
        if !self.quiet {
            print_sweep(&sheet, &job);
            tell_warnings(
                results.parameters.iter().zip(&results.warnings).map(|(values, w)| (setting(&grid, values), &w[..])),
            );
        }
        Ok(report_failures(&results))
    }
}

/// Names and values of a combination.
fn setting(grid: &Grid, values: &[String]) -> String {
    grid.names().iter().zip(values).map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", ")
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
    let title = deck.sources.files().first().map_or("sweep", |f| f.name.as_str());
    let mut files = vec![("_sweep.csv".to_owned(), table::csv(&sheet.header, &sheet.rows).into_bytes())];
    if !sheet.rows.is_empty() {
        let chart = sweep::chart(title, grid, quantities, results, reference);
        files.push(("_sweep.svg".into(), chart.svg()?.into_bytes()));
        files.push(("_sweep.png".into(), chart.png()?));
    }
    Ok(output::write_with_sums(job, &files, "_sweep.sfv").map_err(|e| e.to_string())?)
}
