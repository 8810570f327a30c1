//! `revolve run`.

use std::error::Error;
use std::path::PathBuf;
use std::time::Duration;

use crate::deck::Diagnostic;
use crate::job::{self, Demand, Frames, Instructions, Options, Prepared, Refusal, Summary};
use crate::model::Precision;
use crate::output::checkpoint::Checkpoint;
use crate::output::{self, History, Points};
use crate::platform::signals::watch_signals;
use crate::solve::{Every, LOST, Progress};
use crate::study::quantity::{FinishedRun, Quantity};
use crate::user::host;
use clap::Args;
use indexmap::IndexMap;
use serde::Serialize;

use super::progress::{self, RunBar};
use super::words::{say, tell};
use super::{HALTED, Status, UserFiles, accept, outcome, pairs, print_findings, threads};

/// Stack of a thread, bytes: routines of the user may keep large arrays there, as in a main thread.
const STACK: usize = 64 << 20;

/// Run a deck and write frames, histories and a summary.
#[derive(Args)]
pub struct Run {
    /// The input deck.
    deck: PathBuf,
    /// Replace the value of a *PARAMETER: NAME=VALUE.
    #[arg(short, long = "set", value_name = "NAME=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    user: UserFiles,
    /// Run the user's routines in a process of their own: whatever they do to it, the run ends in order. All but vusdfld.
    #[arg(long, requires = "files")]
    isolate: bool,
    /// Folder for the results (default out/<deck name>).
    #[arg(short, long)]
    out: Option<PathBuf>,
    /// Go on from the checkpoint in the folder of the results, to the same bits; without one start at the beginning.
    #[arg(long)]
    resume: bool,
    /// As --resume, also from a checkpoint that does not hold all that the user's routines keep to themselves: that is then as
    /// in a run that starts anew.
    #[arg(long)]
    resume_anyway: bool,
    /// Keep the state every so often: 10s, 5m or 1h on the clock, or a number of increments.
    #[arg(long, value_name = "TIME|INCREMENTS", value_parser = every)]
    checkpoint_every: Option<Every>,
    /// Threads (default: all cores); results have the same bits on any number.
    #[arg(short, long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Instruction set for deformable elements: scalar, avx2 or avx512 (default: the machine's best); results have the same
    /// bits on all.
    #[arg(long, value_name = "SET")]
    instructions: Option<Instructions>,
    /// Precision of solid elements: double or single, which is faster and has half the digits; nodes, sums and energies are in
    /// double precision.
    #[arg(long, value_name = "DIGITS", default_value = "double")]
    precision: Precision,
    /// Print an expression over history columns, such as "-1000*final(U2@REF)"; may be given several times.
    #[arg(long, allow_hyphen_values = true)]
    quantity: Vec<String>,
    /// Print the summary as one JSON object, and nothing else.
    #[arg(long)]
    json: bool,
    /// Where frames have their points: where they are, or where they were at the start with U beside them, so that Warp By Vector
    /// shows the motion at any scale.
    #[arg(long, value_enum, default_value = "current", conflicts_with = "no_frames")]
    points: Points,
    /// Write no frames: histories and the summary alone.
    #[arg(long)]
    no_frames: bool,
    /// Print where the time went, effect by effect.
    #[arg(long)]
    profile: bool,
    /// Print nothing but errors.
    #[arg(short, long)]
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
    pub fn execute(self) -> Result<Status, Box<dyn Error>> {
        // Before there are threads: routines may get a process of their own.
        let (routines, user) = self.user.routines(self.is_silent(), self.isolate)?;
        let quantities = self.quantity.iter().map(|q| Quantity::parse(q)).collect::<Result<Vec<_>, _>>()?;
        let settings = pairs(&self.set)?;
        let reading = progress::over_reading(&self.deck, self.is_silent());
        let mut prepared = job::prepare_in(self.precision, &self.deck, &settings, &routines);
        reading.finish_and_clear();
        accept(&prepared, self.is_silent())?;
        self.start_threads(&prepared)?;
        for quantity in &quantities {
            quantity.stands_alone()?;
            quantity.check(&prepared.plan)?;
        }
        if let Some(instructions) = self.instructions {
            prepared.use_instructions(instructions)?;
        }
        let job = job::default_job(&self.deck, self.out.clone())?;
        let from = self.checkpoint(&prepared, &job, &user)?;
        if !self.is_silent() {
            say!("{}", prepared.plan.ledger.render(false));
        }
        let signal = watch_signals()?;
        // Only once: the state itself, which may be large, and not a copy.
        let state = Some(std::mem::take(&mut prepared.state));
        let frames = self.frames();
        let options =
            Options { every: self.checkpoint_every, interrupt: Some(&*signal), from, state, user, frames, warn: None };
        let summary = run(&prepared, &job, options, self.is_silent())?;
        print_messages(&summary.messages, self.is_silent());
        if !self.is_silent() {
            outcome::print(&summary, &job, frames, self.profile);
        }
        let values = values(&quantities, &summary.history);
        if self.json {
            print_json(&summary, &values)?;
        } else {
            values.iter().for_each(|(text, value)| print_value(text, value));
        }
        let signal = signal.load(std::sync::atomic::Ordering::Relaxed);
        let end = print_end(&summary, &job, frames, signal);
        if summary.reason.as_ref().is_some_and(|reason| reason.starts_with("R201")) {
            crate::user::crash::leave(HALTED);
        }
        // The libraries stay until the process goes: a thread that a routine started may still run in one.
        std::mem::forget((prepared, routines));
        Ok(end)
    }

    /// As many as there are cores, or as are asked for, and none without anything to do: it would be woken with each pass.
    fn start_threads(&self, prepared: &Prepared) -> Result<(), Box<dyn Error>> {
        let count = self.threads.map_or_else(threads::default, Into::into).min(prepared.most_threads());
        let pool = rayon::ThreadPoolBuilder::new().stack_size(STACK).num_threads(count);
        Ok(pool.build_global().map_err(|e| format!("cannot start threads: {e}"))?)
    }

    fn frames(&self) -> Frames {
        if self.no_frames { Frames::Absent } else { Frames::Written(self.points) }
    }

    /// Whether nothing but what was asked for is printed.
    fn is_silent(&self) -> bool {
        self.quiet || self.json
    }

    /// The checkpoint to go on from, if there is one and it is asked for; notes are printed.
    fn checkpoint(
        &self,
        prepared: &Prepared,
        job: &output::Job,
        user: &str,
    ) -> Result<Option<Checkpoint>, Box<Diagnostic>> {
        if !self.resume && !self.resume_anyway {
            return Ok(None);
        }
        let demand = if self.resume_anyway { Demand::Anything } else { Demand::Whole };
        let (checkpoint, mut notes) = job::find_checkpoint(prepared, job, user, demand)?;
        if self.is_silent() {
            // What is lost is said in any case.
            notes.retain(|note| note.code == "K102");
        }
        print_findings(&notes, &prepared.deck.sources);
        Ok(checkpoint)
    }
}

/// Quantities with their values, or why there is none.
type Values = IndexMap<String, Result<f64, String>>;

fn values(quantities: &[Quantity], history: &History) -> Values {
    let run = FinishedRun { history, end: None };
    let value = |q: &Quantity| (q.text.clone(), q.number(run).map_err(|e| e.to_string()));
    quantities.iter().map(value).collect()
}

fn print_value(text: &str, value: &Result<f64, String>) {
    match value {
        Ok(value) => say!("{text} = {value:?}"),
        Err(why) => tell!("error: {why}"),
    }
}

/// The summary with the quantities behind it.
#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    summary: &'a Summary,
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    quantities: IndexMap<&'a str, Option<f64>>,
}

fn print_json(summary: &Summary, values: &Values) -> Result<(), Box<dyn Error>> {
    let quantities = values.iter().map(|(text, value)| (text.as_str(), value.as_ref().ok().copied())).collect();
    say!("{}", serde_json::to_string_pretty(&Report { summary, quantities })?);
    Ok(())
}

fn run(prepared: &Prepared, job: &output::Job, options: Options<'_>, quiet: bool) -> Result<Summary, Refusal> {
    let mut bar = RunBar::new(quiet);
    let above = bar.handle();
    let warn = |text: &str| {
        if !quiet {
            above.suspend(|| tell!("warning: {text}"));
        }
    };
    let mut follow = |progress: &Progress<'_>| bar.follow(progress);
    // As one of the threads: from outside each pass over the elements would wait to be taken up.
    let work = || job::run_with(prepared, job, Options { warn: Some(&warn), ..options }, &mut follow);
    let summary = if rayon::current_num_threads() > 1 { rayon::scope(|_| work()) } else { work() };
    bar.finish();
    summary
}

/// Says how it ended; the exit status is 0, that of a halt, or that of a signal as shells have it.
fn print_end(summary: &Summary, job: &output::Job, frames: Frames, signal: usize) -> Status {
    let Some(reason) = &summary.reason else { return Status::SUCCESS };
    let last = match frames {
        Frames::Written(_) => format!("\nthe last good state is in {}", job.path(".pvd").display()),
        Frames::Absent => String::new(),
    };
    tell!("halted: {reason}{last}");
    if !summary.interrupted {
        return Status::from(HALTED);
    }
    match &summary.lost[..] {
        [] => tell!("go on with --resume"),
        lost => tell!("{LOST}: {}\n--resume-anyway goes on without it", lost.join("; ")),
    }
    Status::from(128 + signal as u8)
}

/// What the user's routines had to say.
fn print_messages(messages: &[host::RoutineMessage], quiet: bool) {
    for message in messages.iter().filter(|m| !quiet || m.level == host::Level::Error) {
        let level = format!("{:?}", message.level).to_lowercase();
        let times = if message.times > 1 { format!(" ({} times)", message.times) } else { String::new() };
        tell!("{level} from the user's routine: {}{times}", message.text);
    }
}
