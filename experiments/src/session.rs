//! One run of an experiment: its options, the folder of its results, and the results computed so far.

use std::any::{Any, TypeId};
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;
use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use underbrush_recording::Fault;

use crate::run_folder::{self, Plan};
use crate::{Experiment, Progress};

/// A run of an experiment.
pub struct Session<'a> {
    /// The experiment; in a quick run the small one.
    pub experiment: &'a Experiment,
    /// The seed.
    pub seed: u64,
    /// Whether it is a quick run.
    pub quick: bool,
    /// Number of independent campaigns, of this seed and the next ones.
    pub campaigns: u64,
    /// The folder for data and finished results.
    pub folder: &'a Path,
    /// Receives the progress.
    pub progress: &'a dyn Progress,
    /// When it began.
    pub(crate) start: Instant,
    /// Wall time of each stage so far, s.
    pub(crate) stages: RefCell<Vec<(&'static str, f64)>>,
    done: RefCell<HashMap<TypeId, Rc<dyn Any>>>,
}

/// The stages of a whole run, in their order.
const STAGES: [&str; 17] = [
    "Training reaches",
    "Trials",
    "Models",
    "Cross-validation",
    "Engineered, general and outlier reaches",
    "Thresholds",
    "Online verdicts",
    "Mixed training reaches",
    "Verdicts",
    "Moments of a general and of an outlier reach",
    "Truncated trials",
    "Other classifiers",
    "How fast classifiers decide",
    "Controllers",
    "Other arms and speeds",
    "Ablation",
    "Further campaigns",
];

/// What `make` gives for each of these things, in their order, made in parallel. The error is that of the first thing that has
/// one, whichever is found first.
pub(crate) fn in_parallel<I: Send, T: Send>(
    things: impl IntoParallelIterator<Item = I>,
    make: impl Fn(I) -> Result<T, Fault> + Sync + Send,
) -> Result<Vec<T>, Fault> {
    let made: Vec<Result<T, Fault>> = things.into_par_iter().map(make).collect();
    made.into_iter().collect()
}

impl<'a> Session<'a> {
    /// A run that has computed nothing yet.
    pub fn new(
        experiment: &'a Experiment,
        (seed, quick, campaigns): (u64, bool, u64),
        folder: &'a Path,
        progress: &'a dyn Progress,
    ) -> Self {
        Session {
            experiment,
            seed,
            quick,
            campaigns,
            folder,
            progress,
            start: Instant::now(),
            stages: RefCell::default(),
            done: RefCell::default(),
        }
    }

    /// The result of a function, computed once per session. Results are found by their type, so no two functions may
    /// return the same type.
    ///
    /// # Errors
    /// Those of the function.
    pub fn once<T: 'static>(&self, make: impl FnOnce(&Session<'a>) -> Result<T, Fault>) -> Result<Rc<T>, Fault> {
        let found = self.done.borrow().get(&TypeId::of::<T>()).cloned();
        if let Some(known) = found.and_then(|found| found.downcast::<T>().ok()) {
            return Ok(known);
        }
        let made = Rc::new(make(self)?);
        self.done.borrow_mut().insert(TypeId::of::<T>(), made.clone());
        Ok(made)
    }

    /// Runs a stage of the work and measures its wall time.
    ///
    /// # Errors
    /// Those of the work; that of [`Progress::check_stopped`] if the user ends the run.
    pub fn stage<T>(&self, name: &'static str, work: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
        self.progress.check_stopped()?;
        let place = STAGES.iter().position(|stage| *stage == name);
        let place = place.map_or(String::new(), |place| format!("stage {} of {}: ", place + 1, STAGES.len()));
        self.progress.stage(&format!("{place}{name}"));
        let start = Instant::now();
        let result = work()?;
        let seconds = start.elapsed().as_secs_f64();
        self.progress.stage(&format!("  {seconds:.1} s"));
        self.stages.borrow_mut().push((name, seconds));
        Ok(result)
    }

    /// The plan of a seed, on which its cached results depend.
    pub fn plan_of(&self, seed: u64) -> Plan {
        Plan::new(self.experiment, seed, self.quick)
    }

    /// The result of a seed: cached by an earlier run, or computed now and then cached.
    ///
    /// # Errors
    /// Those of computing it, or a file that cannot be written.
    pub fn kept<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        seed: u64,
        make: impl FnOnce() -> Result<T, Fault>,
    ) -> Result<T, Fault> {
        let path = self.folder.join("campaigns").join(format!("{name}-{seed}.json"));
        run_folder::result(&path, self.plan_of(seed), self.progress, make)
    }
}
