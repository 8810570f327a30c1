//! Python class for the evaluation of quantities over tables of parameters.

use std::sync::Arc;

use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use revolve::study::evaluate::{self, DeckSource, SampleTable, UserRoutines};
use revolve::study::quantity::Quantity;

use crate::deck::{ParameterSettings, User};
use crate::errors;
use crate::load::{PythonLoad, RaisedException, raised};
use crate::waiting::PythonWait;

/// Evaluator of quantities over parameters of a deck.
#[pyclass(frozen, module = "revolve._revolve")]
pub struct Evaluator {
    evaluator: evaluate::SampleEvaluator,
    width: usize,
    raised: RaisedException,
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

impl Evaluator {
    /// Creates an evaluator for a deck.
    pub fn make(
        py: Python<'_>,
        source: DeckSource,
        names: Vec<String>,
        fixed: ParameterSettings,
        quantities: Vec<String>,
        user: Option<Py<User>>,
        load: Option<PythonLoad>,
    ) -> PyResult<Evaluator> {
        let parsed = quantities.iter().map(|q| Quantity::parse(q)).collect::<Result<Vec<_>, _>>();
        let parsed = parsed.map_err(|why| errors::study(py, &why))?;
        let width = parsed.len();
        let raised = RaisedException::default();
        let routines = match (user, load) {
            (None, None) => UserRoutines::Absent,
            (Some(user), None) => UserRoutines::Files(Arc::clone(&user.get().compiled)),
            (_, Some(load)) => {
                let exception = raised.clone();
                UserRoutines::Stateless(Box::new(move || load.routines(&exception)))
            }
        };
        let evaluator = py.detach(|| evaluate::SampleEvaluator::new(source, fixed, names, parsed, routines));
        Ok(Evaluator { evaluator: evaluator.map_err(|why| errors::study(py, &why))?, width, raised })
    }
}
