//! The command `revolve chart`: pictures of histories and frames.

use std::error::Error;
use std::path::{Path, PathBuf};

use crate::output;
use crate::output::animation::Animation;
use crate::report::filter::CutoffFrequency;
use crate::report::meridian::{ColourRange, FieldOptions, PictureWindow, RunFrames};
use crate::report::picture::{self, ComparedChart};
use crate::report::{PageOptions, QuantityLabels};
use clap::{ArgGroup, Args};

use super::options::{LabelOption, QuietOption};
use super::words::print_out;
use super::{CommandStatus, PictureFormat};

/// Draw history columns, energies or one frame of a run as a PNG or SVG picture.
#[derive(Args)]
#[command(group = ArgGroup::new("what").required(true))]
#[command(group = ArgGroup::new("labelled").arg("label").requires("column"))]
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
    #[command(flatten)]
    labels: LabelOption,
    /// Low-pass filter without a shift in time (Butterworth, both directions): the frequency at which amplitudes are
    /// reduced to 71 %, in 1/time, or a class of SAE J211: cfc60, cfc180, cfc600, cfc1000. The record needs three periods;
    /// its mean is kept.
    #[arg(long, requires = "column", value_name = "FREQUENCY|CLASS")]
    filter: Option<CutoffFrequency>,
    /// CSV file with reference curves: time in the first column, then columns named like the history columns. The rms
    /// deviation of the run from each curve is printed.
    #[arg(long, requires = "column", value_name = "FILE")]
    compare: Option<PathBuf>,
    /// Range of the colours: frame, run (all frames) or LOW..HIGH [default: frame; of an animation: run].
    #[arg(long, requires = "field", value_name = "RANGE", allow_hyphen_values = true)]
    range: Option<ColourRange>,
    /// Part of the plane to show: smallest and largest z, and largest r, for example -20..5,12.
    #[arg(long, requires = "field", value_name = "LOW..HIGH,R", allow_hyphen_values = true)]
    window: Option<PictureWindow>,
    /// Average element values at the nodes and interpolate them.
    #[arg(long, requires = "field")]
    smooth: bool,
    /// Write all frames as an animated .gif file.
    #[arg(long, requires = "field", conflicts_with_all = ["frame", "out"], value_name = "FILE")]
    animate: Option<PathBuf>,
    /// Duration of an animation in seconds.
    #[arg(long, requires = "animate", value_name = "SECONDS", default_value_t = 4.0)]
    duration: f64,
    /// Picture file, .png or .svg (default: chart.png in the result folder).
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    quiet: QuietOption,
}

impl ChartCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        if let (Some(file), Some(field)) = (&self.animate, &self.field) {
            return self.animate(file, field);
        }
        let out = self.out.clone().unwrap_or_else(|| self.folder.join("chart.png"));
        let format = PictureFormat::of(&out)?;
        let drawing = match &self.field {
            Some(field) => {
                let options = self.field_options(field, ColourRange::Frame);
                RunFrames::of(&self.folder)?.drawing(self.frame, &options)?
            }
            None => {
                let options = PageOptions { labels: QuantityLabels::parse(&self.labels.label)?, compare: self.compare };
                let ComparedChart { chart, deviations } = match self.energy {
                    true => ComparedChart { chart: picture::energies(&self.folder)?, ..ComparedChart::default() },
                    false => picture::columns(&self.folder, &self.column, &options, self.filter)?,
                };
                deviations.iter().filter(|_| !self.quiet.quiet).for_each(|line| print_out!("{line}"));
                chart.drawing()?
            }
        };
        output::write_whole(&out, &format.bytes(&drawing)?)?;
        if !self.quiet.quiet {
            print_out!("picture {}", out.display());
        }
        Ok(CommandStatus::SUCCESS)
    }

    fn field_options(&self, field: &str, range: ColourRange) -> FieldOptions {
        let (range, smooth, window) = (self.range.unwrap_or(range), self.smooth, self.window);
        FieldOptions { field: field.to_owned(), range, smooth, window }
    }

    fn animate(&self, file: &Path, field: &str) -> Result<CommandStatus, Box<dyn Error>> {
        if file.extension().is_none_or(|e| !e.eq_ignore_ascii_case("gif")) {
            return Err(format!("--animate {}: the file name must end in .gif", file.display()).into());
        }
        if !(self.duration > 0.0 && self.duration < 600.0) {
            return Err(format!("--duration {}: expected 0 to 600 s", self.duration).into());
        }
        let frames = RunFrames::of(&self.folder)?;
        let mut animation = Animation::new(self.duration / frames.count().max(1) as f64);
        frames.animation(&self.field_options(field, ColourRange::Run), &mut |drawing| animation.push(drawing))?;
        output::write_whole(file, &animation.finish()?)?;
        if !self.quiet.quiet {
            print_out!("animation {}, {} frames", file.display(), frames.count());
        }
        Ok(CommandStatus::SUCCESS)
    }
}
