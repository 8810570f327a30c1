//! `revolve study --map`: files and printed lines of an error map.

use std::error::Error;

use clap::Args;

use super::options::OutputOptions;
use super::print_table;
use super::words::print_out;
use crate::output::{self, JobFiles};
use crate::study::map::measure::{ErrorMapRun, REGIONS};
use crate::study::map::{ErrorMap, output as lines, picture};

/// Options of an error map.
#[derive(Args)]
pub struct MapOptions {
    /// Divide the coarsest mesh into regions, refine one region after the other, and report the share of each region in the error
    /// of the quantity; without --refine the levels are mesh=1,2,4.
    #[arg(long, conflicts_with_all = ["ablate", "target"])]
    pub map: bool,
    /// Number of regions (default: 8 to 12, such that the map costs at most twice as much as the study).
    #[arg(long, value_name = "N", requires = "map", value_parser = clap::value_parser!(u16).range(1..=REGIONS[2] as i64))]
    pub map_regions: Option<u16>,
}

impl MapOptions {
    /// Returns the levels of a map without `--refine`.
    pub fn default_levels(&self, refine: &[String]) -> Vec<String> {
        if self.map && refine.is_empty() { vec!["mesh=1,2,4".to_owned()] } else { refine.to_vec() }
    }
}

/// Writes the table, the record and the picture of an error map.
pub fn write(job: &JobFiles, measured: &ErrorMapRun, title: &str) -> Result<(), Box<dyn Error>> {
    let drawing = picture::draw(&measured.map, &measured.mesh, title);
    let record = serde_json::to_string_pretty(&measured.map)? + "\n";
    let files = [
        ("_map.csv".to_owned(), lines::table(&measured.map, true).csv().into_bytes()),
        ("_map.json".to_owned(), record.into_bytes()),
        ("_map.svg".to_owned(), drawing.svg().into_bytes()),
        ("_map.png".to_owned(), drawing.png()?),
    ];
    Ok(output::write_with_sums(job, &files, "_map.sfv")?)
}

/// Prints the table of an error map and its conclusions.
pub fn print(job: &JobFiles, map: &ErrorMap, output: OutputOptions) {
    if output.is_silent() {
        return;
    }
    print_table(&lines::table(map, false));
    lines::conclusions(map).iter().for_each(|line| print_out!("{line}"));
    print_out!("map {}, picture {}", job.path("_map.csv").display(), job.path("_map.png").display());
}
