//! Data of a report page; the JSON keys are those that `page.js` reads.

use serde::Serialize;
use serde_json::Value;

use crate::study::chart::Chart;

#[derive(Clone, Debug, Default, Serialize)]
pub struct ReportPage {
    /// Title of the page: the names of the jobs.
    pub title: String,
    pub folder: String,
    pub version: &'static str,
    pub runs: Vec<ReportRun>,
    pub sweeps: Vec<ReportTable>,
    pub studies: Vec<ReportStudy>,
    /// Results of `limit`, `identify` and `scatter`.
    pub searches: Vec<ReportSearch>,
    /// Notes on omitted data.
    pub notes: Vec<String>,
}

impl ReportPage {
    /// Iterates over the tables of sweeps, studies and searches.
    pub fn tables(&self) -> impl Iterator<Item = &ReportTable> {
        let (studies, searches) = (self.studies.iter().map(|s| &s.table), self.searches.iter().map(|s| &s.table));
        self.sweeps.iter().chain(studies).chain(searches)
    }
}

#[derive(Clone, Debug, Default, Serialize)]
pub struct ReportRun {
    pub name: String,
    /// `<job>.json` without its histories; null if the file does not exist.
    pub summary: Value,
    pub charts: Vec<Chart>,
    pub columns: Vec<ColumnSummaryRow>,
    /// Values of quantities with their uncertainties, as sentences.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub uncertainties: Vec<String>,
    /// Sentences on the deviation from reference curves.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub deviations: Vec<String>,
    pub meridian: Option<MeridianFrames>,
    /// Notes on omitted data.
    pub notes: Vec<String>,
}

/// Final, smallest and largest value of a history column.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ColumnSummaryRow {
    pub name: String,
    /// Value of the last row.
    #[serde(rename = "final")]
    pub last: f64,
    pub min: f64,
    pub max: f64,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ReportTable {
    pub name: String,
    pub header: Vec<String>,
    pub rows: Vec<Vec<String>>,
    pub charts: Vec<Chart>,
    /// Single values: name and value as text.
    pub facts: Vec<(String, String)>,
    /// Notes on omitted data.
    pub notes: Vec<String>,
}

/// A convergence or ablation study.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ReportStudy {
    /// Table of the settings or effects, and charts.
    pub table: ReportTable,
    /// Whether each row is on the Pareto front of error and run time.
    pub pareto: Vec<bool>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectSavings>,
}

/// Result of `limit`, `identify` or `scatter`: its table and the pictures that it has drawn.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ReportSearch {
    /// Title of the section, for example `Limit`.
    pub title: &'static str,
    pub table: ReportTable,
    pub pictures: Vec<ReportPicture>,
}

/// SVG picture.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ReportPicture {
    /// File name.
    pub name: String,
    /// Address of the form `data:`, which contains the picture.
    pub source: String,
}

/// Result of removing an effect: saved run time and change of the quantity.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EffectSavings {
    pub name: String,
    /// Relative size of the change of the quantity; `None` if the run failed.
    pub error: Option<f64>,
    /// Saved run time as a fraction of the full run time; negative if the run takes longer without the effect.
    pub saved: Option<f64>,
    /// Whether the change exceeds the error estimate.
    pub matters: bool,
}

/// Meridian section over time, packed for drawing. Numbers are unsigned 16-bit integers in base64, little endian; 65535
/// means "none".
#[derive(Clone, Debug, Default, Serialize)]
pub struct MeridianFrames {
    pub times: Vec<f64>,
    /// Number of points of the first mesh.
    pub points: usize,
    /// `[r min, r max, z min, z max]` over all frames (length).
    pub bounds: [f64; 4],
    /// r and z of all points of all frames, scaled to the bounds.
    pub places: String,
    /// Number of cells of the first mesh.
    pub cells: usize,
    /// Corners of the first mesh.
    pub corners: String,
    pub fields: Vec<PackedField>,
    /// Targets and analytical planes, from the summary.
    pub scene: Value,
    /// Element numbers of the first mesh.
    pub elements: Vec<i32>,
    /// Units of length and time; empty if unknown.
    pub units: [String; 2],
    /// Meshes after the first one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub new_meshes: Vec<PackedMesh>,
    /// Mesh of each frame: 0 is the first one, 1 the first of `new_meshes`. Empty if all frames have the first mesh.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub mesh_of_frame: Vec<usize>,
}

/// Mesh of successive frames.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PackedMesh {
    pub points: usize,
    pub cells: usize,
    /// Four corners per cell; lines have two, triangles three, and the others are "none".
    pub corners: String,
    /// Element number of each cell in the deck; 0 without one.
    pub elements: Vec<i32>,
}

/// Scalar field on points or cells, over all frames.
#[derive(Clone, Debug, Default, Serialize)]
pub struct PackedField {
    /// Name of the field, for example `MISES` or `V2`.
    pub name: String,
    /// Whether the values are on cells; otherwise they are on points.
    pub on_cells: bool,
    pub low: f64,
    pub high: f64,
    /// Unit; empty if unknown.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// Values scaled from `low` to `high`, frame by frame.
    pub values: String,
}
