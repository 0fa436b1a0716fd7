//! Ctrl-C while work runs without the interpreter's lock.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use pyo3::prelude::*;

use crate::failure::Failure;
use crate::pool;
use crate::progress::Reported;

/// How often signals are checked.
const PERIOD: Duration = Duration::from_millis(50);

/// Tells a run to end.
#[derive(Default)]
pub struct Stop {
    flag: AtomicBool,
    /// The exception that ends the run.
    raised: Mutex<Option<PyErr>>,
}

impl Stop {
    /// Whether the run should end.
    pub fn is_set(&self) -> bool {
        self.flag.load(Ordering::Relaxed)
    }

    /// Ends the run with this exception. Only the first one counts.
    pub fn raise(&self, error: PyErr) {
        if let Ok(mut raised) = self.raised.lock() {
            raised.get_or_insert(error);
        }
        self.flag.store(true, Ordering::Relaxed);
    }

    /// The exception that ended the run, or else the failure of the run itself.
    pub fn reason(&self, failure: Failure) -> Failure {
        match self.raised.lock().ok().and_then(|mut raised| raised.take()) {
            Some(error) => error.into(),
            None => failure,
        }
    }

    /// The result of a run that ignores exceptions of the user's objects: the exception if there was one.
    ///
    /// # Errors
    /// Those of the run, or the exception.
    pub fn checked<T>(&self, result: Result<T, Failure>) -> Result<T, Failure> {
        match result {
            Ok(_) if self.is_set() => Err(self.reason(Failure::Run("the Python classifier raised".into()))),
            Ok(value) => Ok(value),
            Err(failure) => Err(self.reason(failure)),
        }
    }
}

/// Runs work on the pool in another thread while this one checks for signals and shows progress by `progress`, a function
/// of done, total and text. If a signal handler or that function raises, this sets `stop`, and waits for the work, which
/// then ends soon.
///
/// # Errors
/// Those of the work, or the exception.
pub fn watched<T: Send>(
    py: Python<'_>,
    jobs: Option<usize>,
    stop: &Arc<Stop>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&Reported) -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let reported = Reported::new(stop, progress);
    let shown = &reported;
    let (sender, receiver) = std::sync::mpsc::sync_channel(1);
    let receiver = Mutex::new(receiver);
    let result = std::thread::scope(|scope| {
        scope.spawn(move || {
            // The receiver exists until the result has arrived.
            let _ = sender.send(pool::install(jobs, || work(shown)));
        });
        loop {
            let come = py.detach(|| match receiver.lock() {
                Ok(receiver) => receiver.recv_timeout(PERIOD),
                Err(_) => Err(std::sync::mpsc::RecvTimeoutError::Disconnected),
            });
            match come {
                Ok(result) => return result,
                Err(std::sync::mpsc::RecvTimeoutError::Timeout) => {}
                Err(_) => return Err(Failure::Run("the working thread ended without a result".into())),
            }
            if !stop.is_set()
                && let Err(error) = py.check_signals().and_then(|()| shown.show(py))
            {
                stop.raise(error);
            }
        }
    });
    let value = result.map_err(|failure| stop.reason(failure))?;
    reported.show(py)?;
    Ok(value)
}
