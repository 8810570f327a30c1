//! Waiting for work on other threads: Python goes on meanwhile, hears how far it is, and can interrupt it.
//! Never here: the work.

use std::sync::atomic::{AtomicUsize, Ordering};

use pyo3::prelude::*;

/// The signal of Ctrl-C, by which a run says that it was interrupted.
const SIGINT: usize = 2;

/// Tells Python how far work is, and work whether Python has had enough.
pub struct Waiting {
    /// A number other than 0 ends the work.
    pub interrupt: AtomicUsize,
    progress: Option<Py<PyAny>>,
    /// What Python raised meanwhile.
    raised: std::sync::Mutex<Option<PyErr>>,
}

impl Waiting {
    /// `progress` is called with a fraction and a text.
    pub fn new(progress: Option<Py<PyAny>>) -> Waiting {
        Waiting { interrupt: AtomicUsize::new(0), progress, raised: std::sync::Mutex::new(None) }
    }

    /// Looks for signals and tells how far the work is; from the thread that waits.
    pub fn look(&self, fraction: f64, words: &str) {
        Python::attach(|py| {
            let told = py.check_signals().and_then(|()| match &self.progress {
                Some(progress) => progress.call1(py, (fraction, words)).map(|_| ()),
                None => Ok(()),
            });
            if let Err(raised) = told {
                self.stop(raised);
            }
        });
    }

    /// Ends the work because of an exception, which is raised when it has ended; the first counts.
    pub fn stop(&self, raised: PyErr) {
        self.interrupt.store(SIGINT, Ordering::Relaxed);
        if let Ok(mut first) = self.raised.lock() {
            first.get_or_insert(raised);
        }
    }

    /// What Python raised meanwhile.
    pub fn end(&self) -> PyResult<()> {
        let raised = self.raised.lock().ok().and_then(|mut raised| raised.take());
        raised.map_or(Ok(()), Err)
    }
}
