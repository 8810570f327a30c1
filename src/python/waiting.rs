//! Waiting for work on other threads, with progress reports and interrupts by Python.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::Duration;

use pyo3::prelude::*;
use revolve::user::thread_pool;

/// Number of the signal of Ctrl-C, which marks a run as interrupted.
const SIGINT: usize = 2;

/// Time between two checks for signals.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Completed fraction and a text.
pub type ProgressMessage = (f64, String);

/// Runs `work` on a separate pool of threads. The calling thread meanwhile passes its messages to `receive`, and `None`
/// after 50 ms without a message. The pool ends with the call: a process that is forked later contains no thread of the pool.
///
/// # Errors
/// A message if the threads cannot be started.
pub fn on_threads<T: Send>(
    threads: usize,
    work: impl FnOnce(&dyn Fn(ProgressMessage)) -> T + Send,
    receive: &mut dyn FnMut(Option<ProgressMessage>),
) -> Result<T, String> {
    let pool = thread_pool(threads).build().map_err(|e| format!("cannot start threads: {e}"))?;
    let (sender, receiver) = mpsc::channel();
    let mut result = None;
    pool.in_place_scope(|scope| {
        let result = &mut result;
        // The receiver may have been dropped.
        scope.spawn(move |_| *result = Some(work(&|message| drop(sender.send(message)))));
        loop {
            match receiver.recv_timeout(POLL_INTERVAL) {
                Ok(message) => receive(Some(message)),
                Err(RecvTimeoutError::Timeout) => receive(None),
                Err(RecvTimeoutError::Disconnected) => break,
            }
        }
    });
    result.ok_or_else(|| "the work ended without a result".into())
}

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

    /// Checks for signals only.
    pub fn check_signals(&self) {
        if let Err(raised) = Python::attach(|py| py.check_signals()) {
            self.stop(raised);
        }
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
