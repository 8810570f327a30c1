//! Loads given in Python: a function of arrays, or the address of a compiled function.

use std::sync::{Arc, Mutex};

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadwriteArray1, PyReadwriteArray2};
use pyo3::prelude::*;
use pyo3::types::PySlice;
use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad, load_at};

/// Load given in Python.
#[derive(FromPyObject)]
pub enum PythonLoad {
    /// Address of a compiled function with the C calling convention.
    Address(usize),
    /// Python function, and whether it takes the surface name as an argument.
    Function(Py<PyAny>, bool),
}

/// Exception raised by a Python load function.
pub type RaisedException = Arc<Mutex<Option<PyErr>>>;

impl PythonLoad {
    /// Returns user subroutines with this load; an exception of the function is stored in `raised`.
    pub fn routines(&self, raised: &RaisedException) -> Routines {
        match self {
            PythonLoad::Address(address) => {
                load_at(*address).map_or_else(Routines::none, |load| Routines::none().with_load(load))
            }
            PythonLoad::Function(function, named) => {
                let function = Python::attach(|py| function.clone_ref(py));
                Routines::none().with_load(PythonFunction {
                    function,
                    named: *named,
                    sets: Vec::new(),
                    raised: raised.clone(),
                })
            }
        }
    }
}

/// Argument arrays of the function for a given number of points; reused by all calls with this number.
struct LoadArrays {
    count: usize,
    /// Coordinates, velocities and normals: six rows, r and z of each.
    given: Py<PyArray2<f64>>,
    pressures: Py<PyArray1<f64>>,
    /// Views of coordinates, velocities and normals with the shape `(count, 2)`.
    views: [Py<PyAny>; 3],
}

impl LoadArrays {
    fn new(py: Python<'_>, count: usize) -> PyResult<LoadArrays> {
        let inputs = PyArray2::<f64>::zeros(py, [6, count], false);
        let view = |first: isize| -> PyResult<Py<PyAny>> {
            let rows = inputs.get_item(PySlice::new(py, first, first + 2, 1))?;
            Ok(rows.getattr("T")?.unbind())
        };
        let views = [view(0)?, view(2)?, view(4)?];
        Ok(LoadArrays { count, views, pressures: PyArray1::zeros(py, count, false).unbind(), given: inputs.unbind() })
    }
}

struct PythonFunction {
    function: Py<PyAny>,
    named: bool,
    sets: Vec<LoadArrays>,
    raised: RaisedException,
}

impl PythonFunction {
    fn call(&mut self, py: Python<'_>, points: &LoadPoints<'_>, pressure: &mut [f64]) -> PyResult<()> {
        let count = points.r.len();
        let index = match self.sets.iter().position(|set| set.count == count) {
            Some(at) => at,
            None => {
                self.sets.push(LoadArrays::new(py, count)?);
                self.sets.len() - 1
            }
        };
        let set = &self.sets[index];
        {
            let mut inputs: PyReadwriteArray2<'_, f64> = set.given.bind(py).try_readwrite()?;
            let mut pressures: PyReadwriteArray1<'_, f64> = set.pressures.bind(py).try_readwrite()?;
            let rows = [points.r, points.z, points.velocity_r, points.velocity_z, points.normal_r, points.normal_z];
            for (row, values) in inputs.as_slice_mut()?.chunks_exact_mut(count.max(1)).zip(rows) {
                row.copy_from_slice(values);
            }
            pressures.as_slice_mut()?.copy_from_slice(pressure);
        }
        let [coordinates, velocities, normals] = &set.views;
        let time = points.now.total_time;
        if self.named {
            let arguments = (coordinates, velocities, normals, time, &set.pressures, points.surface);
            self.function.call1(py, arguments)?;
        } else {
            self.function.call1(py, (coordinates, velocities, normals, time, &set.pressures))?;
        }
        pressure.copy_from_slice(set.pressures.bind(py).try_readonly()?.as_slice()?);
        Ok(())
    }
}

impl UserLoad for PythonFunction {
    fn reads_magnitude(&self) -> bool {
        false
    }

    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        Python::attach(|py| {
            self.call(py, points, pressure).map_err(|raised| {
                let failure = LoadFailure::new(raised.to_string());
                if let Ok(mut first) = self.raised.lock() {
                    first.get_or_insert(raised);
                }
                failure
            })
        })
    }
}

/// Returns the stored exception as an error.
pub fn raised(raised: &RaisedException) -> PyResult<()> {
    raised.lock().ok().and_then(|mut raised| raised.take()).map_or(Ok(()), Err)
}
