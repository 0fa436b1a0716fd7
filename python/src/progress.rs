//! Passes the progress of a run on to Python, and Ctrl-C on to the run, while it works without the interpreter's lock.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use pyo3::prelude::*;
use underbrush_experiments::{Counter, Progress};
use underbrush_recording::GoalOutcomes;

use crate::{Failure, pool, warn};

/// How often signals are checked.
const PERIOD: Duration = Duration::from_millis(50);

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
    /// Called as `callback(done, total, text)`.
    callback: Option<Py<PyAny>>,
}

impl Reported {
    /// Shows what is new: remarks as warnings, and the count.
    fn show(&self, py: Python<'_>) -> PyResult<()> {
        let Done { things, total, goals, remarks } = {
            let mut done = self.done.lock();
            Done { remarks: std::mem::take(&mut done.remarks), ..*done }
        };
        remarks.into_iter().try_for_each(|remark| warn(py, remark))?;
        if let Some(callback) = self.callback.as_ref().filter(|_| total > 0) {
            let goals = if goals.tried() == 0 { String::new() } else { goals.to_string() };
            callback.call1(py, (things, total, goals))?;
        }
        Ok(())
    }
}

impl Progress for Reported {
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

/// Runs work on threads of its own while this one checks for signals and shows progress by `progress`, a function
/// of done, total and text. If a signal handler or that function raises, this sets `stop`, and waits for the work, which
/// then ends soon if it asks for it.
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
    // A thread of a pool that waits here cannot help with the work, so a controller or a classifier that calls this gets threads of
    // its own.
    let jobs = jobs.or(rayon::current_thread_index().map(|_| rayon::current_num_threads()));
    let reported = Reported { done: Shared::default(), stop: Arc::clone(stop), callback: progress };
    let shown = &reported;
    let (sender, receiver) = std::sync::mpsc::sync_channel(1);
    let receiver = Mutex::new(receiver);
    let result = std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().spawn_scoped(scope, move || {
            // The receiver exists until the result has arrived.
            let _ = sender.send(pool::stoppable(jobs, Arc::clone(&stop.flag), || work(shown)));
        });
        thread.map_err(pool::unstarted)?;
        loop {
            let come = py.detach(|| receiver.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(PERIOD));
            match come {
                Ok(result) => return result,
                Err(std::sync::mpsc::RecvTimeoutError::Timeout) => {}
                Err(_) => return Err(Failure::run("the working thread ended without a result")),
            }
            if !stop.is_set()
                && let Err(error) = py.check_signals().and_then(|()| shown.show(py))
            {
                stop.raise(error);
            }
        }
    });
    let value = stop.checked(result)?;
    reported.show(py)?;
    Ok(value)
}

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
