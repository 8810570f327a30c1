//! What a page shows, as the script in it reads it. The keys are those of `page.js`.

use serde::Serialize;
use serde_json::Value;

use crate::study::chart::Chart;

#[derive(Clone, Debug, Default, Serialize)]
pub struct Page {
    /// Title: the names of the jobs.
    pub title: String,
    pub folder: String,
    pub version: &'static str,
    pub runs: Vec<Run>,
    pub sweeps: Vec<Table>,
    pub studies: Vec<Study>,
    /// What was left out and why.
    pub notes: Vec<String>,
}

#[derive(Clone, Debug, Default, Serialize)]
pub struct Run {
    pub name: String,
    /// `<job>.json` without its histories, or null where a run left none.
    pub summary: Value,
    pub charts: Vec<Chart>,
    pub columns: Vec<Column>,
    /// How far the run is from curves that it was compared with, in words.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub deviations: Vec<String>,
    pub meridian: Option<Meridian>,
    /// What was left out and why.
    pub notes: Vec<String>,
}

/// What a history column came to.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Column {
    pub name: String,
    /// Value of the last row.
    #[serde(rename = "final")]
    pub last: f64,
    pub min: f64,
    pub max: f64,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Table {
    pub name: String,
    pub header: Vec<String>,
    pub rows: Vec<Vec<String>>,
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
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<Effect>,
}

/// An effect left out: what it would have saved, and what error that buys.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Effect {
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
    pub times: Vec<f64>,
    pub points: usize,
    /// `[r low, r high, z low, z high]` over all frames, length.
    pub bounds: [f64; 4],
    /// r and z of every point of every frame, scaled to the bounds.
    pub places: String,
    pub cells: usize,
    /// Four corners a cell; lines have two, triangles three, the rest "none".
    pub corners: String,
    pub fields: Vec<Field>,
    /// Targets and planes, from the summary.
    pub scene: Value,
    /// The deck's number of the element of each cell; 0 where it has none.
    pub elements: Vec<i32>,
    /// Units of length and time; empty where they are not known.
    pub units: [String; 2],
}

/// A scalar over points or cells in every frame.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Field {
    /// Name, such as `MISES` or `V2`.
    pub name: String,
    /// Whether it lives on cells.
    pub on_cells: bool,
    pub low: f64,
    pub high: f64,
    /// Unit; empty where it is not known.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// Values scaled from low to high, frame after frame.
    pub values: String,
}
