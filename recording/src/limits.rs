//! The range that a number in a file must lie in, and the ranges of what a tactile sensor tells.
//!
//! A number outside its range cannot be meant: it is a slip of the keyboard, a wrong unit or damage. Every reader of files
//! keeps one table of such ranges, each with its reason.

use std::fmt;

/// The smallest and the largest value of a number, both allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The smallest value.
    pub least: f64,
    /// The largest value.
    pub most: f64,
    /// One more value, outside the range, that switches off what the number describes.
    pub off: Option<f64>,
    /// The unit, empty for a plain number.
    pub unit: &'static str,
}

impl Limits {
    /// The range from `least` to `most`.
    pub const fn new(least: f64, most: f64, unit: &'static str) -> Self {
        Limits {
            least,
            most,
            off: None,
            unit,
        }
    }

    /// The same range, with a value besides that switches the effect off.
    #[must_use]
    pub const fn or_off_at(self, off: f64) -> Self {
        Limits { off: Some(off), ..self }
    }

    /// Whether a number is allowed; NaN never is.
    pub fn hold(&self, value: f64) -> bool {
        (self.least..=self.most).contains(&value) || self.off == Some(value)
    }
}

impl fmt::Display for Limits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(off) = self.off {
            write!(f, "{} (off), or ", short(off))?;
        }
        write!(f, "{} to {}", short(self.least), short(self.most))?;
        if !self.unit.is_empty() {
            write!(f, " {}", self.unit)?;
        }
        Ok(())
    }
}

/// A number as text, with an exponent where it would be long without one.
pub fn short(value: f64) -> String {
    if value == 0.0 || (1e-5..1e7).contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// Time from any origin, such as that of Unix time: 300 years. A double still tells 2 µs apart there.
pub const TIME_S: Limits = Limits::new(-1e10, 1e10, "s");

/// Force on a taxel. Noise and drift of a sensor's zero may read a little below 0, but nothing pulls on skin; 10 kN is the
/// weight of a tonne, which no tactile skin survives.
pub const FORCE_N: Limits = Limits::new(-1.0, 1e4, "N");

/// How far a contact has travelled. It is a length, so only noise takes it below 0; an arm on a moving base may draw a
/// contact along for a kilometre, but not for more.
pub const MOTION_M: Limits = Limits::new(-0.01, 1e3, "m");

/// Taxels of a contact region: at least the taxel itself, at most all that a skin may have.
pub const REGION_TAXELS: Limits = Limits::new(1.0, MOST_TAXELS as f64, "taxels");

/// The largest force in a contact region: its taxels are pressed.
pub const REGION_LARGEST_FORCE_N: Limits = Limits::new(0.0, FORCE_N.most, "N");

/// The sum of the forces in a contact region: a hundred taxels at the largest force.
pub const REGION_FORCE_SUM_N: Limits = Limits::new(0.0, 100.0 * FORCE_N.most, "N");

/// Taxels of a skin: frames hold their indices in 16 bits. The largest skins of robots have some thousand.
pub const MOST_TAXELS: usize = 65_536;

/// Patches of a skin: each has columns of its own in a data set.
pub const MOST_PATCHES: usize = 1000;

#[cfg(test)]
mod tests {
    use super::*;

    /// Pins that both ends and the value for "off" are allowed, and nothing outside, NaN and infinity included.
    #[test]
    fn ends_are_inside_and_all_else_is_outside() {
        let limits = Limits::new(1.0, 2.0, "N").or_off_at(0.0);
        for value in [0.0, 1.0, 1.5, 2.0] {
            assert!(limits.hold(value), "{value}");
        }
        for value in [-1.0, 0.999, 2.001, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e-300] {
            assert!(!limits.hold(value), "{value}");
        }
        assert_eq!(limits.to_string(), "0 (off), or 1 to 2 N");
        assert!(Limits::new(1.0, 2.0, "").or_off_at(f64::INFINITY).hold(f64::INFINITY));
    }

    /// Pins that no number takes more than some twenty characters, as 1e300 does with all its zeros.
    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (1e300, "1e300"),
            (-1e-300, "-1e-300"),
            (0.1, "0.1"),
            (10.0, "10"),
            (0.0, "0"),
        ] {
            assert_eq!(short(value), text);
        }
        assert_eq!((short(f64::NAN), short(f64::INFINITY)), ("NaN".into(), "inf".into()));
    }
}
