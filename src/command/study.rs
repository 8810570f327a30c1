//! `revolve study`.

use std::error::Error;
use std::path::PathBuf;

use crate::study::StudyError;
use crate::study::asked;
use crate::study::bench::Bench;
use crate::study::chart::{Chart, Scale};
use crate::study::effects::{self, Effects};
use crate::study::quantity::Quantity;
use crate::study::record::{self, Timing};
use crate::study::refinement::{Row, Study as Results};
use crate::study::settings::{self, Axis};
use crate::study::table;
use crate::study::target::{Met, Target};
use crate::user::compile::Compiled;
use crate::{deck, job, model, output};
use clap::Args;

use super::words::{self, say, tell};
use super::{HALTED, REFUSED, Status, UserFiles, accepted, folder_of, given, pairs, progress, tell_doubts};

/// Refine a deck: observed order, error, and what accuracy costs.
#[derive(Args)]
pub struct Study {
    /// The input deck.
    deck: PathBuf,
    /// NAME=v1,v2,… from coarse to fine: a parameter of the deck, increment (factors), load-velocity, hourglass, estimate,
    /// precision; several make a grid.
    #[arg(long, value_name = "NAME=VALUES")]
    refine: Vec<String>,
    /// Expression over histories and norms, such as "-1000*final(U2@REF)", "at(U1@WALL, 2e-5)", "norm(S22, EXPR in r, z, t)".
    #[arg(long, allow_hyphen_values = true)]
    quantity: String,
    /// The exact value, a number or an expression.
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    exact: Option<String>,
    /// Error aimed at: refine until it is reached, such as 0.5% or 1e-6.
    #[arg(long, value_name = "ERROR")]
    target: Option<String>,
    /// Leave out each effect in turn: which of them the scene calls for. --refine then says how the error is estimated
    /// (default increment=1,0.5).
    #[arg(long, conflicts_with_all = ["exact", "target"])]
    ablate: bool,
    /// Replace the value of a *PARAMETER: NAME=VALUE.
    #[arg(short, long = "set", value_name = "NAME=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    user: UserFiles,
    /// Folder for table, JSON and pictures (default out/<deck name>).
    #[arg(short, long)]
    out: Option<PathBuf>,
    /// How often each setting runs; its time is the median.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,
    /// Print the record of the study, which is `<job>_study.json`, and nothing else.
    #[arg(long, conflicts_with = "ablate")]
    json: bool,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
}

impl Study {
    /// Carries it out.
    pub fn execute(self) -> Result<Status, Box<dyn Error>> {
        let quantity = Quantity::parse(&self.quantity)?;
        let exact = asked::exact(self.exact.as_deref(), &quantity)?;
        if self.ablate && quantity.compares_fields() {
            return Err("--ablate: effects are left out of a number; give the norm an expression".into());
        }
        let target = self.target.as_deref().map(Target::parse).transpose()?;
        let overrides = pairs(&self.set)?;
        let Some(compiled) = self.user.compiled(self.quiet || self.json) else { return Ok(Status::from(REFUSED)) };
        let routines = Compiled::open_any(compiled.as_ref()).map_err(|fault| fault.message)?;
        let first = job::prepare(&self.deck, &overrides, &routines);
        if !accepted(&first, self.quiet || self.json) {
            return Ok(Status::from(REFUSED));
        }
        let parameters: Vec<String> = first.deck.parameters.iter().map(|p| p.0.clone()).collect();
        let axes = settings::axes(&self.refine, &parameters)?;
        let axes = if axes.is_empty() && self.ablate { effects::default_axes()? } else { axes };
        check_axes(&axes, exact)?;
        let model = model::build(&deck::read(&self.deck, &overrides).0).0;
        settings::check(&axes, &model)?;
        quantity.check(&first.plan)?;
        drop(first);
        let Some((job, _lock)) = folder_of(&self.deck, self.out.clone())? else { return Ok(Status::from(REFUSED)) };
        let source = |overrides: &job::Overrides| deck::read(&self.deck, overrides);
        let runs = axes.iter().map(|a| a.values.len()).product::<usize>() * self.repeat as usize;
        let bar = progress::over_runs(runs as u64, self.quiet);
        let done = || bar.inc(1);
        // Started here, where it can be said that there are none to be had.
        rayon::ThreadPoolBuilder::new().build_global().map_err(|e| format!("cannot start threads: {e}"))?;
        let mut bench = Bench::new(&source, &overrides, compiled.as_ref(), &quantity, self.repeat as usize, &done);
        if self.ablate {
            let effects = effects::leave_out(&mut bench, &axes, &model)?;
            bar.finish_and_clear();
            return write_effects(&job, &quantity, &effects, self.quiet);
        }
        let (results, met, timing) = asked::refine(&mut bench, &axes, exact, target)?;
        bar.finish_and_clear();
        let record = write(&job, &quantity, exact, &results, met.clone(), timing)?;
        if self.json {
            say!("{}", record.trim_end());
        } else if !self.quiet {
            print(&results, met.as_ref(), timing, &job);
        }
        tell_doubts(&doubts(&axes, &results));
        Ok(verdict(&results, met.as_ref()))
    }
}

/// Whether anything converges, or is compared with what is known.
fn check_axes(axes: &[Axis], exact: Option<f64>) -> Result<(), Box<dyn Error>> {
    if axes.is_empty() {
        return Err("what is to be refined? give --refine NAME=v1,v2,…".into());
    }
    if exact.is_none() && !axes.iter().any(Axis::is_refinement) {
        return Err("choices alone show no error: give --exact, or --refine with levels".into());
    }
    Ok(())
}

/// Table and JSON of effects left out.
fn write_effects(
    job: &output::Job,
    quantity: &Quantity,
    effects: &Effects,
    quiet: bool,
) -> Result<Status, Box<dyn Error>> {
    let (header, rows) = effects.sheet(true);
    let record = record::ablation(&quantity.text, effects);
    write_files(job, vec![table_file(&header, &rows), record_file(&record)?])?;
    if !quiet {
        let (header, rows) = effects.sheet(false);
        words::write(format_args!("{}", table::terminal(&header, &rows)), false);
        effects.conclusions().iter().for_each(|line| say!("{line}"));
        say!("table {}", job.path("_study.csv").display());
    }
    Ok(Status::SUCCESS)
}

/// Files of a study; gives its record.
fn write(
    job: &output::Job,
    quantity: &Quantity,
    exact: Option<f64>,
    results: &Results,
    met: Option<Met>,
    timing: Timing,
) -> Result<String, Box<dyn Error>> {
    let (header, rows) = record::sheet(results, true);
    let record = record_file(&record::record(&quantity.text, exact, results, met, timing))?;
    let text = String::from_utf8_lossy(&record.1).into_owned();
    let title = format!("{}: {}", job.name, quantity.text);
    let mut files = vec![table_file(&header, &rows), record];
    files.extend(drawn("_study", &record::price_chart(results, &title))?);
    files.extend(drawn("_study_order", &record::order_chart(results, &title))?);
    write_files(job, files)?;
    Ok(text)
}

/// Ending and bytes of a file.
type File = (String, Vec<u8>);

fn table_file(header: &[String], rows: &[Vec<String>]) -> File {
    ("_study.csv".into(), table::csv(header, rows).into_bytes())
}

fn record_file(record: &impl serde::Serialize) -> Result<File, Box<dyn Error>> {
    let text = serde_json::to_string_pretty(record).map_err(|e| e.to_string())? + "\n";
    Ok(("_study.json".into(), text.into_bytes()))
}

/// A chart as SVG and PNG, where there is something to draw.
fn drawn(ending: &str, chart: &Chart) -> Result<Vec<File>, Box<dyn Error>> {
    if chart.series.iter().all(|s| s.points.is_empty()) {
        return Ok(Vec::new());
    }
    let svg = (format!("{ending}.svg"), chart.svg_on(Scale::LogLog)?.into_bytes());
    Ok(vec![svg, (format!("{ending}.png"), chart.png_on(Scale::LogLog)?)])
}

fn write_files(job: &output::Job, files: Vec<File>) -> Result<(), Box<dyn Error>> {
    Ok(output::write_with_sums(job, &files, "_study.sfv").map_err(|e| e.to_string())?)
}

fn print(results: &Results, met: Option<&Met>, timing: Timing, job: &output::Job) {
    let (header, rows) = record::sheet(results, false);
    words::write(format_args!("{}", table::terminal(&header, &rows)), false);
    for line in record::conclusions(results, met) {
        say!("{line}");
    }
    say!(
        "{} settings, each run {} times: {:.3} s, {:.1} % of it beside the runs; table {}, picture {}",
        results.rows.len(),
        timing.repeat,
        timing.total,
        100.0 * (timing.total - timing.runs) / timing.total,
        job.path("_study.csv").display(),
        job.path("_study.png").display()
    );
}

/// Each setting, and what is to be known of its run.
fn doubts<'a>(axes: &[Axis], results: &'a Results) -> Vec<(String, &'a [String])> {
    let names = || axes.iter().map(|axis| &axis.name[..]);
    let of_row = |row: &'a Row| Some((given(names().zip(&row.values)), &row.run.as_ref().ok()?.doubts[..]));
    results.rows.iter().filter_map(of_row).collect()
}

fn verdict(results: &Results, met: Option<&Met>) -> Status {
    let failed: Vec<&StudyError> = results.rows.iter().filter_map(|r| r.run.as_ref().err()).collect();
    if let Some(reason) = failed.first() {
        tell!("{} of {} settings gave no result; the first:\n{reason}", failed.len(), results.rows.len());
        return Status::from(HALTED);
    }
    if met.is_some_and(|m| m.run.is_none()) { Status::from(HALTED) } else { Status::SUCCESS }
}
