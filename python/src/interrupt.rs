//! Ctrl-C while work runs without the interpreter's lock.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use pyo3::prelude::*;

use crate::Failure;

/// Tells a run to end.
#[derive(Debug, Default)]
pub struct Stop {
    flag: Arc<AtomicBool>,
    /// The exception that ends the run.
    raised: Mutex<Option<PyErr>>,
}

impl Stop {
    /// Whether the run should end.
    pub fn is_set(&self) -> bool {
        self.flag.load(Ordering::Relaxed)
    }

    /// The flag that is set when the run should end.
    pub fn flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.flag)
    }

    /// Ends the run with this exception. Only the first one counts.
    pub fn raise(&self, error: PyErr) {
        if let Ok(mut raised) = self.raised.lock() {
            raised.get_or_insert(error);
        }
        self.flag.store(true, Ordering::Relaxed);
    }

    /// The exception that ended the run, or else the failure of the run itself. The next run is not told to end.
    pub fn reason(&self, failure: Failure) -> Failure {
        self.flag.store(false, Ordering::Relaxed);
        match self.raised.lock().ok().and_then(|mut raised| raised.take()) {
            Some(error) => error.into(),
            None => failure,
        }
    }

    /// The result of a run that may ignore that it should end, or exceptions of the user's objects: the exception if there was one.
    ///
    /// # Errors
    /// Those of the run, or the exception.
    pub fn checked<T>(&self, result: Result<T, Failure>) -> Result<T, Failure> {
        match result {
            Ok(_) if self.is_set() => Err(self.reason(Failure::run("the run was told to end"))),
            Ok(value) => Ok(value),
            Err(failure) => Err(self.reason(failure)),
        }
    }
}
