//! `revolve report`.

use super::Status;
use std::error::Error;
use std::path::PathBuf;

use crate::report::{Labels, PageOptions};
use crate::{output, report};
use clap::Args;

use super::words::say;

/// Write one self-contained HTML page for the runs, sweeps and studies in a folder.
#[derive(Args)]
pub struct Report {
    /// Folder with results, such as out/<deck name>.
    folder: PathBuf,
    /// The page (default report.html in the folder).
    #[arg(short, long, value_name = "FILE.html")]
    out: Option<PathBuf>,
    /// Another name for a quantity, such as U2@REF="depth" or MISES="equivalent stress"; may be given several times.
    #[arg(long, value_name = "COLUMN=TEXT")]
    label: Vec<String>,
    /// CSV file with curves to compare with: times, then columns named as those of the history. Their rms deviation is told.
    #[arg(long, value_name = "FILE")]
    compare: Option<PathBuf>,
    /// Print nothing but errors.
    #[arg(short, long)]
    quiet: bool,
}

impl Report {
    pub fn execute(self) -> Result<Status, Box<dyn Error>> {
        let options = PageOptions { labels: Labels::parse(&self.label)?, compare: self.compare };
        let page = report::gather_with(&self.folder, &options)?;
        let html = report::html(&page)?;
        let out = self.out.unwrap_or_else(|| self.folder.join("report.html"));
        output::write_whole(&out, html.as_bytes())?;
        if !self.quiet {
            let runs = page.runs.iter().map(|r| (r.name.as_str(), &r.notes));
            let tables = page.sweeps.iter().chain(page.studies.iter().map(|s| &s.table));
            page.runs.iter().flat_map(|r| &r.deviations).for_each(|line| say!("{line}"));
            for (name, notes) in runs.chain(tables.map(|t| (t.name.as_str(), &t.notes))) {
                notes.iter().for_each(|note| say!("{name}: {note}"));
            }
            page.notes.iter().for_each(|note| say!("{note}"));
            say!("report {}, {} kB", out.display(), html.len().div_ceil(1000));
        }
        Ok(Status::SUCCESS)
    }
}
