//! The command `revolve chart`: pictures of histories and frames.

use std::error::Error;
use std::path::PathBuf;

use crate::output;
use crate::report::picture::{self, ComparedChart};
use crate::report::{PageOptions, QuantityLabels};
use clap::{ArgGroup, Args};

use super::words::print_out;
use super::{CommandStatus, PictureFormat};

/// Draw history columns, energies or one frame of a run as a PNG or SVG picture.
#[derive(Args)]
#[command(group = ArgGroup::new("what").required(true))]
pub struct ChartCommand {
    /// Result folder of one run, for example out/<deck name>.
    folder: PathBuf,
    /// History column to draw, for example U2@REF; can be repeated.
    #[arg(long, group = "what", value_name = "NAME")]
    column: Vec<String>,
    /// Draw the energy balance over time.
    #[arg(long, group = "what")]
    energy: bool,
    /// Draw the mesh in the r-z plane, coloured by a field, for example MISES, PEEQ or V2.
    #[arg(long, group = "what", value_name = "NAME")]
    field: Option<String>,
    /// Number of the frame, starting at 1 (default: the last frame).
    #[arg(long, requires = "field", conflicts_with_all = ["energy", "column"], value_name = "N")]
    frame: Option<usize>,
    /// Label shown for a column, for example U2@REF="depth"; can be repeated.
    #[arg(long, requires = "column", value_name = "COLUMN=TEXT")]
    label: Vec<String>,
    /// CSV file with reference curves: time in the first column, then columns named like the history columns. The rms
    /// deviation of the run from each curve is printed.
    #[arg(long, requires = "column", value_name = "FILE")]
    compare: Option<PathBuf>,
    /// Picture file, .png or .svg (default: chart.png in the result folder).
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

impl ChartCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let out = self.out.clone().unwrap_or_else(|| self.folder.join("chart.png"));
        let format = PictureFormat::of(&out)?;
        let drawing = match &self.field {
            Some(field) => picture::meridian(&self.folder, self.frame, field)?,
            None => {
                let options = PageOptions { labels: QuantityLabels::parse(&self.label)?, compare: self.compare };
                let ComparedChart { chart, deviations } = match self.energy {
                    true => ComparedChart { chart: picture::energies(&self.folder)?, ..ComparedChart::default() },
                    false => picture::columns(&self.folder, &self.column, &options)?,
                };
                deviations.iter().for_each(|line| print_out!("{line}"));
                chart.drawing()?
            }
        };
        output::write_whole(&out, &format.bytes(&drawing)?)?;
        print_out!("picture {}", out.display());
        Ok(CommandStatus::SUCCESS)
    }
}
