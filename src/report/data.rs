//! What a page shows, as the script in it reads it. The keys are those of `page.js`.
//! Never here: reading files, HTML.

use serde::Serialize;
use serde_json::Value;

use crate::study::chart::Form;

/// A page.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Page {
    /// Title: the names of the jobs.
    pub title: String,
    /// The folder, as it was given.
    pub folder: String,
    /// Version of the program that wrote the page.
    pub version: &'static str,
    /// Runs in order of their names.
    pub runs: Vec<Run>,
    /// Sweeps.
    pub sweeps: Vec<Table>,
    /// Studies.
    pub studies: Vec<Study>,
    /// What was left out and why.
    pub notes: Vec<String>,
}

/// A run.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Run {
    /// Name of the job.
    pub name: String,
    /// `<job>.json` without its histories, or null where a run left none.
    pub summary: Value,
    /// Charts over time: energies first.
    pub charts: Vec<Chart>,
    /// Final value, minimum and maximum of each column.
    pub columns: Vec<Column>,
    /// How far the run is from curves that it was compared with, in words.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub deviations: Vec<String>,
    /// Frames, where there are any.
    pub meridian: Option<Meridian>,
    /// What was left out and why.
    pub notes: Vec<String>,
}

/// A chart.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Name of the horizontal axis.
    pub x_label: String,
    /// Name of the vertical axis.
    pub y_label: String,
    /// Units of both; empty where they are not known.
    #[serde(skip_serializing_if = "unknown")]
    pub units: [String; 2],
    /// What is drawn, in words.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub words: String,
    /// Logarithmic axes.
    pub logarithmic: bool,
    /// What is drawn.
    pub series: Vec<Series>,
}

/// A line or points.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Series {
    /// Shown in the legend.
    pub name: String,
    /// How points are shown.
    pub form: Form,
    /// Abscissae.
    pub x: Vec<f64>,
    /// Ordinates.
    pub y: Vec<f64>,
    /// A word for each point, shown with it; empty where there are none.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub words: Vec<String>,
}

/// What a history column came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Column {
    /// Name.
    pub name: String,
    /// Value of the last row.
    #[serde(rename = "final")]
    pub last: f64,
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
}

/// A table with charts.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Table {
    /// Name of the job.
    pub name: String,
    /// Column names.
    pub header: Vec<String>,
    /// Cells as text.
    pub rows: Vec<Vec<String>>,
    /// Charts.
    pub charts: Vec<Chart>,
    /// Single findings: name and value as text.
    pub facts: Vec<(String, String)>,
    /// What was left out and why.
    pub notes: Vec<String>,
}

/// A study: its price list and what it says of itself.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Study {
    /// The price list and the charts.
    pub table: Table,
    /// Rows that nothing else beats in both error and time.
    pub pareto: Vec<bool>,
    /// Effects left out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<Effect>,
}

/// An effect left out: what it would have saved, and what error that buys.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Effect {
    /// Its name.
    pub name: String,
    /// Size of the change of the quantity, as a fraction of it; `None` where nothing came out.
    pub error: Option<f64>,
    /// Time saved, as a fraction of that of the whole; below zero where leaving it out costs time.
    pub saved: Option<f64>,
    /// Whether the change is above the error of the study.
    pub matters: bool,
}

/// The meridian over time, ready to draw. Numbers are unsigned 16-bit integers in base64, little endian; 65535 stands for
/// "none".
#[derive(Clone, Debug, Default, Serialize)]
pub struct Meridian {
    /// Times of the frames.
    pub times: Vec<f64>,
    /// How many points a frame has.
    pub points: usize,
    /// `[r low, r high, z low, z high]` over all frames, length.
    pub bounds: [f64; 4],
    /// r and z of every point of every frame, scaled to the bounds.
    pub places: String,
    /// How many cells there are.
    pub cells: usize,
    /// Four corners a cell; lines have two, triangles three, the rest "none".
    pub corners: String,
    /// Fields.
    pub fields: Vec<Field>,
    /// Targets and planes, from the summary.
    pub scene: Value,
    /// The deck's number of the element of each cell; 0 where it has none.
    pub elements: Vec<i32>,
    /// Units of length and time; empty where they are not known.
    pub units: [String; 2],
}

fn unknown(units: &[String; 2]) -> bool {
    units.iter().all(String::is_empty)
}

/// A scalar over points or cells in every frame.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Field {
    /// Name, such as `MISES` or `V2`.
    pub name: String,
    /// Whether it lives on cells.
    pub on_cells: bool,
    /// Smallest value over all frames.
    pub low: f64,
    /// Largest value over all frames.
    pub high: f64,
    /// Unit; empty where it is not known.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// Values scaled from low to high, frame after frame.
    pub values: String,
}
