//! The threads that work is spread over, without the interpreter's lock.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::failure::Failure;

/// Most threads. The same bound as that of the command line.
const MAX_JOBS: usize = 1024;

/// The pool of this process. A process that was forked has the pool's memory but none of its threads, so it makes a new one.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

fn build(jobs: usize) -> Result<ThreadPool, Failure> {
    let pool = ThreadPoolBuilder::new().num_threads(jobs).build();
    pool.map_err(|error| Failure::Run(format!("cannot start threads: {error}")))
}

fn shared() -> Result<Arc<ThreadPool>, Failure> {
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    let process = std::process::id();
    match &*pool {
        Some((owner, pool)) if *owner == process => Ok(Arc::clone(pool)),
        _ => {
            // Dropping the parent's pool would wait for threads that are not there.
            std::mem::forget(pool.take());
            let new = Arc::new(build(0)?);
            *pool = Some((process, Arc::clone(&new)));
            Ok(new)
        }
    }
}

/// Runs work on the threads of the pool, or on `jobs` threads. A panic becomes an error.
///
/// # Errors
/// Those of the work; [`Failure::Input`] if `jobs` is out of range.
pub fn install<T: Send>(jobs: Option<usize>, work: impl FnOnce() -> Result<T, Failure> + Send) -> Result<T, Failure> {
    let pool = match jobs {
        None => shared()?,
        Some(jobs) if (1..=MAX_JOBS).contains(&jobs) => Arc::new(build(jobs)?),
        Some(jobs) => {
            let allowed = format!("1 to {MAX_JOBS} threads");
            return Err(Failure::argument(
                "jobs",
                jobs.to_string(),
                allowed,
                "use as many as there are cores",
            ));
        }
    };
    guarded(|| pool.install(work))
}

/// Runs work on the pool without the interpreter's lock.
///
/// # Errors
/// As [`install`].
pub fn detached<T: Send>(
    py: Python<'_>,
    jobs: Option<usize>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    py.detach(|| install(jobs, work))
}

/// Runs work. A panic, as of the physics engine in an extreme scene, becomes an error.
///
/// # Errors
/// Those of the work, and [`Failure::Run`] for a panic.
pub fn guarded<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
        Err(Failure::Run(format!(
            "internal error: {text}; please report it with the call and its input"
        )))
    })
}
