//! Passes the progress of a run on to Python.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;
use underbrush_experiments::{Counter, Progress};
use underbrush_recording::GoalOutcomes;

use crate::interrupt::Stop;

/// What a run has done so far.
#[derive(Default)]
struct Done {
    things: u64,
    total: u64,
    goals: GoalOutcomes,
    remarks: Vec<String>,
}

/// What a run has done so far, shared with its threads.
#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Done>>);

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Done> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Passes the progress of a run on to a Python function, and asks whether the run should end.
pub struct Reported {
    done: Shared,
    stop: Arc<Stop>,
    callback: Option<Py<PyAny>>,
}

impl Reported {
    /// Progress for this function, called as `callback(done, total, text)`.
    pub fn new(stop: &Arc<Stop>, callback: Option<Py<PyAny>>) -> Self {
        Reported { done: Shared::default(), stop: Arc::clone(stop), callback }
    }

    /// Shows what is new: remarks as warnings, and the count.
    pub fn show(&self, py: Python<'_>) -> PyResult<()> {
        let Done { things, total, goals, remarks } = {
            let mut done = self.done.lock();
            Done { remarks: std::mem::take(&mut done.remarks), ..*done }
        };
        for remark in remarks {
            py.import("warnings")?.call_method1("warn", (remark,))?;
        }
        if let Some(callback) = self.callback.as_ref().filter(|_| total > 0) {
            let goals = if goals.tried() == 0 { String::new() } else { goals.to_string() };
            callback.call1(py, (things, total, goals))?;
        }
        Ok(())
    }
}

impl Progress for Reported {
    fn stage(&self, _: &str) {}

    fn remark(&self, text: &str) {
        self.done.lock().remarks.push(text.to_owned());
    }

    fn count(&self, _: &str, total: u64, things: u64) -> Box<dyn Counter> {
        let mut done = self.done.lock();
        (done.things, done.total) = (things, total);
        Box::new(self.done.clone())
    }

    fn is_stopped(&self) -> bool {
        self.stop.is_set()
    }
}

impl Counter for Shared {
    fn advance(&self) {
        self.lock().things += 1;
    }

    fn reach(&self, goals: GoalOutcomes) {
        let mut done = self.lock();
        done.goals = [done.goals, goals].into_iter().sum();
        done.things += 1;
    }
}
