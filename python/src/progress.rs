//! Passes the progress of a run on to Python.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use pyo3::prelude::*;
use underbrush_experiments::{Counter, Progress};
use underbrush_recording::GoalOutcomes;

use crate::interrupt::Stop;

/// What a run has done so far.
#[derive(Default)]
struct Done {
    things: AtomicU64,
    total: AtomicU64,
    goals: Mutex<GoalOutcomes>,
    remarks: Mutex<Vec<String>>,
}

/// Passes the progress of a run on to a Python function, and asks whether the run should end.
pub struct Reported {
    done: Arc<Done>,
    stop: Arc<Stop>,
    callback: Option<Py<PyAny>>,
}

impl Reported {
    /// Progress for this function, called as `callback(done, total, text)`.
    pub fn new(stop: &Arc<Stop>, callback: Option<Py<PyAny>>) -> Self {
        Reported { done: Arc::default(), stop: Arc::clone(stop), callback }
    }

    /// Shows what is new: remarks as warnings, and the count.
    pub fn show(&self, py: Python<'_>) -> PyResult<()> {
        let remarks = self.done.remarks.lock().map(|mut remarks| std::mem::take(&mut *remarks));
        for remark in remarks.unwrap_or_default() {
            py.import("warnings")?.call_method1("warn", (remark,))?;
        }
        let total = self.done.total.load(Ordering::Relaxed);
        if let Some(callback) = self.callback.as_ref().filter(|_| total > 0) {
            let goals = self.done.goals.lock().map_or(String::new(), |goals| match goals.tried() {
                0 => String::new(),
                _ => goals.to_string(),
            });
            callback.call1(py, (self.done.things.load(Ordering::Relaxed), total, goals))?;
        }
        Ok(())
    }
}

impl Progress for Reported {
    fn stage(&self, _: &str) {}

    fn remark(&self, text: &str) {
        if let Ok(mut remarks) = self.done.remarks.lock() {
            remarks.push(text.to_owned());
        }
    }

    fn count(&self, _: &str, total: u64, done: u64) -> Box<dyn Counter> {
        self.done.total.store(total, Ordering::Relaxed);
        self.done.things.store(done, Ordering::Relaxed);
        Box::new(Counted(Arc::clone(&self.done)))
    }

    fn is_stopped(&self) -> bool {
        self.stop.is_set()
    }
}

struct Counted(Arc<Done>);

impl Counter for Counted {
    fn advance(&self) {
        self.0.things.fetch_add(1, Ordering::Relaxed);
    }

    fn reach(&self, goals: GoalOutcomes) {
        if let Ok(mut sum) = self.0.goals.lock() {
            *sum = [*sum, goals].into_iter().sum();
        }
        self.advance();
    }
}
