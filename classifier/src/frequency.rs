//! How often things occur, and which of them has the largest number.

use std::collections::BTreeMap;

/// How often each thing occurs.
pub fn frequencies<T: Ord>(things: impl IntoIterator<Item = T>) -> BTreeMap<T, usize> {
    let mut counts = BTreeMap::new();
    things.into_iter().for_each(|thing| *counts.entry(thing).or_default() += 1);
    counts
}

/// For each thing, how many equal ones came before it.
pub(crate) fn earlier<T: Ord>(things: impl IntoIterator<Item = T>) -> impl Iterator<Item = usize> {
    let mut counts = BTreeMap::new();
    things.into_iter().map(move |thing| {
        let count = counts.entry(thing).or_insert(0);
        *count += 1;
        *count - 1
    })
}

/// What occurs most often; in a tie, the smallest.
pub(crate) fn most_frequent<T: Copy>(counts: &BTreeMap<T, usize>) -> Option<T> {
    largest(counts.iter().map(|(thing, count)| (*thing, *count))).map(|(thing, _)| thing)
}

/// The thing with the largest number; in a tie, the first.
pub(crate) fn largest<T, N: PartialOrd>(things: impl IntoIterator<Item = (T, N)>) -> Option<(T, N)> {
    things.into_iter().reduce(|best, other| if other.1 > best.1 { other } else { best })
}
