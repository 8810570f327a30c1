//! `revolve study`.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant as Stopwatch;

use clap::Args;
use revolve::deck::expression::Expression;
use revolve::study::StudyError;
use revolve::study::bench::Bench;
use revolve::study::chart::{Chart, Scale};
use revolve::study::effects::{self, Effects};
use revolve::study::measure::Measure;
use revolve::study::record::{self, Timing};
use revolve::study::refinement::{self, Study as Results};
use revolve::study::settings::{self, Axis};
use revolve::study::table;
use revolve::study::target::{self, Met, Target};
use revolve::user::compile::Compiled;
use revolve::{deck, job, model, output};

use super::words::{self, say, tell};
use super::{HALTED, REFUSED, UserFiles, accepted, pairs, progress_bar};

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
    #[arg(long = "set", value_name = "NAME=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    user: UserFiles,
    /// Folder for table, JSON and pictures (default out/<deck name>).
    #[arg(long)]
    out: Option<PathBuf>,
    /// How often each setting runs; its time is the median.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,
    /// Print nothing but errors.
    #[arg(long)]
    quiet: bool,
}

impl Study {
    /// Carries it out.
    pub fn execute(self) -> Result<ExitCode, Box<dyn Error>> {
        let measure = Measure::parse(&self.quantity)?;
        let exact = self.exact(&measure)?;
        if self.ablate && measure.compares_fields() {
            return Err("--ablate: effects are left out of a number; give the norm an expression".into());
        }
        let target = self.target.as_deref().map(Target::parse).transpose()?;
        let overrides = pairs(&self.set)?;
        let Some(compiled) = self.user.compiled(self.quiet) else { return Ok(ExitCode::from(REFUSED)) };
        let routines = Compiled::open_any(compiled.as_ref()).map_err(|fault| fault.message)?;
        let first = job::prepare(&self.deck, &overrides, &routines);
        if !accepted(&first, self.quiet) {
            return Ok(ExitCode::from(REFUSED));
        }
        let parameters: Vec<String> = first.deck.parameters.iter().map(|p| p.0.clone()).collect();
        let axes = settings::axes(&self.refine, &parameters)?;
        let axes = if axes.is_empty() && self.ablate { effects::default_axes()? } else { axes };
        check_axes(&axes, exact)?;
        let model = model::build(&first.deck).0;
        settings::check(&axes, &model)?;
        measure.check(&first.plan)?;
        drop(first);
        let source = |overrides: &job::Overrides| deck::read(&self.deck, overrides);
        let runs = axes.iter().map(|a| a.values.len()).product::<usize>() * self.repeat as usize;
        let bar = progress_bar(runs as u64, self.quiet);
        let done = || bar.inc(1);
        let mut bench = Bench::new(&source, &overrides, compiled.as_ref(), &measure, self.repeat as usize, &done);
        let job = job::default_job(&self.deck, self.out.clone()).map_err(|finding| finding.message)?;
        if self.ablate {
            let effects = effects::leave_out(&mut bench, &axes, &model)?;
            bar.finish_and_clear();
            return write_effects(&job, &measure, &effects, self.quiet);
        }
        let begin = Stopwatch::now();
        let (results, met) = match target {
            Some(target) => {
                let (results, met) = target::reach(&mut bench, &axes, exact, target)?;
                (results, Some(met))
            }
            None => (refinement::grid(&mut bench, &axes, exact)?, None),
        };
        bar.finish_and_clear();
        let timing = Timing { runs: bench.spent(), total: begin.elapsed().as_secs_f64(), repeat: bench.repeat() };
        write(&job, &measure, exact, &results, met.clone(), timing)?;
        if !self.quiet {
            print(&results, met.as_ref(), timing, &job);
        }
        Ok(verdict(&results, met.as_ref()))
    }

    /// The exact value; of a norm against an expression it is zero.
    fn exact(&self, measure: &Measure) -> Result<Option<f64>, Box<dyn Error>> {
        let Some(text) = &self.exact else {
            return Ok((measure.is_norm() && !measure.compares_fields()).then_some(0.0));
        };
        if measure.compares_fields() {
            return Err(
                "--exact: a norm against the finest level has no exact value; give the norm an expression".into()
            );
        }
        let value = Expression::parse(text).and_then(|e| e.evaluate(&|_| None, &|_, _| None));
        Ok(Some(value.map_err(|e| format!("--exact `{text}`: {}", e.message))?))
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
    measure: &Measure,
    effects: &Effects,
    quiet: bool,
) -> Result<ExitCode, Box<dyn Error>> {
    make_folder(job)?;
    let write =
        |ending: &str, text: &str| output::write_whole(&job.path(ending), text.as_bytes()).map_err(|e| e.to_string());
    let (header, rows) = effects.sheet(true);
    write("_study.csv", &table::csv(&header, &rows))?;
    let record = record::ablation(&measure.text, effects);
    write("_study.json", &(serde_json::to_string_pretty(&record).map_err(|e| e.to_string())? + "\n"))?;
    if !quiet {
        let (header, rows) = effects.sheet(false);
        words::write(format_args!("{}", table::terminal(&header, &rows)), false);
        effects.conclusions().iter().for_each(|line| say!("{line}"));
        say!("table {}", job.path("_study.csv").display());
    }
    Ok(ExitCode::SUCCESS)
}

fn make_folder(job: &output::Job) -> Result<(), String> {
    std::fs::create_dir_all(&job.folder).map_err(|e| format!("cannot make the folder {}: {e}", job.folder.display()))
}

/// Files of a study.
fn write(
    job: &output::Job,
    measure: &Measure,
    exact: Option<f64>,
    results: &Results,
    met: Option<Met>,
    timing: Timing,
) -> Result<(), Box<dyn Error>> {
    make_folder(job)?;
    let write = |ending: &str, bytes: &[u8]| output::write_whole(&job.path(ending), bytes).map_err(|e| e.to_string());
    let (header, rows) = record::sheet(results, true);
    write("_study.csv", table::csv(&header, &rows).as_bytes())?;
    let record = record::record(&measure.text, exact, results, met, timing);
    let text = serde_json::to_string_pretty(&record).map_err(|e| e.to_string())? + "\n";
    write("_study.json", text.as_bytes())?;
    let title = format!("{}: {}", job.name, measure.text);
    draw(job, "_study", &record::price_chart(results, &title))?;
    draw(job, "_study_order", &record::order_chart(results, &title))
}

/// A chart as SVG and PNG, where there is something to draw.
fn draw(job: &output::Job, ending: &str, chart: &Chart) -> Result<(), Box<dyn Error>> {
    if chart.series.iter().all(|s| s.points.is_empty()) {
        return Ok(());
    }
    let write = |kind: &str, bytes: &[u8]| {
        output::write_whole(&job.path(&format!("{ending}.{kind}")), bytes).map_err(|e| e.to_string())
    };
    write("svg", chart.svg_on(Scale::LogLog)?.as_bytes())?;
    Ok(write("png", &chart.png_on(Scale::LogLog)?)?)
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

fn verdict(results: &Results, met: Option<&Met>) -> ExitCode {
    let failed: Vec<&StudyError> = results.rows.iter().filter_map(|r| r.run.as_ref().err()).collect();
    if let Some(reason) = failed.first() {
        tell!("{} of {} settings gave no result; the first:\n{reason}", failed.len(), results.rows.len());
        return ExitCode::from(HALTED);
    }
    if met.is_some_and(|m| m.run.is_none()) { ExitCode::from(HALTED) } else { ExitCode::SUCCESS }
}
