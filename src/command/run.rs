//! `revolve run`.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use clap::Args;
use revolve::deck::{Diagnostic, Diagnostics, Sources, printable};
use revolve::job::Instructions;
use revolve::job::{self, Options, Prepared, Refusal, Summary};
use revolve::model::Precision;
use revolve::output;
use revolve::output::checkpoint::Checkpoint;
use revolve::solve::Every;
use revolve::user::host;

use super::signals::watch_signals;
use super::words::{say, tell};
use super::{HALTED, REFUSED, UserFiles, accepted, pairs, print_findings, progress_bar};

/// Stack of a thread, bytes: routines of the user may keep large arrays there, as in a main thread.
const STACK: usize = 64 << 20;

/// Run a deck and write frames, histories and a summary.
#[derive(Args)]
pub struct Run {
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
    /// Go on from the checkpoint in the folder of the results, to the same bits; without one start at the beginning.
    #[arg(long)]
    resume: bool,
    /// Keep the state every so often: 10s, 5m or 1h on the clock, or a number of increments.
    #[arg(long, value_name = "TIME|INCREMENTS", value_parser = every)]
    checkpoint_every: Option<Every>,
    /// Threads (default: all cores); results have the same bits on any number.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Instruction set for deformable elements: scalar, avx2 or avx512 (default: the machine's best); results have the same
    /// bits on all.
    #[arg(long, value_name = "SET")]
    instructions: Option<Instructions>,
    /// Precision of solid elements: double or single, which is faster and has half the digits; nodes, sums and energies are in
    /// double precision.
    #[arg(long, value_name = "DIGITS", default_value = "double")]
    precision: Precision,
    /// Print nothing but errors.
    #[arg(long)]
    quiet: bool,
}

/// Seconds, minutes, hours or increments.
fn every(text: &str) -> Result<Every, String> {
    let wrong = || "10s, 5m, 1h or a number of increments above zero".to_owned();
    if let Ok(increments) = text.parse::<u64>() {
        return if increments > 0 { Ok(Every::Increments(increments)) } else { Err(wrong()) };
    }
    let unit =
        text.chars().last().and_then(|unit| [('s', 1.0), ('m', 60.0), ('h', 3600.0)].into_iter().find(|u| u.0 == unit));
    let (unit, factor) = unit.ok_or_else(wrong)?;
    let seconds: f64 = text.trim_end_matches(unit).parse().map_err(|_| wrong())?;
    let time = Duration::try_from_secs_f64(factor * seconds).map_err(|_| wrong())?;
    if time > Duration::ZERO { Ok(Every::Elapsed(time)) } else { Err(wrong()) }
}

impl Run {
    /// Carries it out.
    pub fn execute(self) -> Result<ExitCode, Box<dyn Error>> {
        let pool = rayon::ThreadPoolBuilder::new().stack_size(STACK);
        let pool = pool.num_threads(self.threads.map_or(0, Into::into));
        pool.build_global().map_err(|e| format!("cannot start threads: {e}"))?;
        let Some((routines, user)) = self.user.opened(self.quiet) else { return Ok(ExitCode::from(REFUSED)) };
        let mut prepared = job::prepare_in(self.precision, &self.deck, &pairs(&self.set)?, &routines);
        if !accepted(&prepared, self.quiet) {
            return Ok(ExitCode::from(REFUSED));
        }
        if let Some(instructions) = self.instructions {
            prepared.use_instructions(instructions)?;
        }
        let job = match job::default_job(&self.deck, self.out.clone()) {
            Ok(job) => job,
            Err(finding) => return Ok(refused(*finding)),
        };
        if self.checkpoint_every.is_some() && !user.is_empty() && !self.quiet {
            print_finding(job::forgotten(false));
        }
        let from = match self.checkpoint(&prepared, &job, &user) {
            Ok(from) => from,
            Err(finding) => return Ok(refused(*finding)),
        };
        if !self.quiet {
            say!("{}", prepared.plan.ledger.render());
        }
        let signal = watch_signals()?;
        // Only once: the state itself, which may be large, and not a copy.
        let state = Some(std::mem::take(&mut prepared.state));
        let options =
            Options { every: self.checkpoint_every, interrupt: Some(&*signal), from, state, user, warn: None };
        let summary = match run(&prepared, &job, options, self.quiet) {
            Ok(summary) => summary,
            Err(Refusal::Folder(e)) => return Err(e.into()),
            Err(Refusal::Checkpoint(finding)) => return Ok(refused(*finding)),
        };
        print_messages(&summary.messages, self.quiet);
        if !self.quiet {
            print_outcome(&summary, &job);
        }
        let signal = signal.load(std::sync::atomic::Ordering::Relaxed);
        let end = print_end(&summary, &job, signal);
        if summary.reason.as_ref().is_some_and(|reason| reason.starts_with("R201")) {
            revolve::user::library::leave(HALTED);
        }
        // The libraries stay until the process goes: a thread that a routine started may still run in one.
        std::mem::forget((prepared, routines));
        Ok(end)
    }

    /// The checkpoint to go on from, if there is one and it is asked for; notes are printed.
    fn checkpoint(
        &self,
        prepared: &Prepared,
        job: &output::Job,
        user: &str,
    ) -> Result<Option<Checkpoint>, Box<Diagnostic>> {
        if !self.resume {
            return Ok(None);
        }
        let (checkpoint, notes) = job::find_checkpoint(prepared, job, user)?;
        if !self.quiet {
            print_findings(&notes, &prepared.deck.sources);
        }
        Ok(checkpoint)
    }
}

fn print_finding(finding: Diagnostic) {
    let mut findings = Diagnostics::default();
    findings.push(finding);
    print_findings(&findings, &Sources::default());
}

fn refused(finding: Diagnostic) -> ExitCode {
    print_finding(finding);
    ExitCode::from(REFUSED)
}

fn run(prepared: &Prepared, job: &output::Job, options: Options<'_>, quiet: bool) -> Result<Summary, Refusal> {
    let bar = progress_bar(1000, quiet);
    let mut progress = |step: &str, fraction: f64, increment: u64| {
        bar.set_position((1000.0 * fraction) as u64);
        bar.set_message(format!("{}, increment {increment}", printable(step)));
    };
    let warn = |text: &str| {
        if !quiet {
            bar.suspend(|| tell!("warning: {text}"));
        }
    };
    let work = || job::run_with(prepared, job, Options { warn: Some(&warn), ..options }, &mut progress);
    // As one of the threads: from outside each pass over the elements would wait to be taken up.
    let summary = if rayon::current_num_threads() > 1 { rayon::scope(|_| work()) } else { work() };
    bar.finish_and_clear();
    summary
}

/// Says how it ended; the exit status is 0, that of a halt, or that of a signal as shells have it.
fn print_end(summary: &Summary, job: &output::Job, signal: usize) -> ExitCode {
    let Some(reason) = &summary.reason else { return ExitCode::SUCCESS };
    tell!("halted: {reason}\nthe last good state is in {}", job.path(".pvd").display());
    if !summary.interrupted {
        return ExitCode::from(HALTED);
    }
    tell!("go on with --resume");
    ExitCode::from(128 + signal as u8)
}

/// What the user's routines had to say.
fn print_messages(messages: &[host::Message], quiet: bool) {
    for message in messages.iter().filter(|m| !quiet || m.level == host::Level::Error) {
        let level = format!("{:?}", message.level).to_lowercase();
        let times = if message.times > 1 { format!(" ({} times)", message.times) } else { String::new() };
        tell!("{level} from the user's routine: {}{times}", message.text);
    }
}

/// History columns that are printed after a run.
const SHOWN: usize = 24;

fn print_outcome(summary: &Summary, job: &output::Job) {
    if summary.ended_by_user {
        say!("the user's routine ended the analysis");
    }
    for rest in &summary.rests {
        say!("{} came to rest at time {:.6e}, displacement {:.6e}", rest.body, rest.time, rest.displacement);
    }
    for (name, column) in summary.history.0.iter().take(SHOWN) {
        say!("{name}: final {:.6e}, min {:.6e}, max {:.6e}", column.last, column.min, column.max);
    }
    if summary.history.0.len() > SHOWN {
        say!("… and {} more columns in {}", summary.history.0.len() - SHOWN, job.path("_history.csv").display());
    }
    for step in summary.steps.iter().filter(|s| s.limiting_element.is_some()) {
        let element = step.limiting_element.as_deref().unwrap_or_default();
        let by = match step.global_estimates {
            Some(count) => format!(", global estimate made {count} times"),
            None => String::new(),
        };
        say!("{}: smallest increment {:.3e}, limited by element {element}{by}", step.name, step.smallest_increment);
    }
    say!("energy drift {:.1e} of the largest energy", summary.energy.drift);
    if let Some(increment) = summary.timing.resumed_at {
        say!("went on from increment {increment}");
    }
    if let Some(seconds) = summary.timing.checkpoint_seconds {
        say!("checkpoints: {:.2} % of the time", 100.0 * seconds / summary.timing.seconds);
    }
    say!("digest {}", summary.digest);
    for row in summary.ledger.effects.iter().filter(|r| r.share.is_some()) {
        say!("{}: {:.0} % of the time", row.effect, 100.0 * row.share.unwrap_or(0.0));
    }
    say!(
        "{} increments in {:.3} ms, results in {}",
        summary.timing.increments,
        1e3 * summary.timing.seconds,
        job.path(".pvd").display()
    );
}
