//! Verdicts counted by whether they are right, and the shares that follow from counts.

use serde::Serialize;

use crate::touch::TouchVerdict;

/// Verdicts on taxels in contact, frame by frame, or on objects, whose truth is known.
///
/// ```
/// use underbrush_classifier::evaluate::Tally;
/// use underbrush_classifier::touch::TouchVerdict;
///
/// let mut tally = Tally::default();
/// tally.add(TouchVerdict::Category(0), true, 3);
/// tally.add(TouchVerdict::Unknown, false, 1);
/// assert_eq!((tally.right, tally.wrong, tally.unknown), (3, 1, 1));
/// assert_eq!(tally.share(tally.right), Some(0.75));
/// assert_eq!(Tally::default().share(0), None);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Tally {
    /// The verdict is right.
    pub right: usize,
    /// The verdict is another category, outlier for something that is not one, or nothing for a touch.
    pub wrong: usize,
    /// No verdict yet.
    pub uncertain: usize,
    /// Of all verdicts: outlier, which touch models call unknown.
    pub unknown: usize,
    /// Of all verdicts: nothing, which only touch models give.
    pub nothing: usize,
}

impl Tally {
    /// All verdicts.
    pub fn total(&self) -> usize {
        self.right + self.wrong + self.uncertain
    }

    /// A part of all verdicts; `None` if there are none.
    pub fn share(&self, part: usize) -> Option<f64> {
        share(part, self.total())
    }

    /// Counts a number of equal verdicts.
    pub fn add(&mut self, verdict: TouchVerdict, is_right: bool, count: usize) {
        match verdict {
            _ if is_right => self.right += count,
            TouchVerdict::Uncertain => self.uncertain += count,
            _ => self.wrong += count,
        }
        match verdict {
            TouchVerdict::Unknown => self.unknown += count,
            TouchVerdict::Nothing => self.nothing += count,
            TouchVerdict::Category(_) | TouchVerdict::Uncertain => {}
        }
    }

    /// The sum of several tallies.
    pub fn sum(tallies: impl IntoIterator<Item = Tally>) -> Tally {
        tallies.into_iter().fold(Tally::default(), |sum, own| Tally {
            right: sum.right + own.right,
            wrong: sum.wrong + own.wrong,
            uncertain: sum.uncertain + own.uncertain,
            unknown: sum.unknown + own.unknown,
            nothing: sum.nothing + own.nothing,
        })
    }
}

/// A part of a number of things; `None` if there are none.
pub fn share(part: usize, all: usize) -> Option<f64> {
    (all > 0).then(|| part as f64 / all as f64)
}

/// The mean; `None` without values. That of the shares of right verdicts on several classes is their balanced share.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let values: Vec<f64> = values.into_iter().collect();
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
