//! The command `revolve fragments`: masses of the fragments of an expanding body.

use std::error::Error;
use std::path::PathBuf;

use crate::deck::files;
use crate::output::JobFiles;
use crate::report::QuantityLabels;
use crate::report::fragments::{ExpandingBody, expanding_body};
use crate::study::StudyError;
use crate::study::fragments::{self, FragmentLaw, FragmentSet, FragmentShape, counted_masses};
use crate::study::table::{TextTable, cell, digits};
use clap::{Args, ValueEnum};
use serde_json::{Value, json};

use super::options::OutputOptions;
use super::words::print_out;
use super::{CommandStatus, print_table, search, write_results};

/// Estimate the number and masses of the fragments of an expanding body by the laws of Mott and Grady, from the
/// circumferential strain rates in a frame of a run. Numbers have the units of the deck.
#[derive(Args)]
pub struct FragmentsCommand {
    /// Result folder of one run, for example out/<deck name>; `revolve report` shows the table and picture.
    folder: PathBuf,
    /// Density of the body.
    #[arg(long, value_name = "NUMBER", value_parser = positive)]
    density: f64,
    /// How the body breaks: ring (along the circumference only), shell (into squares through --thickness) or solid (into
    /// cubes).
    #[arg(long, value_name = "SHAPE")]
    shape: ShapeName,
    /// Thickness of a shell at fracture.
    #[arg(long, value_name = "LENGTH", value_parser = positive, required_if_eq("shape", "shell"))]
    thickness: Option<f64>,
    /// Flow stress at fracture, for Mott's law.
    #[arg(long, value_name = "STRESS", value_parser = positive, requires = "gamma")]
    flow_stress: Option<f64>,
    /// Mott's constant: the rate of fracture grows by exp(gamma) per strain of 1.
    #[arg(long, value_name = "NUMBER", value_parser = positive, requires = "flow_stress")]
    gamma: Option<f64>,
    /// Fracture energy per area of new surface, for Grady's law.
    #[arg(long, value_name = "ENERGY/AREA", value_parser = positive)]
    fracture_energy: Option<f64>,
    /// Total time of fracture; the nearest frame is used (default: the last one).
    #[arg(long, value_name = "TIME")]
    time: Option<f64>,
    /// Element set of the deck (default: all solid elements).
    #[arg(long, value_name = "ELSET")]
    set: Option<String>,
    /// File with the masses of counted fragments: lines with a mass, or a mass and a count.
    #[arg(long, value_name = "FILE.csv")]
    counted: Option<PathBuf>,
    #[command(flatten)]
    output: OutputOptions,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ShapeName {
    Ring,
    Shell,
    Solid,
}

/// Parses a number above zero.
fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number > 0.0 && number.is_finite());
    number.ok_or_else(|| format!("expected a number above zero, found `{text}`"))
}

impl FragmentsCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let laws = self.laws()?;
        let counted = self.counted()?;
        let body = expanding_body(&self.folder, self.time, self.set.as_deref(), self.density)?;
        let sets: Vec<FragmentSet> =
            laws.iter().map(|law| FragmentSet::of(&body.elements, self.density, *law, self.shape())).collect();
        let job = JobFiles { folder: self.folder.clone(), name: body.job.clone() };
        let object = record(&body, &sets, &counted);
        let files = vec![search::json_file("fragments", &object)?];
        let charts = [(String::new(), fragments::chart(&job.name, &sets, &counted))];
        write_results(&job, "fragments", &table(&sets, &counted, true), files, &charts, &QuantityLabels::default())?;
        if !self.output.is_silent() {
            print_table(&table(&sets, &counted, false));
            print_out!("{}", sentence(&body));
            print_out!(
                "table {}, picture {}",
                job.path("_fragments.csv").display(),
                job.path("_fragments.png").display()
            );
        }
        self.output.print_json(&object)?;
        Ok(CommandStatus::SUCCESS)
    }

    fn shape(&self) -> FragmentShape {
        match self.shape {
            ShapeName::Ring => FragmentShape::Ring,
            ShapeName::Shell => FragmentShape::Shell(self.thickness.unwrap_or_default()),
            ShapeName::Solid => FragmentShape::Solid,
        }
    }

    fn laws(&self) -> Result<Vec<FragmentLaw>, String> {
        let mott =
            self.flow_stress.zip(self.gamma).map(|(flow_stress, gamma)| FragmentLaw::Mott { flow_stress, gamma });
        let grady = self.fracture_energy.map(|fracture_energy| FragmentLaw::Grady { fracture_energy });
        let laws: Vec<FragmentLaw> = mott.into_iter().chain(grady).collect();
        if laws.is_empty() {
            return Err(
                "give --flow-stress and --gamma for the law of Mott, --fracture-energy for the law of Grady, or all \
                        three"
                    .into(),
            );
        }
        Ok(laws)
    }

    fn counted(&self) -> Result<Vec<f64>, StudyError> {
        let Some(path) = &self.counted else { return Ok(Vec::new()) };
        let in_file = |message: String| StudyError::Setting(format!("--counted {}: {message}", path.display()));
        let text = files::read_text(path).map_err(|why| in_file(why.to_string()))?;
        counted_masses(&text).map_err(|why| in_file(why.to_string()))
    }
}

/// Returns the table with one row per law, and one of the counted fragments.
fn table(sets: &[FragmentSet], counted: &[f64], all_digits: bool) -> TextTable {
    let number = |value: Option<f64>| cell(value, 4, all_digits);
    let row = |name: &str, values: [Option<f64>; 3]| [name.to_owned()].into_iter().chain(values.map(number)).collect();
    let mut rows: Vec<Vec<String>> =
        sets.iter().map(|set| row(set.law, [Some(set.length), Some(set.number), Some(set.mean_mass)])).collect();
    if !counted.is_empty() {
        let count = counted.len() as f64;
        rows.push(row("counted", [None, Some(count), Some(counted.iter().sum::<f64>() / count)]));
    }
    TextTable { header: ["law", "mean length", "fragments", "mean mass"].map(str::to_owned).to_vec(), rows }
}

/// Returns the sum of masses and the mean rate weighted by mass.
fn mass_and_rate(body: &ExpandingBody) -> [f64; 2] {
    let mass: f64 = body.elements.iter().map(|element| element.mass).sum();
    [mass, body.elements.iter().map(|element| element.mass * element.rate).sum::<f64>() / mass]
}

fn sentence(body: &ExpandingBody) -> String {
    let [mass, rate] = mass_and_rate(body).map(|value| digits(value, 4));
    let rates = body.elements.iter().map(|element| element.rate);
    let [low, high] = [rates.clone().fold(f64::INFINITY, f64::min), rates.fold(0.0, f64::max)].map(|r| digits(r, 4));
    let others = match body.other_mass {
        0.0 => String::new(),
        other => format!("; a mass of {} does not expand and is left out", digits(other, 4)),
    };
    let (time, count) = (digits(body.time, 6), body.elements.len());
    format!("time {time}: {count} elements, mass {mass}, strain rate {rate} ({low} to {high}){others}")
}

fn record(body: &ExpandingBody, sets: &[FragmentSet], counted: &[f64]) -> Value {
    let [mass, rate] = mass_and_rate(body);
    let laws: Vec<Value> = sets
        .iter()
        .map(|s| json!({ "law": s.law, "length": s.length, "fragments": s.number, "mean_mass": s.mean_mass }))
        .collect();
    json!({
        "time": body.time, "mass": mass, "strain_rate": rate, "other_mass": body.other_mass, "laws": laws, "counted": counted,
    })
}
