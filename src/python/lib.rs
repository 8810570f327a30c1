//! The extension `revolve._revolve`: what the Python package asks of the library. One file a thing that Python holds.
//! Never here: what Python can do as well, physics.

mod deck;
mod errors;
mod evaluate;
mod load;
mod run;
mod study;
mod waiting;

use std::ffi::OsString;

use pyo3::exceptions::PyImportError;
use pyo3::prelude::*;

/// The command line: carries out arguments, the first of which is the name of the program; gives the exit status.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| revolve::command_line(arguments).0)
}

/// How many threads there are to be where nobody says it.
#[pyfunction]
fn default_threads() -> usize {
    revolve::default_threads()
}

/// The extension.
#[pymodule]
fn _revolve(module: &Bound<'_, PyModule>) -> PyResult<()> {
    // User subroutines look for their host routines among all symbols of the process.
    revolve::user::show_symbols().map_err(PyImportError::new_err)?;
    revolve::model::silence_caught_panics();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    module.add_function(wrap_pyfunction!(default_threads, module)?)?;
    module.add_function(wrap_pyfunction!(deck::compile, module)?)?;
    module.add_function(wrap_pyfunction!(study::chart, module)?)?;
    module.add_function(wrap_pyfunction!(study::study, module)?)?;
    module.add_class::<deck::Deck>()?;
    module.add_class::<deck::User>()?;
    module.add_class::<evaluate::Evaluator>()?;
    module.add_class::<run::Run>()
}
