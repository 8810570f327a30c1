//! The command `revolve view`, and the option `--view` of `revolve run`: a page in the browser that shows a job while it
//! runs.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use clap::{Args, Parser};

use super::CommandStatus;
use super::run::RunCommand;
use super::words::{print_err, print_out};
use crate::job;
use crate::output::{JobFiles, STATUS};
use crate::platform::browser_command;
use crate::platform::signals::watch_signals;
use crate::view::{self, JobView};

/// Time between two looks at a signal or at the number of open pages.
const LOOK: Duration = Duration::from_millis(50);
/// After a run with `--view`: time without an open page after which the program ends, if a page was open and if none was.
/// A page that is loaded again is closed for a moment.
const CLOSED: Duration = Duration::from_secs(5);
const NEVER_OPENED: Duration = Duration::from_secs(60);

/// Show a job in the browser while it runs, or its results: deformed mesh, histories, time increment, warnings, ledger.
#[derive(Args)]
pub struct ViewCommand {
    /// Result folder of one job, or a deck. Results of the deck in out/<deck name> are shown; without results the deck is
    /// run, as by `run --view`.
    #[arg(value_name = "DIR|DECK")]
    target: PathBuf,
    /// Port of this machine (default: one that the system chooses).
    #[arg(long, value_name = "PORT")]
    port: Option<u16>,
    /// Print the address, but do not open the browser.
    #[arg(long)]
    no_browser: bool,
}

/// Option of `revolve run` to show the run in the browser.
#[derive(Args, Default)]
pub struct ViewOption {
    /// Show the run in the browser. After the run the page is served until it is closed, or until Ctrl+C.
    #[arg(long)]
    view: bool,
    /// Port of this machine for --view (default: one that the system chooses).
    #[arg(long, requires = "view", value_name = "PORT")]
    port: Option<u16>,
    /// Print the address of --view, but do not open the browser.
    #[arg(long, requires = "view")]
    no_browser: bool,
}

impl ViewOption {
    /// Opens the view if it is requested.
    pub fn open(&self, job: &JobFiles, quiet: bool) -> Result<Option<JobView>, Box<dyn Error>> {
        if !self.view {
            return Ok(None);
        }
        let view = JobView::open(job, self.port.unwrap_or(0))?;
        announce(&view, self.no_browser, quiet);
        Ok(Some(view))
    }
}

/// The arguments of `revolve run` for a deck without results.
#[derive(Parser)]
struct DeckRun {
    #[command(flatten)]
    run: RunCommand,
}

impl ViewCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let job = if self.target.is_dir() {
            view::job_in(&self.target)?
        } else {
            let job = job::default_job(&self.target, None)?;
            if ![".pvd", ".json", STATUS].iter().any(|ending| job.path(ending).is_file()) {
                return self.run_deck();
            }
            note_older_results(&self.target, &job);
            job
        };
        let signal = watch_signals()?;
        let view = JobView::open(&job, self.port.unwrap_or(0))?;
        announce(&view, self.no_browser, false);
        print_out!("Ctrl+C ends the view");
        while signal.load(Ordering::Relaxed) == 0 {
            std::thread::sleep(LOOK);
        }
        Ok(CommandStatus::SUCCESS)
    }

    fn run_deck(self) -> Result<CommandStatus, Box<dyn Error>> {
        let mut arguments = vec!["revolve run".into(), "--view".into()];
        arguments.extend(self.port.map(|port| format!("--port={port}").into()));
        arguments.extend(self.no_browser.then(|| "--no-browser".into()));
        arguments.extend(["--".into(), self.target.into_os_string()]);
        DeckRun::try_parse_from(arguments)?.run.execute()
    }
}

/// Notes that a deck has changed since its results were written.
fn note_older_results(deck: &Path, job: &JobFiles) {
    if !view::changed_files([deck], job).is_empty() {
        print_err!(
            "note: the results in {} are older than the deck; `revolve run {} --view` runs it again",
            job.folder.display(),
            deck.display()
        );
    }
}

/// Prints the address and opens it in the browser.
fn announce(view: &JobView, no_browser: bool, quiet: bool) {
    if quiet {
        print_err!("view {}", view.address());
    } else {
        print_out!("view {}", view.address());
    }
    let Some(mut command) = browser_command(view.address()).filter(|_| !no_browser) else { return };
    let started = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    match started {
        // The process is waited for, so that it does not remain as a zombie.
        Ok(mut process) => drop(std::thread::spawn(move || process.wait())),
        Err(error) => print_err!("note: the browser cannot be opened: {error}"),
    }
}

/// Serves a view after its run, until its pages are closed or a signal arrives.
pub fn serve_until_closed(view: &JobView, signal: &AtomicUsize, quiet: bool) {
    if !quiet && signal.load(Ordering::Relaxed) == 0 {
        print_out!("the view ends when its page is closed, or with Ctrl+C");
    }
    let mut last_open = Instant::now();
    while signal.load(Ordering::Relaxed) == 0 {
        let [open, all] = view.pages();
        if open > 0 {
            last_open = Instant::now();
        }
        if last_open.elapsed() > if all > 0 { CLOSED } else { NEVER_OPENED } {
            return;
        }
        std::thread::sleep(LOOK);
    }
}
