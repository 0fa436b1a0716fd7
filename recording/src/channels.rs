//! Further numbers of a sample.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// Numbers that a robot measures beside the force, such as shear or temperature, by the name of their column. The project
/// knows neither their units nor their meaning.
///
/// ```
/// use underbrush_recording::Channels;
///
/// let channels: Channels = [("shear_n", 0.2), ("temperature_k", 303.1)].into_iter().collect();
/// assert_eq!(channels.get("shear_n"), Some(0.2));
/// assert_eq!(channels.get("slip_m"), None);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Channels(Vec<(Arc<str>, f64)>);

impl Channels {
    /// The number of the channel with this name, if the sample has one.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.0.iter().find(|(own, _)| **own == *name).map(|(_, number)| *number)
    }

    /// Names and numbers, in order.
    pub fn iter(&self) -> impl Iterator<Item = (&Arc<str>, f64)> {
        self.0.iter().map(|(name, number)| (name, *number))
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Adds a channel after the others.
    pub fn push(&mut self, name: impl Into<Arc<str>>, number: f64) {
        self.0.push((name.into(), number));
    }
}

impl<Name: Into<Arc<str>>> FromIterator<(Name, f64)> for Channels {
    fn from_iter<I: IntoIterator<Item = (Name, f64)>>(channels: I) -> Self {
        Channels(channels.into_iter().map(|(name, number)| (name.into(), number)).collect())
    }
}
