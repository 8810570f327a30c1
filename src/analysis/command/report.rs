//! The command `revolve report`: HTML page of a result folder.

use super::CommandStatus;
use std::error::Error;
use std::path::PathBuf;

use crate::report::{PageOptions, QuantityLabels};
use crate::{output, report};
use clap::Args;

use super::options::{LabelOption, QuietOption};
use super::words::print_out;

/// Write one self-contained HTML page with the runs, sweeps, studies, limits, identifications and Monte Carlo studies in
/// a folder.
#[derive(Args)]
pub struct ReportCommand {
    /// Result folder, for example out/<deck name>.
    folder: PathBuf,
    /// HTML file to write (default: report.html in the result folder).
    #[arg(short, long, value_name = "FILE.html")]
    out: Option<PathBuf>,
    #[command(flatten)]
    labels: LabelOption,
    /// CSV file with reference curves: time in the first column, then columns named like the history columns. The rms
    /// deviation of the run from each curve is reported.
    #[arg(long, value_name = "FILE")]
    compare: Option<PathBuf>,
    #[command(flatten)]
    quiet: QuietOption,
}

impl ReportCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let options = PageOptions { labels: QuantityLabels::parse(&self.labels.label)?, compare: self.compare };
        let page = report::gather_with(&self.folder, &options)?;
        let html = report::html(&page)?;
        let out = self.out.unwrap_or_else(|| self.folder.join("report.html"));
        output::write_whole(&out, html.as_bytes())?;
        if !self.quiet.quiet {
            let runs = page.runs.iter().map(|r| (r.name.as_str(), &r.notes));
            page.runs.iter().flat_map(|r| &r.deviations).for_each(|line| print_out!("{line}"));
            for (name, notes) in runs.chain(page.tables().map(|t| (t.name.as_str(), &t.notes))) {
                notes.iter().for_each(|note| print_out!("{name}: {note}"));
            }
            page.notes.iter().for_each(|note| print_out!("{note}"));
            print_out!("report {}, {} kB", out.display(), html.len().div_ceil(1000));
        }
        Ok(CommandStatus::SUCCESS)
    }
}
