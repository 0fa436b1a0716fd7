//! Scores of contacts while they last.

use std::fmt::Debug;

use underbrush_recording::Sample;

use crate::{ModelError, SampleFault};

/// Scores several contacts at once, sample by sample: [`OnlineScorer::begin`] a contact, [`OnlineScorer::push`] its
/// samples, [`OnlineScorer::advance`] after the samples of one frame, then read the [`OnlineScorer::scores`].
///
/// After k samples of a contact its scores equal [`super::Classifier::scores_after`] k samples of a trial, bit for bit.
pub trait OnlineScorer: Debug + Send {
    /// Restarts a contact; its earlier samples are forgotten. Contacts are numbered from 0.
    ///
    /// # Panics
    /// If `contact` is not below the number of contacts. The other methods panic in the same case.
    fn begin(&mut self, contact: usize);

    /// Takes in the next sample of a contact. Returns `false` if the sample has no influence, as after a fixed window.
    /// The scores then stay as they were and need not be read again.
    ///
    /// # Errors
    /// [`SampleFault`] if the sample lacks a feature or has a number that is not finite.
    fn push(&mut self, contact: usize, sample: &Sample) -> Result<bool, SampleFault>;

    /// Processes the samples pushed since the last call.
    fn advance(&mut self);

    /// Writes the scores of a contact, one per category, in nats. Valid after [`OnlineScorer::advance`], if the
    /// contact's last sample had an influence.
    ///
    /// # Errors
    /// [`ModelError`] if the classifier runs a network from a file, and the network fails.
    fn scores(&self, contact: usize, scores: &mut [f64]) -> Result<(), ModelError>;
}

/// Scores one contact, for classifiers that treat each contact by itself. [`Independent`] makes an [`OnlineScorer`]
/// from it.
pub trait ContactScorer: Clone + Debug + Send + 'static {
    /// As [`OnlineScorer::push`].
    ///
    /// # Errors
    /// As [`OnlineScorer::push`].
    fn push(&mut self, sample: &Sample) -> Result<bool, SampleFault>;

    /// As [`OnlineScorer::scores`].
    ///
    /// # Errors
    /// As [`OnlineScorer::scores`].
    fn scores(&self, scores: &mut [f64]) -> Result<(), ModelError>;
}

/// Contacts that are scored independently of each other.
#[derive(Clone, Debug)]
pub struct Independent<S> {
    fresh: S,
    contacts: Vec<S>,
}

impl<S: ContactScorer> Independent<S> {
    /// This many contacts, each of which starts as a copy of `fresh`.
    pub fn new(fresh: S, contacts: usize) -> Self {
        let contacts = vec![fresh.clone(); contacts];
        Independent { fresh, contacts }
    }
}

impl<S: ContactScorer> OnlineScorer for Independent<S> {
    fn begin(&mut self, contact: usize) {
        self.contacts[contact].clone_from(&self.fresh);
    }

    fn push(&mut self, contact: usize, sample: &Sample) -> Result<bool, SampleFault> {
        self.contacts[contact].push(sample)
    }

    fn advance(&mut self) {}

    fn scores(&self, contact: usize, scores: &mut [f64]) -> Result<(), ModelError> {
        self.contacts[contact].scores(scores)
    }
}
