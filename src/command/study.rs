//! `revolve study`.

use std::error::Error;
use std::path::PathBuf;

use crate::output::Job;
use crate::study::StudyError;
use crate::study::convergence;
use crate::study::effects::{self, Effects};
use crate::study::quantity::Quantity;
use crate::study::record::{self, StudyTiming};
use crate::study::refinement::{Study as Results, StudyRow};
use crate::study::runner::StudyRunner;
use crate::study::settings::{self, Axis};
use crate::study::target::{Target, TargetResult};
use crate::user::compile::Compiled;
use crate::{deck, job, model};
use clap::Args;

use super::words::{say, tell};
use super::{
    File, HALTED, Status, UserFiles, accept, given, lock_job, pairs, print_table, progress, tell_doubts, write_results,
};

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
    pub fn execute(self) -> Result<Status, Box<dyn Error>> {
        let quantity = Quantity::parse(&self.quantity)?;
        let exact = convergence::exact(self.exact.as_deref(), &quantity)?;
        if self.ablate && quantity.compares_fields() {
            return Err("--ablate: effects are left out of a number; give the norm an expression".into());
        }
        let target = self.target.as_deref().map(Target::parse).transpose()?;
        let overrides = pairs(&self.set)?;
        let compiled = self.user.compiled(self.quiet || self.json)?;
        let routines = Compiled::open_any(compiled.as_ref())?;
        let first = job::prepare(&self.deck, &overrides, &routines);
        accept(&first, self.quiet || self.json)?;
        let parameters: Vec<String> = first.deck.parameters.iter().map(|p| p.0.clone()).collect();
        let axes = settings::axes(&self.refine, &parameters)?;
        let axes = if axes.is_empty() && self.ablate { effects::default_axes()? } else { axes };
        check_axes(&axes, exact)?;
        let model = model::build(&deck::read(&self.deck, &overrides).0).0;
        settings::check(&axes, &model)?;
        quantity.check(&first.plan)?;
        drop(first);
        let (job, _lock) = lock_job(&self.deck, self.out.clone())?;
        let source = |overrides: &job::Overrides| deck::read(&self.deck, overrides);
        let runs = axes.iter().map(|a| a.values.len()).product::<usize>() * self.repeat as usize;
        let bar = progress::over_runs(runs as u64, self.quiet);
        let done = || bar.inc(1);
        // Started here, where it can be said that there are none to be had.
        rayon::ThreadPoolBuilder::new().build_global().map_err(|e| format!("cannot start threads: {e}"))?;
        let mut bench =
            StudyRunner::new(&source, &overrides, compiled.as_ref(), &quantity, self.repeat as usize, &done);
        if self.ablate {
            let effects = effects::leave_out(&mut bench, &axes, &model)?;
            bar.finish_and_clear();
            return write_effects(&job, &quantity, &effects, self.quiet);
        }
        let (results, met, timing) = convergence::refine(&mut bench, &axes, exact, target)?;
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

/// Writes and prints the table and the record of effects left out.
fn write_effects(job: &Job, quantity: &Quantity, effects: &Effects, quiet: bool) -> Result<Status, Box<dyn Error>> {
    let record = record_text(&record::ablation(&quantity.text, effects))?;
    write_results(job, "study", &effects.table(true), vec![record_file(record)], &[])?;
    if !quiet {
        print_table(&effects.table(false));
        effects.conclusions().iter().for_each(|line| say!("{line}"));
        say!("table {}", job.path("_study.csv").display());
    }
    Ok(Status::SUCCESS)
}

/// Writes the files of a study; gives its record.
fn write(
    job: &Job,
    quantity: &Quantity,
    exact: Option<f64>,
    results: &Results,
    met: Option<TargetResult>,
    timing: StudyTiming,
) -> Result<String, Box<dyn Error>> {
    let record = record_text(&record::record(&quantity.text, exact, results, met, timing))?;
    let title = format!("{}: {}", job.name, quantity.text);
    let charts = [
        (String::new(), record::price_chart(results, &title)),
        ("_order".to_owned(), record::order_chart(results, &title)),
    ];
    write_results(job, "study", &record::table(results, true), vec![record_file(record.clone())], &charts)?;
    Ok(record)
}

fn record_text(record: &impl serde::Serialize) -> Result<String, serde_json::Error> {
    Ok(serde_json::to_string_pretty(record)? + "\n")
}

fn record_file(text: String) -> File {
    ("_study.json".into(), text.into_bytes())
}

fn print(results: &Results, met: Option<&TargetResult>, timing: StudyTiming, job: &Job) {
    print_table(&record::table(results, false));
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
    let of_row = |row: &'a StudyRow| Some((given(names().zip(&row.values)), &row.run.as_ref().ok()?.doubts[..]));
    results.rows.iter().filter_map(of_row).collect()
}

fn verdict(results: &Results, met: Option<&TargetResult>) -> Status {
    let failed: Vec<&StudyError> = results.rows.iter().filter_map(|r| r.run.as_ref().err()).collect();
    if let Some(reason) = failed.first() {
        tell!("{} of {} settings gave no result; the first:\n{reason}", failed.len(), results.rows.len());
        return Status::from(HALTED);
    }
    if met.is_some_and(|m| m.run.is_none()) { Status::from(HALTED) } else { Status::SUCCESS }
}
