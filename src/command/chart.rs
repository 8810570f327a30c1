//! `revolve chart`.

use super::Status;
use std::error::Error;
use std::path::{Path, PathBuf};

use crate::output;
use crate::report::picture::{self, Drawn};
use crate::report::{Asked, Labels};
use crate::study::draw;
use clap::{ArgGroup, Args};

use super::words::say;

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
    /// Carries it out.
    pub fn execute(self) -> Result<Status, Box<dyn Error>> {
        let out = self.out.clone().unwrap_or_else(|| self.folder.join("chart.png"));
        let svg = is_svg(&out)?;
        let bytes = match &self.field {
            Some(field) => {
                let picture = picture::meridian(&self.folder, self.frame, field)?;
                if svg { picture.into_bytes() } else { draw::png(&picture)? }
            }
            None => {
                let asked = Asked { labels: Labels::parse(&self.label)?, compare: self.compare };
                let Drawn { chart, deviations } = match self.energy {
                    true => Drawn { chart: picture::energies(&self.folder)?, ..Drawn::default() },
                    false => picture::columns(&self.folder, &self.column, &asked)?,
                };
                deviations.iter().for_each(|line| say!("{line}"));
                if svg { chart.svg()?.into_bytes() } else { chart.png()? }
            }
        };
        output::write_whole(&out, &bytes).map_err(|e| e.to_string())?;
        say!("picture {}", out.display());
        Ok(Status::SUCCESS)
    }
}

/// By the ending of the file's name.
pub(super) fn is_svg(path: &Path) -> Result<bool, String> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match ending.as_deref() {
        Some("svg") => Ok(true),
        Some("png") => Ok(false),
        _ => Err(format!("{}: the name of a picture ends in .png or .svg", path.display())),
    }
}
