//! Python class of a finished run: summary, histories and frames.

use std::path::PathBuf;

use numpy::{IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::exceptions::{PyIndexError, PyKeyError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use revolve::job::RunSummary;
use revolve::output::{FieldArray, OutputFrame};
use revolve::study::quantity::{FinishedRun, Quantity};

use crate::errors;

/// Reason why a run ended early.
#[pyclass(frozen, get_all, module = "revolve._revolve")]
pub struct Halt {
    /// Name of the reason, for example `UserRoutine`.
    kind: &'static str,
    /// Stable code (`R…`).
    code: &'static str,
    message: String,
    /// Name of the element that caused the error.
    element: Option<String>,
    step: Option<u32>,
    increment: Option<u64>,
    /// Total time.
    time: Option<f64>,
    /// Place `(r, z)` of the error.
    place: Option<(f64, f64)>,
}

#[pymethods]
impl Halt {
    fn __str__(&self) -> String {
        format!("{}: {}", self.code, self.message)
    }

    fn __repr__(&self) -> String {
        format!("Halt({})", self.__str__())
    }
}

/// A finished run with its summary, histories and frames.
#[pyclass(frozen, module = "revolve._revolve")]
pub struct Run {
    summary: RunSummary,
    frames: Vec<OutputFrame>,
    /// Path of the frame series (`.pvd`) if the run wrote files.
    #[pyo3(get)]
    series: Option<PathBuf>,
}

impl Run {
    pub fn new(summary: RunSummary, frames: Vec<OutputFrame>, series: Option<PathBuf>) -> Run {
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

    /// Reason why the run stopped early; `None` if it completed.
    #[getter]
    fn halt(&self) -> Option<Halt> {
        let halt = self.summary.halt.as_ref()?;
        let details = halt.details();
        Some(Halt {
            kind: halt.name(),
            code: halt.code(),
            message: details.message.clone(),
            element: details.element.clone(),
            step: details.instant.map(|instant| instant.step),
            increment: details.instant.map(|instant| instant.increment),
            time: details.instant.map(|instant| instant.total_time),
            place: details.place.map(|[r, z]| (r, z)),
        })
    }

    /// Warnings of the run, and notes on bodies that are still moving in a target.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.summary.warnings.iter().chain(&self.summary.unfinished).cloned().collect()
    }

    /// Time in the time loop, in seconds.
    #[getter]
    fn seconds(&self) -> f64 {
        self.summary.timing.seconds
    }

    /// Summary as JSON, as in `<job>.json`.
    fn summary(&self) -> String {
        serde_json::to_string(&self.summary).unwrap_or_default()
    }

    /// Ledger with shares of the run time, as text.
    fn ledger(&self) -> String {
        self.summary.ledger.render(false)
    }

    /// Value of a history column: `final`, `min`, `max`, `time_min` or `time_max`.
    fn column(&self, name: &str, which: &str) -> PyResult<f64> {
        let columns = &self.summary.history.summary.0;
        let column_summary = columns.iter().find(|c| c.0.eq_ignore_ascii_case(name)).map(|c| c.1);
        let Some(column_summary) = column_summary else {
            let known: Vec<&str> = columns.keys().map(String::as_str).collect();
            return Err(PyKeyError::new_err(format!("no history column {name}; the columns are {}", known.join(", "))));
        };
        Ok(column_summary.value(which))
    }

    /// Value of an expression over history columns.
    fn quantity(&self, py: Python<'_>, text: &str) -> PyResult<f64> {
        let run = FinishedRun { history: &self.summary.history, end: None };
        Quantity::parse(text).and_then(|q| q.number(run)).map_err(|why| errors::study(py, &why))
    }

    /// All history columns by name; `time` and `step` are the first.
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

    /// Number of frames in memory.
    #[getter]
    fn frame_count(&self) -> usize {
        self.frames.len()
    }

    /// A frame without deleted elements: time, increment, points `(n, 2)`, point indices and start offsets of cells, point fields and cell
    /// fields.
    fn frame<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyDict>> {
        let frame = self.frames.get(index).ok_or_else(|| PyIndexError::new_err("the frame does not exist"))?;
        let frame = frame.without_deleted();
        let third = |i: usize| frame.third.get(i).copied();
        let points = frame.points.iter().enumerate();
        let points: Vec<f64> = points.flat_map(|(i, p)| p.iter().copied().chain(third(i))).collect();
        let starts = frame.cells.iter().scan(0, |end, cell| {
            let start = *end;
            *end += cell.len();
            Some(start as i64)
        });
        let starts: Vec<i64> = starts.collect();
        let corners: Vec<i64> = frame.cells.corners().iter().map(|&n| i64::from(n)).collect();
        let frame_dict = PyDict::new(py);
        frame_dict.set_item("time", frame.time)?;
        frame_dict.set_item("increment", frame.increment)?;
        frame_dict.set_item(
            "points",
            points.into_pyarray(py).reshape([frame.points.len(), if frame.third.is_empty() { 2 } else { 3 }])?,
        )?;
        frame_dict.set_item("starts", starts.into_pyarray(py))?;
        frame_dict.set_item("corners", corners.into_pyarray(py))?;
        frame_dict.set_item("point_fields", fields(py, &frame.point_fields)?)?;
        frame_dict.set_item("cell_fields", fields(py, &frame.cell_fields)?)?;
        Ok(frame_dict)
    }
}

/// Returns the fields as arrays by name; fields with several components have one row per point or cell.
fn fields<'py>(py: Python<'py>, fields: &[FieldArray]) -> PyResult<Bound<'py, PyDict>> {
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
