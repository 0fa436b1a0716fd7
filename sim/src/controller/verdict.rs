//! What a contact was judged to be, and how hard the arm may press on it.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::TaxelContact;

/// What touches a taxel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Touched {
    /// Nothing: a spurious reading.
    Nothing,
    /// An object of the category with this name.
    Category(Arc<str>),
    /// An object of a known category, but it is not yet certain which.
    Uncertain,
    /// An object unlike all known categories.
    Unknown,
}

impl Touched {
    /// Its name: `nothing`, a category, `uncertain` or `unknown`.
    pub fn name(&self) -> &str {
        match self {
            Touched::Nothing => "nothing",
            Touched::Category(name) => name,
            Touched::Uncertain => "uncertain",
            Touched::Unknown => "unknown",
        }
    }
}

/// A judgement of a contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// What touches the taxel.
    pub touched: Touched,
    /// How probable that is; of an uncertain verdict, the probability of the likeliest category.
    pub probability: f64,
}

/// How hard the arm may press on which objects, N. The controller's own limit holds for everything else.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AllowedForces {
    /// The limits by the name of a category, N.
    pub categories_n: BTreeMap<String, f64>,
    /// The limit on objects unlike all known categories, N, if they have one.
    pub unknown_n: Option<f64>,
}

impl Default for AllowedForces {
    /// 6 N on leaves, twice the 3 N of `cody-2013`. A leaf bends away before a taxel feels as much (5.4 N at most in 14
    /// mixed reaches), so this limit hardly ever holds the arm back. 1.5 N on trunks, half of the
    /// limit of `cody-2013`. This limit must be above 1 N, the force at which the controller begins to take a reading
    /// for a contact, because the force of a contact over its limit may not rise at all.
    fn default() -> Self {
        AllowedForces { categories_n: [("leaf".to_owned(), 6.0), ("trunk".to_owned(), 1.5)].into(), unknown_n: None }
    }
}

/// What a verdict means for a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Allowance {
    /// The reading is not a contact.
    Ignored,
    /// The controller's own limit holds.
    Usual,
    /// The contact has this limit, N.
    AtMost(f64),
}

impl AllowedForces {
    /// What a verdict means for a contact.
    pub fn of(&self, touched: &Touched) -> Allowance {
        let limit = |force_n: Option<f64>| force_n.map_or(Allowance::Usual, Allowance::AtMost);
        match touched {
            Touched::Nothing => Allowance::Ignored,
            Touched::Uncertain => Allowance::Usual,
            Touched::Unknown => limit(self.unknown_n),
            Touched::Category(name) => limit(self.categories_n.get(&**name).copied()),
        }
    }
}

impl Allowance {
    /// The contact with its limit; `None` if it is to be ignored.
    pub fn apply(self, contact: &TaxelContact) -> Option<TaxelContact> {
        let allowed_force_n = match self {
            Allowance::Ignored => return None,
            Allowance::Usual => contact.allowed_force_n,
            Allowance::AtMost(force_n) => Some(force_n),
        };
        Some(TaxelContact { allowed_force_n, ..contact.clone() })
    }
}
