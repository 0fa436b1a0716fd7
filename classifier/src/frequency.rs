//! How often things occur.

use std::collections::BTreeMap;

/// How often each thing occurs.
pub fn frequencies<T: Ord>(things: impl IntoIterator<Item = T>) -> BTreeMap<T, usize> {
    let mut counts = BTreeMap::new();
    things.into_iter().for_each(|thing| *counts.entry(thing).or_default() += 1);
    counts
}

/// What occurs most often; in a tie, the smallest.
pub(crate) fn most_frequent<T: Copy>(counts: &BTreeMap<T, usize>) -> Option<T> {
    let max = counts.values().max()?;
    counts.iter().find(|(_, count)| *count == max).map(|(thing, _)| *thing)
}
