//! Waiting for work on other threads, with progress reports and interrupts by Python.

use std::sync::atomic::{AtomicUsize, Ordering};

use pyo3::prelude::*;

/// Number of the signal of Ctrl-C, which marks a run as interrupted.
const SIGINT: usize = 2;

/// Passes progress to Python, and interrupts from Python to the work.
pub struct PythonWait {
    /// A nonzero value ends the work.
    pub interrupt: AtomicUsize,
    progress: Option<Py<PyAny>>,
    /// Exception raised in Python during the work.
    raised: std::sync::Mutex<Option<PyErr>>,
}

impl PythonWait {
    /// Creates the object; `progress` is called with the completed fraction and a text.
    pub fn new(progress: Option<Py<PyAny>>) -> PythonWait {
        PythonWait { interrupt: AtomicUsize::new(0), progress, raised: std::sync::Mutex::new(None) }
    }

    /// Checks for signals and calls `progress`; called by the waiting thread.
    pub fn look(&self, fraction: f64, words: &str) {
        Python::attach(|py| {
            let checked = py.check_signals().and_then(|()| match &self.progress {
                Some(progress) => progress.call1(py, (fraction, words)).map(|_| ()),
                None => Ok(()),
            });
            if let Err(raised) = checked {
                self.stop(raised);
            }
        });
    }

    /// Interrupts the work because of an exception; the first exception is raised after the work has ended.
    pub fn stop(&self, raised: PyErr) {
        self.interrupt.store(SIGINT, Ordering::Relaxed);
        if let Ok(mut first) = self.raised.lock() {
            first.get_or_insert(raised);
        }
    }

    /// Returns an exception raised in Python during the work as an error.
    pub fn end(&self) -> PyResult<()> {
        let raised = self.raised.lock().ok().and_then(|mut raised| raised.take());
        raised.map_or(Ok(()), Err)
    }
}
