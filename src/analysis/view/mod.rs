//! `revolve view`: a page in the browser that shows a job while it runs.
//!
//! A thread looks at the result files and posts changes ([`watch`], [`board`]); a server on 127.0.0.1 sends it to
//! the pages as events, and frames on request ([`server`], [`answers`], [`store`]). The solver does not take part.

mod access;
mod answers;
mod board;
mod http;
mod server;
mod status;
mod store;
mod watch;

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::json;

use crate::output::{JobFiles, STATUS};
use crate::report::only_run;
use crate::solve::Progress;
use answers::RunAnswers;
use board::StateBoard;
use server::ViewServer;
use store::FrameStore;
use watch::FolderWatch;

/// Time between two reports of the progress of a run.
const REPORT_EVERY: Duration = Duration::from_millis(200);

/// View of a job, served by threads of this process.
pub struct JobView {
    board: Arc<StateBoard>,
    address: String,
    reported: Option<Instant>,
}

impl JobView {
    /// Opens a view of the results of a job. Port 0 is one that the system chooses.
    ///
    /// # Errors
    /// If the port is in use, or no thread can be started.
    pub fn open(job: &JobFiles, port: u16) -> Result<JobView, String> {
        let (board, store) = (Arc::new(StateBoard::default()), Arc::new(FrameStore::default()));
        let answers = RunAnswers::new(job.clone(), board.clone(), store.clone());
        let server = Arc::new(ViewServer::open(port, answers)?);
        let address = server.address().map_err(|e| e.to_string())?;
        let watch = FolderWatch::new(job.clone(), board.clone(), store);
        let start = |name: &str, work: Box<dyn FnOnce() + Send>| {
            let started = std::thread::Builder::new().name(name.into()).spawn(work);
            started.map_err(|e| format!("cannot start a thread: {e}"))
        };
        start("view-files", Box::new(|| watch.run()))?;
        start("view-server", Box::new(|| server.serve()))?;
        Ok(JobView { board, address, reported: None })
    }

    /// Returns the address of the page, with its token.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// Shows the progress of a run in this process.
    pub fn report_progress(&mut self, progress: &Progress<'_>) {
        if self.reported.is_some_and(|last| last.elapsed() < REPORT_EVERY) && !progress.ends {
            return;
        }
        self.reported = Some(Instant::now());
        let event = json!({
            "step": progress.step, "fraction": progress.fraction, "time": progress.now.total_time,
            "increment": progress.now.increment, "stable": progress.increment, "element": progress.limiting,
            "drift": progress.energy.drift,
        });
        self.board.post("progress", event.to_string());
    }

    /// Returns the number of open pages, and of pages since the start.
    pub fn pages(&self) -> [usize; 2] {
        self.board.readers()
    }
}

/// Returns the files of a deck that have changed since a run of the deck began.
pub fn changed_files<'a>(files: impl IntoIterator<Item = &'a Path>, job: &JobFiles) -> Vec<&'a Path> {
    let changed = |path: &Path| path.metadata().and_then(|file| file.modified()).ok();
    let begin = ["_0000.vtu", STATUS].iter().find_map(|ending| changed(&job.path(ending)));
    files.into_iter().filter(|file| begin.is_some() && changed(file) > begin).collect()
}

/// Returns the only job in a folder. A job that has just started has only a status file.
///
/// # Errors
/// If there is no job, or more than one.
pub fn job_in(folder: &Path) -> Result<JobFiles, String> {
    let name = only_run(folder).or_else(|reason| {
        let entries = std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))?;
        let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
        let jobs: Vec<String> = names.filter_map(|name| Some(name.strip_suffix(STATUS)?.to_owned())).collect();
        <[String; 1]>::try_from(jobs).map(|[name]| name).map_err(|_| reason)
    })?;
    Ok(JobFiles { folder: folder.to_owned(), name })
}
