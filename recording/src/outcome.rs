//! The outcomes of goals, and the contact that ended an aborted goal.

use std::fmt;

use serde::{Deserialize, Serialize};

/// How a goal, or a whole reach, ended. An outcome is data, not an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The end effector came within the controller's dead zone of the goal.
    Reached,
    /// The end effector moved less than the controller's bound over its time window, or the controller gave the goal up.
    Stuck,
    /// The time allowed ran out.
    TimedOut,
    /// A contact force exceeded the stop force.
    Aborted,
}

impl Outcome {
    /// All outcomes, best first.
    pub const ALL: [Outcome; 4] = [Outcome::Reached, Outcome::Stuck, Outcome::TimedOut, Outcome::Aborted];

    /// The lower-case name used in every file.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::Reached => "reached",
            Outcome::Stuck => "stuck",
            Outcome::TimedOut => "timed_out",
            Outcome::Aborted => "aborted",
        }
    }

    /// The outcome with this name, as written by [`Outcome::name`].
    pub fn from_name(name: &str) -> Option<Outcome> {
        Outcome::ALL.into_iter().find(|outcome| outcome.name() == name)
    }
}

/// The number of goals with each outcome.
///
/// ```
/// use underbrush_recording::{GoalOutcomes, Outcome};
///
/// let mut outcomes = GoalOutcomes::default();
/// outcomes.count(Outcome::Reached);
/// outcomes.count(Outcome::Stuck);
/// assert_eq!((outcomes.of(Outcome::Reached), outcomes.tried()), (1, 2));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GoalOutcomes {
    /// Goals that were reached.
    pub reached: usize,
    /// Goals given up because the end effector made no progress, or by the controller.
    pub stuck: usize,
    /// Goals given up because the time allowed ran out.
    pub timed_out: usize,
    /// Goals that ended because a contact force exceeded the stop force; such a goal also ends the reach.
    pub aborted: usize,
}

impl GoalOutcomes {
    /// Counts one more goal.
    pub fn count(&mut self, outcome: Outcome) {
        *self.of_mut(outcome) += 1;
    }

    /// The number of goals with this outcome.
    pub fn of(mut self, outcome: Outcome) -> usize {
        *self.of_mut(outcome)
    }

    /// The number of goals with this outcome, to change it.
    pub fn of_mut(&mut self, outcome: Outcome) -> &mut usize {
        match outcome {
            Outcome::Reached => &mut self.reached,
            Outcome::Stuck => &mut self.stuck,
            Outcome::TimedOut => &mut self.timed_out,
            Outcome::Aborted => &mut self.aborted,
        }
    }

    /// The number of goals that were tried.
    pub fn tried(&self) -> usize {
        Outcome::ALL.into_iter().map(|outcome| self.of(outcome)).sum()
    }
}

impl std::iter::Sum for GoalOutcomes {
    fn sum<I: Iterator<Item = Self>>(counts: I) -> Self {
        let mut sum = GoalOutcomes::default();
        for count in counts {
            for outcome in Outcome::ALL {
                *sum.of_mut(outcome) += count.of(outcome);
            }
        }
        sum
    }
}

/// Readable text: `5 of 7 tried goals reached, 1 stuck, 1 aborted`.
impl fmt::Display for GoalOutcomes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // An aborted reach does not try its further goals.
        let tried = if self.aborted > 0 { "tried " } else { "" };
        let goals = if self.tried() == 1 { "goal" } else { "goals" };
        write!(f, "{} of {} {tried}{goals} reached", self.reached, self.tried())?;
        for (count, name) in [(self.stuck, "stuck"), (self.timed_out, "timed out"), (self.aborted, "aborted")] {
            if count > 0 {
                write!(f, ", {count} {name}")?;
            }
        }
        Ok(())
    }
}

/// The contact that ended a goal because its force exceeded the controller's stop force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SafetyStop {
    /// Index in [`crate::Recording::objects`]; `None` if another link of the arm pressed.
    pub object: Option<u16>,
    /// Name of the link that it pressed on.
    pub link: String,
    /// The patch that took most of the force; `None` if most of it fell on a part without skin.
    pub patch: Option<u16>,
    /// Force between the link and the object, N.
    pub force_n: f64,
}

/// A [`SafetyStop`] with names in place of indices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NamedStop {
    /// Index in [`crate::Recording::objects`]; `None` if another link of the arm pressed.
    pub object_index: Option<u16>,
    /// Kind of the object in the scene file (`leaf`, `trunk`, `foam_block`, `foam_roll`), or `arm`.
    pub object_kind: String,
    /// Name of the link that it pressed on.
    pub link: String,
    /// Name of the patch that took most of the force; `None` if most of it fell on a part without skin.
    pub patch: Option<String>,
    /// Force between the link and the object, N.
    pub force_n: f64,
}

/// Readable text: `104 N between trunk (object 3) and link forearm, patch forearm`.
impl fmt::Display for NamedStop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let NamedStop { object_index, object_kind, link, patch, force_n } = self;
        write!(f, "{force_n:.0} N between {object_kind} ")?;
        if let Some(index) = object_index {
            write!(f, "(object {index}) ")?;
        }
        write!(f, "and link {link}, ")?;
        match patch {
            Some(patch) => write!(f, "patch {patch}"),
            None => write!(f, "where it has no skin"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tests that counts add up, and that the text leaves out outcomes with a count of zero.
    #[test]
    fn goals_are_counted_by_outcome() {
        let count = |outcomes: &[Outcome]| {
            let mut counts = GoalOutcomes::default();
            outcomes.iter().for_each(|outcome| counts.count(*outcome));
            counts
        };
        use Outcome::{Aborted, Reached, Stuck, TimedOut};
        let first = count(&[Reached, Stuck, Reached, TimedOut]);
        let second = count(&[Reached, Aborted]);
        assert_eq!(first.to_string(), "2 of 4 goals reached, 1 stuck, 1 timed out");
        assert_eq!(count(&[Reached]).to_string(), "1 of 1 goal reached");
        // After a safety stop, further goals are not tried.
        assert_eq!(second.to_string(), "1 of 2 tried goals reached, 1 aborted");
        let sum: GoalOutcomes = [first, second].into_iter().sum();
        assert_eq!(Outcome::ALL.map(|outcome| sum.of(outcome)), [3, 1, 1, 1]);
        assert_eq!(sum.tried(), 6);
    }
}
