//! The extension module `revolve._revolve` of the Python package; one file per class or group of functions.
#![forbid(unsafe_code)]

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

/// Runs a command line, whose first argument is the program name, and returns its exit status.
#[pyfunction]
fn main(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| revolve::command_line(arguments).0)
}

/// Returns the default number of threads.
#[pyfunction]
fn default_threads() -> usize {
    revolve::default_threads()
}

/// Extension module `_revolve`, on which the package `revolve` is built.
#[pymodule]
fn _revolve(module: &Bound<'_, PyModule>) -> PyResult<()> {
    // User subroutines resolve their host routines among the symbols of the process.
    revolve::user::show_symbols().map_err(PyImportError::new_err)?;
    revolve::model::silence_caught_panics();
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    module.add_function(wrap_pyfunction!(default_threads, module)?)?;
    module.add_function(wrap_pyfunction!(deck::compile, module)?)?;
    module.add_function(wrap_pyfunction!(study::chart, module)?)?;
    module.add_function(wrap_pyfunction!(study::study, module)?)?;
    module.add_function(wrap_pyfunction!(study::limit, module)?)?;
    module.add_function(wrap_pyfunction!(study::uncertainty, module)?)?;
    module.add_function(wrap_pyfunction!(study::sensitivity, module)?)?;
    module.add_class::<deck::Deck>()?;
    module.add_class::<deck::User>()?;
    module.add_class::<evaluate::Evaluator>()?;
    module.add_class::<run::Halt>()?;
    module.add_class::<run::Run>()
}
