//! What was judged, whatever its unit.

use crate::decision::Verdict;

/// A verdict on one thing: a trial, a taxel in a frame, a contact or an object. All figures are counted over records.
///
/// ```
/// use underbrush_classifier::evaluate::Record;
///
/// let categories = ["leaf".to_owned(), "trunk".to_owned()];
/// let record = |truth, verdict| Record { truth, verdict, scores: &[], reach: None, weight: 1 };
/// assert!(record("trunk", 1).is_right(&categories));
/// // Uncertain is 2, outlier is 3.
/// assert!(!record("trunk", 2).is_right(&categories));
/// assert!(record("outlier", 3).is_right(&categories));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record<'a> {
    /// The true category.
    pub truth: &'a str,
    /// Index of the verdict: a category of the classifier, then uncertain, then outlier.
    pub verdict: usize,
    /// The scores of all categories, nats; empty if they are not known.
    pub scores: &'a [f64],
    /// The reach. Things of one reach depend on each other.
    pub reach: Option<u64>,
    /// How often it counts.
    pub weight: usize,
}

impl Record<'_> {
    /// Whether the verdict is right, by a classifier with these categories. For a foreign object (category outlier) the
    /// right verdict is outlier; no verdict is right for a foam block.
    pub fn is_right(&self, categories: &[String]) -> bool {
        match categories.get(self.verdict) {
            Some(category) => category == self.truth,
            None => self.verdict == categories.len() + 1 && self.truth == Verdict::Outlier.name(),
        }
    }
}
