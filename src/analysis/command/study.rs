//! The command `revolve study`: convergence and ablation studies.

use std::error::Error;
use std::path::PathBuf;

use crate::output::JobFiles;
use crate::output::checkpoint::hash;
use crate::output::clock::seconds;
use crate::overview;
use crate::report::QuantityLabels;
use crate::study::StudyError;
use crate::study::causes;
use crate::study::chosen;
use crate::study::convergence::{self, RefinementRequest};
use crate::study::effects::{self, EffectAblation};
use crate::study::jitter::NoiseRequest;
use crate::study::map::measure::measure;
use crate::study::quantity::Quantity;
use crate::study::record::{self, CompletedStudy};
use crate::study::refinement::{RefinementStudy, StudyRow};
use crate::study::runner::StudyRunner;
use crate::study::settings::{self, StudyAxis};
use crate::study::target::ErrorTarget;
use crate::user::compile::Compiled;
use crate::{deck, job, model};
use clap::Args;

use super::map::{self, MapOptions};
use super::options::{CurvedOption, OutputOptions, ResultOptions, ResumeOption, SetOption};
use super::words::{print_err, print_out};
use super::{
    CommandStatus, ResultFile, UserFiles, accept, print_run_warnings, print_table, progress, report_failures,
    settings_text, write_results,
};

/// Convergence study: refine a deck and report the observed order, the error and the run time for a given accuracy.
#[derive(Args)]
pub struct StudyCommand {
    /// Input deck.
    #[arg(value_parser = super::options::deck_parser())]
    deck: PathBuf,
    /// Values from coarse to fine of a deck parameter or of mesh (parts of each edge; 1/2 merges elements), increment
    /// (factors), load-velocity, hourglass or estimate: NAME=v1,v2,…; several options form a grid.
    #[arg(long, value_name = "NAME=VALUES")]
    refine: Vec<String>,
    /// Study the mesh around that of the deck: coarser meshes first (1/4, 1/2), a finer one only if the order is not
    /// confirmed.
    #[arg(long, conflicts_with_all = ["refine", "target", "ablate"])]
    around: bool,
    /// Quantity to study: an expression over histories and norms, for example "-1000*final(U2@REF)", "at(U1@WALL,
    /// 2e-5)" or "norm(S22, EXPR in r, z, t)".
    #[arg(long, allow_hyphen_values = true)]
    quantity: String,
    /// Exact value of the quantity: a number or an expression.
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    exact: Option<String>,
    /// Refine until the error is below this value, for example 0.5% (relative) or 1e-6 (absolute).
    #[arg(long, value_name = "ERROR")]
    target: Option<String>,
    /// Number of runs with small perturbations of initial velocities and nodal coordinates, from which the noise of the
    /// quantity follows (default: 8 runs if the deck has contact, failure, element deletion or new meshes; 0 omits them).
    #[arg(long, value_name = "N", conflicts_with = "ablate")]
    jitter: Option<u16>,
    /// Omit one effect at a time and report which effects change the quantity by more than its error. --refine then
    /// controls the error estimate (default: increment=1,0.5).
    #[arg(long, conflicts_with_all = ["exact", "target"])]
    ablate: bool,
    #[command(flatten)]
    map: MapOptions,
    #[command(flatten)]
    set: SetOption,
    #[command(flatten)]
    curved: CurvedOption,
    #[command(flatten)]
    user: UserFiles,
    #[command(flatten)]
    results: ResultOptions,
    /// Number of runs of each setting; the reported time is the median.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeat: u32,
    #[command(flatten)]
    resume: ResumeOption,
    #[command(flatten)]
    output: OutputOptions,
}

impl StudyCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let quantity = Quantity::parse(&self.quantity)?;
        let exact = convergence::exact(self.exact.as_deref(), &quantity)?;
        if self.ablate && quantity.compares_fields() {
            return Err("--ablate needs a number as quantity: give the norm an expression, norm(VARIABLE, EXPR)".into());
        }
        let target = self.target.as_deref().map(ErrorTarget::parse).transpose()?;
        let mut overrides = self.set.pairs()?;
        overrides.extend(self.curved.setting());
        let labels = self.results.labels.checked([quantity.text.as_str()])?;
        let compiled = self.user.compiled(self.output.is_silent())?;
        let routines = Compiled::open_any(compiled.as_ref())?;
        let first = job::prepare(&self.deck, &overrides, &routines);
        accept(&first.diagnostics, &first.deck.sources, self.output.is_silent())?;
        let parameters: Vec<String> = first.deck.parameters.iter().map(|p| p.0.clone()).collect();
        let axes = settings::axes(&self.map.default_levels(&self.refine), &parameters)?;
        let source = |overrides: &job::ParameterOverrides| deck::read(&self.deck, overrides);
        let axes = match (self.ablate, self.around) {
            (true, _) if axes.is_empty() => effects::default_axes()?,
            (_, true) => chosen::mesh_axes(&source, &overrides)?,
            _ => axes,
        };
        check_axes(&axes, exact)?;
        let model = model::build(&deck::read(&self.deck, &overrides).0).0;
        settings::check(&axes, &model)?;
        quantity.check(&first.plan)?;
        let identity = self.identity(&first, &axes, compiled.as_ref());
        let (job, _lock) = self.results.lock_job(&self.deck)?;
        let log = self.resume.log(&job)?;
        // The thread pool is created here, where a failure can be reported.
        self.results.threads.start()?;
        if !self.output.is_silent() {
            print_out!("{}", self.describe_plan(&first, &axes));
        }
        drop(first);
        let runs = axes.iter().map(|a| a.values.len()).product::<usize>() * self.repeat as usize;
        let bar = progress::over_runs(runs as u64, self.output.quiet.quiet);
        let count_run = || bar.inc(1);
        let mut bench =
            StudyRunner::new(&source, &overrides, compiled.as_ref(), &quantity, self.repeat as usize, &count_run);
        bench.logged(&log, identity);
        if self.ablate {
            let effects = effects::leave_out(&mut bench, &axes, &model)?;
            bar.finish_and_clear();
            let status = write_effects(&job, &quantity, &effects, self.output)?;
            self.resume.end(&log, self.output.is_silent());
            return Ok(status);
        }
        let quiet = self.output.is_silent();
        let announce = |line: &str| {
            if !quiet {
                bar.suspend(|| print_out!("{line}"));
            }
        };
        let request = RefinementRequest {
            axes: &axes,
            exact,
            target,
            noise: NoiseRequest::new(self.jitter.map(usize::from), &model),
            causes: causes::limits_of_order(&model),
            announce: &announce,
            around: self.around,
        };
        let completed = convergence::refine(&mut bench, &request)?;
        let measured = if self.map.map {
            let count = self.map.map_regions.map(usize::from);
            Some(measure(&bench, &axes, &completed.study, count)?)
        } else {
            None
        };
        bar.finish_and_clear();
        let record = write(&job, (&quantity, labels.of(&quantity.text)), exact, &completed)?;
        self.resume.end(&log, quiet);
        if self.output.json {
            print_out!("{}", record.trim_end());
        } else if !quiet {
            print(&completed, &quantity, &job);
        }
        if let Some(measured) = &measured {
            map::write(&job, measured, &format!("{}: {}", job.name, labels.of(&quantity.text)))?;
            map::print(&job, &measured.map, self.output);
        }
        print_run_warnings(&run_warnings(&axes, &completed.study));
        completed.study.reversed_series().iter().for_each(|sentence| print_err!("warning: {sentence}"));
        Ok(verdict(&completed))
    }
}

impl StudyCommand {
    /// Describes the number of runs, and the time that they need if the run time follows from elements and increments.
    fn describe_plan(&self, first: &job::PreparedJob, axes: &[StudyAxis]) -> String {
        let settings: usize = axes.iter().map(|axis| axis.values.len()).product();
        let costs = axes
            .iter()
            .map(|axis| axis.values.iter().map(|value| axis.relative_cost(value, &first.deck.parameters)).sum::<f64>());
        let runs = settings * self.repeat as usize;
        let cost = costs.product::<f64>() * f64::from(self.repeat);
        let trial = overview::measure(&first.plan, first.state.clone(), overview::COUNTING_SHARE);
        let time = trial.map_or(String::new(), |trial| format!(", about {}", seconds(cost * trial.seconds)));
        format!("plan: {settings} settings, {runs} runs{time}")
    }

    /// Returns the hash of everything on which the runs and their order depend.
    fn identity(&self, first: &job::PreparedJob, axes: &[StudyAxis], compiled: Option<&Compiled>) -> String {
        let user = compiled.map(Compiled::identity).unwrap_or_default();
        let modes = (self.ablate, self.around, self.repeat, self.jitter);
        let options = (&self.quantity, &self.exact, &self.target);
        let version = env!("CARGO_PKG_VERSION");
        hash([format!("{:?} {axes:?} {options:?} {modes:?} {version}", first.identity(&user)).as_bytes()])
    }
}

/// Checks that an error can be estimated: by levels of refinement or by an exact value.
fn check_axes(axes: &[StudyAxis], exact: Option<f64>) -> Result<(), Box<dyn Error>> {
    if axes.is_empty() {
        return Err("no parameter to refine: give --refine NAME=v1,v2,…".into());
    }
    if exact.is_none() && !axes.iter().any(StudyAxis::is_refinement) {
        return Err(
            "no error can be estimated from options without levels: give --exact, or --refine with numeric levels"
                .into(),
        );
    }
    Ok(())
}

/// Writes and prints the table and the record of an effect ablation.
fn write_effects(
    job: &JobFiles,
    quantity: &Quantity,
    effects: &EffectAblation,
    output: OutputOptions,
) -> Result<CommandStatus, Box<dyn Error>> {
    let record = record_text(&record::ablation(&quantity.text, effects))?;
    let files = vec![record_file(record.clone())];
    write_results(job, "study", &effects.table(true), files, &[], &QuantityLabels::default())?;
    if output.json {
        print_out!("{}", record.trim_end());
    } else if !output.is_silent() {
        print_table(&effects.table(false));
        effects.conclusions().iter().for_each(|line| print_out!("{line}"));
        print_out!("table {}", job.path("_study.csv").display());
    }
    Ok(CommandStatus::SUCCESS)
}

/// Writes the files of a study and returns its record as JSON.
fn write(
    job: &JobFiles,
    (quantity, label): (&Quantity, &str),
    exact: Option<f64>,
    completed: &CompletedStudy,
) -> Result<String, Box<dyn Error>> {
    let record = record_text(&record::record(&quantity.text, exact, completed))?;
    let title = format!("{}: {label}", job.name);
    let results = &completed.study;
    let charts = [
        (String::new(), record::price_chart(results, &title)),
        ("_order".to_owned(), record::order_chart(results, &title)),
    ];
    write_results(
        job,
        "study",
        &record::table(results, true),
        vec![record_file(record.clone())],
        &charts,
        &QuantityLabels::default(),
    )?;
    Ok(record)
}

fn record_text(record: &impl serde::Serialize) -> Result<String, serde_json::Error> {
    Ok(serde_json::to_string_pretty(record)? + "\n")
}

fn record_file(text: String) -> ResultFile {
    ("_study.json".into(), text.into_bytes())
}

fn print(completed: &CompletedStudy, quantity: &Quantity, job: &JobFiles) {
    let (results, timing) = (&completed.study, completed.timing);
    print_table(&record::table(results, false));
    for line in record::conclusions(completed, &quantity.text) {
        print_out!("{line}");
    }
    print_out!(
        "{} settings, {} runs each: {:.3} s, {:.1} % outside the runs; table {}, picture {}",
        results.rows.len(),
        timing.repeat,
        timing.total,
        100.0 * (timing.total - timing.runs) / timing.total,
        job.path("_study.csv").display(),
        job.path("_study.png").display()
    );
}

/// Returns each setting with the warnings of its run.
fn run_warnings<'a>(axes: &[StudyAxis], results: &'a RefinementStudy) -> Vec<(String, &'a [String])> {
    let names = || axes.iter().map(|axis| &axis.name[..]);
    let of_row =
        |row: &'a StudyRow| Some((settings_text(names().zip(&row.values)), &row.run.as_ref().ok()?.warnings[..]));
    results.rows.iter().filter_map(of_row).collect()
}

fn verdict(CompletedStudy { study: results, target, .. }: &CompletedStudy) -> CommandStatus {
    let failed: Vec<&StudyError> = results.rows.iter().filter_map(|r| r.run.as_ref().err()).collect();
    let status = report_failures(failed.len(), results.rows.len(), "settings", failed.first().copied());
    if target.as_ref().is_some_and(|target| target.run.is_none()) { CommandStatus::HALTED } else { status }
}
