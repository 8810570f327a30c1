//! A run that is over: its summary, histories and frames.
//! Never here: pictures.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::exceptions::{PyIndexError, PyKeyError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use revolve::job::Summary;
use revolve::output::{Field, Frame};
use revolve::study::quantity::{FinishedRun, Quantity};

use crate::errors;

/// A run.
#[pyclass(frozen, module = "revolve._revolve")]
pub struct Run {
    summary: Summary,
    frames: Vec<Frame>,
    /// The series of frames, of a run that wrote files.
    #[pyo3(get)]
    series: Option<PathBuf>,
}

impl Run {
    pub fn new(summary: Summary, frames: Vec<Frame>, series: Option<PathBuf>) -> Run {
        Run { summary, frames, series }
    }
}

#[pymethods]
impl Run {
    /// `completed` or `halted`.
    #[getter]
    fn status(&self) -> &str {
        self.summary.status
    }

    /// Why it halted.
    #[getter]
    fn reason(&self) -> Option<&str> {
        self.summary.reason.as_deref()
    }

    /// Warnings, messages of routines at their end, and what is to be known of its values.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.summary.warnings.iter().chain(&self.summary.unfinished).cloned().collect()
    }

    /// Seconds in the time loop.
    #[getter]
    fn seconds(&self) -> f64 {
        self.summary.timing.seconds
    }

    /// What `<job>.json` holds.
    fn summary(&self) -> String {
        serde_json::to_string(&self.summary).unwrap_or_default()
    }

    /// The ledger with shares of the time, as text.
    fn ledger(&self) -> String {
        self.summary.ledger.render(false)
    }

    /// A number that a history column came to: `final`, `min`, `max`, `time_min`, `time_max`.
    fn column(&self, name: &str, which: &str) -> PyResult<f64> {
        let columns = &self.summary.history.summary.0;
        let found = columns.iter().find(|c| c.0.eq_ignore_ascii_case(name)).map(|c| c.1);
        let Some(found) = found else {
            let known: Vec<&str> = columns.keys().map(String::as_str).collect();
            return Err(PyKeyError::new_err(format!("no history column {name}; there are {}", known.join(", "))));
        };
        Ok(match which {
            "final" => found.last,
            "min" => found.min,
            "max" => found.max,
            "time_min" => found.time_min,
            _ => found.time_max,
        })
    }

    /// The value of an expression over histories.
    fn quantity(&self, py: Python<'_>, text: &str) -> PyResult<f64> {
        let run = FinishedRun { history: &self.summary.history, end: None };
        Quantity::parse(text).and_then(|q| q.number(run)).map_err(|why| errors::study(py, &why))
    }

    /// All histories by name, `time` and `step` first.
    fn history<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let history = &self.summary.history;
        let columns = PyDict::new(py);
        columns.set_item("time", PyArray1::from_slice(py, history.times()))?;
        columns.set_item("step", PyArray1::from_slice(py, history.steps()))?;
        for (i, name) in history.columns.iter().enumerate() {
            let values: Vec<f64> = (0..history.times().len()).map(|row| history.cell(row, i)).collect();
            columns.set_item(name, values.into_pyarray(py))?;
        }
        Ok(columns)
    }

    /// How many frames it kept.
    #[getter]
    fn frame_count(&self) -> usize {
        self.frames.len()
    }

    /// A frame: time, increment, points `(n, 2)`, cells as indices and where each begins, arrays of points and of cells.
    fn frame<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyDict>> {
        let frame = self.frames.get(index).ok_or_else(|| PyIndexError::new_err("no such frame"))?;
        let third = |i: usize| frame.third.get(i).copied();
        let points = frame.points.iter().enumerate();
        let points: Vec<f64> = points.flat_map(|(i, p)| p.iter().copied().chain(third(i))).collect();
        let starts = frame.cells.iter().scan(0, |end, cell| {
            let start = *end;
            *end += cell.len();
            Some(start as i64)
        });
        let starts: Vec<i64> = starts.collect();
        let corners: Vec<i64> = frame.cells.iter().flatten().map(|&n| n as i64).collect();
        let shown = PyDict::new(py);
        shown.set_item("time", frame.time)?;
        shown.set_item("increment", frame.increment)?;
        shown.set_item(
            "points",
            points.into_pyarray(py).reshape([frame.points.len(), if frame.third.is_empty() { 2 } else { 3 }])?,
        )?;
        shown.set_item("starts", starts.into_pyarray(py))?;
        shown.set_item("corners", corners.into_pyarray(py))?;
        shown.set_item("deleted", frame.deleted.clone().into_pyarray(py))?;
        shown.set_item("point_fields", fields(py, &frame.point_fields)?)?;
        shown.set_item("cell_fields", fields(py, &frame.cell_fields)?)?;
        Ok(shown)
    }
}

/// Arrays by name: one row a point or cell, where there are several components.
fn fields<'py>(py: Python<'py>, fields: &[Field]) -> PyResult<Bound<'py, PyDict>> {
    let arrays = PyDict::new(py);
    for field in fields {
        let values = PyArray1::from_slice(py, &field.values);
        if field.components > 1 {
            arrays.set_item(&field.name, values.reshape([field.values.len() / field.components, field.components])?)?;
        } else {
            arrays.set_item(&field.name, values)?;
        }
    }
    Ok(arrays)
}
