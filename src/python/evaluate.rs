//! Python class for the evaluation of quantities over tables of parameters.

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use revolve::study::evaluate::{SampleEvaluator, SampleTable};

use crate::errors;
use crate::load::{RaisedException, raised};
use crate::waiting::PythonWait;

/// Evaluator of quantities over parameters of a deck.
#[pyclass(frozen, module = "revolve._revolve")]
pub struct Evaluator {
    pub evaluator: SampleEvaluator,
    pub width: usize,
    pub raised: RaisedException,
}

/// Table of quantities, and the failed rows with their errors.
type Evaluated<'py> = (Bound<'py, PyArray2<f64>>, Vec<(usize, String)>);

#[pymethods]
impl Evaluator {
    /// Evaluates a table of samples, one per row.
    fn run<'py>(
        &self,
        py: Python<'py>,
        samples: PyReadonlyArray2<'py, f64>,
        threads: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Evaluated<'py>> {
        let count = samples.as_array().nrows();
        let values = samples.as_slice().map_err(|e| errors::setting(format!("samples: {e}")))?;
        let samples = SampleTable { values, count };
        let mut table = Array2::from_elem((count, self.width), f64::NAN);
        let waiting = PythonWait::new(progress);
        let out = table.as_slice_mut().unwrap_or_default();
        let mut report_progress =
            |done: usize| waiting.look(done as f64 / count.max(1) as f64, &format!("{done} of {count} samples"));
        let failures =
            py.detach(|| self.evaluator.run(samples, out, threads, &waiting.interrupt, &mut report_progress));
        waiting.end()?;
        raised(&self.raised)?;
        let failures = failures.map_err(|why| errors::study(py, &why))?;
        let reasons = failures.into_iter().map(|f| (f.row, f.reason.to_string())).collect();
        Ok((table.into_pyarray(py), reasons))
    }
}
