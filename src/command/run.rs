//! `revolve run`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Args;
use revolve::job::{self, Summary};
use revolve::output;
use revolve::user::host;

use super::{HALTED, REFUSED, UserFiles, accepted, pairs, progress_bar};

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
    /// Print nothing but errors.
    #[arg(long)]
    quiet: bool,
}

impl Run {
    /// Carries it out.
    pub fn execute(self) -> Result<ExitCode, String> {
        let Some(routines) = self.user.routines(self.quiet) else { return Ok(ExitCode::from(REFUSED)) };
        let mut prepared = job::prepare(&self.deck, &pairs(&self.set)?, &routines);
        if !accepted(&prepared, self.quiet) {
            return Ok(ExitCode::from(REFUSED));
        }
        if !self.quiet {
            println!("{}", prepared.plan.ledger.render());
        }
        let job = job::default_job(&self.deck, self.out);
        let bar = progress_bar(1000, self.quiet);
        let mut progress = |step: &str, fraction: f64, increment: u64| {
            bar.set_position((1000.0 * fraction) as u64);
            bar.set_message(format!("{step}, increment {increment}"));
        };
        let summary = job::run_to_files(&mut prepared, &job, &mut progress).map_err(|e| e.to_string())?;
        bar.finish_and_clear();
        print_messages(&summary.messages, self.quiet);
        summary.warnings.iter().filter(|_| !self.quiet).for_each(|w| eprintln!("warning: {w}"));
        if !self.quiet {
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
