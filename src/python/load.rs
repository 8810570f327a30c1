//! Loads of Python: a function of arrays, or the address of a compiled function.
//! Never here: loads of the user's files.

use std::sync::{Arc, Mutex};

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadwriteArray1, PyReadwriteArray2};
use pyo3::prelude::*;
use pyo3::types::PySlice;
use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

/// A load as Python gives it.
#[derive(FromPyObject)]
pub enum Load {
    /// The address of a C function.
    Address(usize),
    /// A function, and whether it is told the name of the surface.
    Function(Py<PyAny>, bool),
}

/// What a function of Python raised.
pub type Raised = Arc<Mutex<Option<PyErr>>>;

impl Load {
    /// The routines of a run; what its function raises goes to `raised`.
    pub fn routines(&self, raised: &Raised) -> Routines {
        match self {
            Load::Address(address) => Routines::none().with_load_at(*address).unwrap_or_default(),
            Load::Function(function, named) => {
                let function = Python::attach(|py| function.clone_ref(py));
                Routines::none().with_load(Called { function, named: *named, sets: Vec::new(), raised: raised.clone() })
            }
        }
    }
}

/// Arrays that a function is called with, used again in each call of so many points.
struct Arrays {
    count: usize,
    /// r and z of coordinates, velocities and normals, one row each.
    given: Py<PyArray2<f64>>,
    pressures: Py<PyArray1<f64>>,
    /// Coordinates, velocities and normals as `(count, 2)`.
    views: [Py<PyAny>; 3],
}

impl Arrays {
    fn new(py: Python<'_>, count: usize) -> PyResult<Arrays> {
        let given = PyArray2::<f64>::zeros(py, [6, count], false);
        let view = |first: isize| -> PyResult<Py<PyAny>> {
            let rows = given.get_item(PySlice::new(py, first, first + 2, 1))?;
            Ok(rows.getattr("T")?.unbind())
        };
        let views = [view(0)?, view(2)?, view(4)?];
        Ok(Arrays { count, views, pressures: PyArray1::zeros(py, count, false).unbind(), given: given.unbind() })
    }
}

struct Called {
    function: Py<PyAny>,
    named: bool,
    sets: Vec<Arrays>,
    raised: Raised,
}

impl Called {
    fn call(&mut self, py: Python<'_>, points: &LoadPoints<'_>, pressure: &mut [f64]) -> PyResult<()> {
        let count = points.r.len();
        let at = match self.sets.iter().position(|set| set.count == count) {
            Some(at) => at,
            None => {
                self.sets.push(Arrays::new(py, count)?);
                self.sets.len() - 1
            }
        };
        let set = &self.sets[at];
        {
            let mut given: PyReadwriteArray2<'_, f64> = set.given.bind(py).try_readwrite()?;
            let mut pressures: PyReadwriteArray1<'_, f64> = set.pressures.bind(py).try_readwrite()?;
            let rows = [points.r, points.z, points.velocity_r, points.velocity_z, points.normal_r, points.normal_z];
            for (row, values) in given.as_slice_mut()?.chunks_exact_mut(count.max(1)).zip(rows) {
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

impl UserLoad for Called {
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

/// The exception of a function, if it raised one.
pub fn raised(raised: &Raised) -> PyResult<()> {
    raised.lock().ok().and_then(|mut raised| raised.take()).map_or(Ok(()), Err)
}
