//! The threads that work is spread over, without the interpreter's lock.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use underbrush_recording::stop;

use crate::Failure;

/// The largest number of threads, the same as on the command line.
const MAX_JOBS: usize = 1024;

/// A pool that is made when it is first needed. A process that was forked has the pool's memory but none of its threads, so it makes
/// a new one.
struct Made(Mutex<Option<(u32, Arc<ThreadPool>)>>);

impl Made {
    /// The pool with this many threads; 0 stands for all cores.
    fn get(&self, threads: usize) -> Result<Arc<ThreadPool>, Failure> {
        let mut pool = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let process = std::process::id();
        match &*pool {
            Some((owner, pool)) if *owner == process => Ok(Arc::clone(pool)),
            _ => {
                // Dropping the parent's pool would wait for threads that do not exist in this process.
                std::mem::forget(pool.take());
                let new = Arc::new(build(ThreadPoolBuilder::new().num_threads(threads))?);
                *pool = Some((process, Arc::clone(&new)));
                Ok(new)
            }
        }
    }
}

impl Drop for Made {
    fn drop(&mut self) {
        let pool = self.0.get_mut().unwrap_or_else(PoisonError::into_inner);
        if pool.as_ref().is_some_and(|(owner, _)| *owner != std::process::id()) {
            std::mem::forget(pool.take());
        }
    }
}

/// The pool of this process.
static POOL: Made = Made(Mutex::new(None));

fn build(builder: ThreadPoolBuilder) -> Result<ThreadPool, Failure> {
    builder.build().map_err(unstarted)
}

/// The failure to start a thread.
pub fn unstarted(error: impl std::fmt::Display) -> Failure {
    Failure::run(format!("cannot start threads: {error}"))
}

/// An error if a number of threads is out of range.
fn check(jobs: usize) -> Result<usize, Failure> {
    if (1..=MAX_JOBS).contains(&jobs) {
        return Ok(jobs);
    }
    let allowed = format!("1 to {MAX_JOBS} threads");
    Err(Failure::argument("jobs", jobs.to_string(), allowed, "use as many as there are cores"))
}

/// Threads that help the calling thread repeatedly.
pub struct Helpers {
    threads: usize,
    pool: Made,
}

impl Helpers {
    /// With the calling thread there are `jobs` threads, or by default as many as there are cores.
    ///
    /// # Errors
    /// `Fault::Input` if `jobs` is out of range.
    pub fn new(jobs: Option<usize>) -> Result<Self, Failure> {
        let jobs = jobs.map_or_else(|| Ok(std::thread::available_parallelism().map_or(1, usize::from)), check)?;
        Ok(Helpers { threads: jobs - 1, pool: Made(Mutex::new(None)) })
    }

    /// The threads, if there are any.
    ///
    /// # Errors
    /// `Fault::Run` if they cannot be started.
    pub fn get(&self) -> Result<Option<Arc<ThreadPool>>, Failure> {
        (self.threads > 0).then(|| self.pool.get(self.threads)).transpose()
    }
}

/// Runs work on the threads of the pool, or on `jobs` threads, without the interpreter's lock. A panic becomes an error.
///
/// # Errors
/// Those of the work; `Fault::Input` if `jobs` is out of range.
pub fn detached<T: Send>(
    py: Python<'_>,
    jobs: Option<usize>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let jobs = jobs.map(check).transpose()?;
    let pool_of = |threads: usize| build(ThreadPoolBuilder::new().num_threads(threads));
    py.detach(|| {
        if rayon::current_thread_index().is_some() {
            // A thread of a pool that waits here would begin the next reach meanwhile, and run its controller inside this one's.
            let own = pool_of(jobs.unwrap_or_else(rayon::current_num_threads))?;
            let joined = || {
                std::thread::scope(|scope| {
                    let thread = std::thread::Builder::new().spawn_scoped(scope, || own.install(work));
                    thread.map_err(unstarted)?.join().unwrap_or_else(|panic| resume_unwind(panic))
                })
            };
            return guarded(joined);
        }
        let pool = jobs.map_or_else(|| POOL.get(0), |jobs| pool_of(jobs).map(Arc::new))?;
        guarded(|| pool.install(work))
    })
}

/// Runs work on threads of its own, which end it if it asks [`stop::check`] after the flag is set.
///
/// # Errors
/// As [`detached`].
pub fn stoppable<T: Send>(
    jobs: Option<usize>,
    flag: Arc<AtomicBool>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let builder = ThreadPoolBuilder::new().num_threads(jobs.map(check).transpose()?.unwrap_or(0));
    let pool = build(builder.start_handler(move |_| stop::listen(Arc::clone(&flag))))?;
    guarded(|| pool.install(work))
}

/// Runs work on this thread without the interpreter's lock.
///
/// # Errors
/// As [`guarded`].
pub fn alone<T: Send>(py: Python<'_>, work: impl FnOnce() -> Result<T, Failure> + Send) -> Result<T, Failure> {
    py.detach(|| guarded(work))
}

/// Runs work. A panic, such as that of the physics engine in an extreme scene, becomes an error.
///
/// # Errors
/// Those of the work, and `Fault::Run` for a panic.
pub fn guarded<T>(work: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| {
        if panic.is::<stop::Stopped>() {
            return Err(Failure::run("the run was told to end"));
        }
        let text = stop::panic_text(panic.as_ref()).unwrap_or("no message");
        Err(Failure::run(format!("internal error: {text}; please report it with the call and its input")))
    })
}
