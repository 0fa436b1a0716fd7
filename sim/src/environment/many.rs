//! Many environments that step at once.

use std::sync::{Mutex, PoisonError};

use rayon::ThreadPool;
use rayon::prelude::*;
use underbrush_recording::InputError;

use super::{Environment, EnvironmentOptions, Stepped};
use crate::reach::{ReachError, ReachPlan};

/// Environments that step at once, on several threads. Each gives the same numbers that it would give alone.
pub struct Environments {
    /// The environments, in the order of their numbers.
    pub all: Vec<Environment>,
}

impl Environments {
    /// `count` environments of one plan. Environment i has the plan's seed plus i.
    ///
    /// # Errors
    /// As [`Environment::new`].
    pub fn new(plan: &ReachPlan, options: &EnvironmentOptions, count: usize) -> Result<Self, InputError> {
        let one = |index: usize| {
            let mut plan = plan.clone();
            plan.seed = plan.seed.wrapping_add(index as u64);
            Environment::new(plan, options.clone())
        };
        Ok(Environments { all: (0..count).map(one).collect::<Result<_, _>>()? })
    }

    /// How many numbers an observation has.
    pub fn observation_size(&self) -> usize {
        self.all.first().map_or(0, Environment::observation_size)
    }

    /// How many numbers an action has.
    pub fn action_size(&self) -> usize {
        self.all.first().map_or(0, Environment::action_size)
    }

    /// Resets the environments for which `which` returns true, each with its seed if it has one, on the threads of the
    /// current rayon pool. `observations` has a row for each environment; the rows of the others stay as they are.
    ///
    /// # Errors
    /// As [`Environment::reset`]: the error of the first environment that has one.
    pub fn reset(
        &mut self,
        seeds: &[Option<u64>],
        which: impl Fn(usize) -> bool + Sync,
        observations: &mut [f32],
    ) -> Result<Vec<Option<Stepped>>, InputError> {
        let size = self.observation_size().max(1);
        let rows = self.all.par_iter_mut().zip(seeds).zip(observations.par_chunks_mut(size)).enumerate();
        let reset = rows
            .map(|(index, ((environment, seed), row))| which(index).then(|| environment.reset(*seed, row)).transpose());
        reset.collect::<Vec<_>>().into_iter().collect()
    }

    /// Takes a step with every environment. One whose last step ended an episode begins a new one instead: its action
    /// is ignored, and its reward is 0. `actions` and `observations` have a row for each environment.
    ///
    /// The calling thread shares the work with the threads of `helpers`, so it need not be woken at the end, which can
    /// take as long as a step.
    ///
    /// # Errors
    /// As [`Environment::step`] and [`Environment::reset`]: the error of the first environment that has one.
    ///
    /// # Panics
    /// As [`Environment::step`].
    pub fn step(
        &mut self,
        helpers: Option<&ThreadPool>,
        actions: &[f64],
        observations: &mut [f32],
    ) -> Result<Vec<Stepped>, ReachError> {
        let (width, size, count) = (self.action_size().max(1), self.observation_size().max(1), self.all.len());
        let mut stepped: Vec<Option<Result<Stepped, ReachError>>> = (0..count).map(|_| None).collect();
        let rows = self.all.iter_mut().zip(actions.chunks(width)).zip(observations.chunks_mut(size));
        let rows = Mutex::new(rows.zip(&mut stepped));
        // The lock is held while a row is taken, not while its environment steps.
        let next = || rows.lock().unwrap_or_else(PoisonError::into_inner).next();
        let work = || {
            while let Some((((environment, action), row), found)) = next() {
                let step = environment.step(action, row).transpose();
                *found = Some(step.unwrap_or_else(|| Ok(environment.reset(None, row)?)));
            }
        };
        match helpers {
            Some(pool) if count > 1 => pool.in_place_scope(|scope| {
                for _ in 0..pool.current_num_threads().min(count - 1) {
                    scope.spawn(|_| work());
                }
                work();
            }),
            _ => work(),
        }
        stepped.into_iter().flatten().collect()
    }
}
