//! `revolve chart`.

use std::error::Error;
use std::path::PathBuf;

use crate::output;
use crate::report::picture::{self, ComparedChart};
use crate::report::{Labels, PageOptions};
use clap::{ArgGroup, Args};

use super::words::say;
use super::{PictureFormat, Status};

/// Draw history columns, energies or a frame of the run in a folder as PNG or SVG.
#[derive(Args)]
#[command(group = ArgGroup::new("what").required(true))]
pub struct Chart {
    /// Folder with the results of a run, such as out/<deck name>.
    folder: PathBuf,
    /// A history column, such as U2@REF; may be given several times.
    #[arg(long, group = "what", value_name = "NAME")]
    column: Vec<String>,
    /// All energies of the history.
    #[arg(long, group = "what")]
    energy: bool,
    /// The meridian coloured by a field, such as MISES, PEEQ or V2.
    #[arg(long, group = "what", value_name = "NAME")]
    field: Option<String>,
    /// Which frame, from 1 (default: the last).
    #[arg(long, requires = "field", conflicts_with_all = ["energy", "column"], value_name = "N")]
    frame: Option<usize>,
    /// Another name for a column, such as U2@REF="depth"; may be given several times.
    #[arg(long, requires = "column", value_name = "COLUMN=TEXT")]
    label: Vec<String>,
    /// CSV file with curves to compare with: times, then columns named as those of the history. Their rms deviation is printed.
    #[arg(long, requires = "column", value_name = "FILE")]
    compare: Option<PathBuf>,
    /// The picture, .png or .svg (default chart.png in the folder).
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl Chart {
    pub fn execute(self) -> Result<Status, Box<dyn Error>> {
        let out = self.out.clone().unwrap_or_else(|| self.folder.join("chart.png"));
        let format = PictureFormat::of(&out)?;
        let drawing = match &self.field {
            Some(field) => picture::meridian(&self.folder, self.frame, field)?,
            None => {
                let options = PageOptions { labels: Labels::parse(&self.label)?, compare: self.compare };
                let ComparedChart { chart, deviations } = match self.energy {
                    true => ComparedChart { chart: picture::energies(&self.folder)?, ..ComparedChart::default() },
                    false => picture::columns(&self.folder, &self.column, &options)?,
                };
                deviations.iter().for_each(|line| say!("{line}"));
                chart.drawing()?
            }
        };
        output::write_whole(&out, &format.bytes(&drawing)?)?;
        say!("picture {}", out.display());
        Ok(Status::SUCCESS)
    }
}
