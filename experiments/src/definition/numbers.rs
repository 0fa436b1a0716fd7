//! Numbers that an experiment file gives, with their defaults.

use underbrush_classifier::feature::FeatureSet;

use super::file::{
    EngineeredScene, ExperimentFile, Published, PublishedAccuracy, RecipeName, TableOneUnit, TestScene, TrainingScene,
    VerdictSection,
};

impl ExperimentFile {
    /// Recipes of the cross-validation table of a full run, or the first one of a quick run.
    pub fn recipes(&self, quick: bool) -> &[RecipeName] {
        if quick { &self.recipes[..self.recipes.len().min(1)] } else { &self.recipes }
    }
}

impl TrainingScene {
    /// Number of reaches of a full run or a quick one.
    pub fn reaches(&self, quick: bool) -> u64 {
        match quick {
            true => self.quick_reaches.unwrap_or(self.reaches.div_ceil(3)),
            false => self.reaches,
        }
    }

    /// Number of reaches at each setting, at least two and at most as many as in the run itself.
    pub fn setting_reaches(&self) -> u64 {
        self.setting_reaches.unwrap_or(self.reaches.div_ceil(2).max(2)).min(self.reaches)
    }
}

impl TestScene {
    /// Number of reaches of a full run or a quick one.
    pub fn reaches(&self, quick: bool) -> usize {
        match quick {
            true => self.quick_reaches.unwrap_or(1),
            false => self.reaches,
        }
    }

    /// The most reaches that are drawn until enough of them do what they should: in a quick run twice as many as are wanted.
    pub fn draws(&self, quick: bool) -> u64 {
        match quick {
            true => self.max_draws.min(2 * self.reaches(true) as u64),
            false => self.max_draws,
        }
    }
}

impl EngineeredScene {
    /// The most reaches that are drawn until one does what it should: one in a quick run.
    pub fn draws(&self, quick: bool) -> u64 {
        if quick { 1 } else { self.max_draws }
    }
}

impl VerdictSection {
    /// Number of reaches of a full run or a quick one.
    pub fn reaches(&self, quick: bool) -> u64 {
        match quick {
            true => self.quick_reaches.unwrap_or(self.reaches.div_ceil(3)),
            false => self.reaches,
        }
    }
}

impl Published {
    /// The published number of trials per reach.
    pub fn trials_per_reach(&self, by: TableOneUnit, label: &str) -> Option<f64> {
        let own = self.trials.iter().find(|own| own.by == by && own.label == label);
        own.map(|own| own.trials / own.reaches)
    }

    /// The published accuracy of a cell, per cent.
    pub fn accuracy_percent(&self, by: TableOneUnit, features: FeatureSet, states: usize) -> Option<f64> {
        let own = |own: &&PublishedAccuracy| own.by == by && own.features == features && own.states == states;
        self.accuracy.iter().find(own).map(|own| own.percent)
    }
}
