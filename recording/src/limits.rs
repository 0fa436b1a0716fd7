//! Ranges for the numbers in files, and the ranges of a tactile sensor's quantities.
//!
//! A number outside its range cannot be intended: it is a typing error, a wrong unit or a damaged file. Every reader of
//! files has one table of such ranges, each with its reason.

use std::fmt;

/// The smallest and largest allowed value of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The smallest value.
    pub min: f64,
    /// The largest value.
    pub max: f64,
    /// A further allowed value outside the range, which switches the effect off.
    pub off: Option<f64>,
    /// The unit; empty for a plain number.
    pub unit: &'static str,
}

impl Limits {
    /// The range from `min` to `max`.
    pub const fn new(min: f64, max: f64, unit: &'static str) -> Self {
        Limits {
            min,
            max,
            off: None,
            unit,
        }
    }

    /// The same range with a further value that switches the effect off.
    #[must_use]
    pub const fn or_off_at(self, off: f64) -> Self {
        Limits { off: Some(off), ..self }
    }

    /// Whether a number is allowed. NaN never is.
    pub fn hold(&self, value: f64) -> bool {
        (self.min..=self.max).contains(&value) || self.off == Some(value)
    }
}

impl fmt::Display for Limits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(off) = self.off {
            write!(f, "{} (off), or ", short(off))?;
        }
        write!(f, "{} to {}", short(self.min), short(self.max))?;
        if !self.unit.is_empty() {
            write!(f, " {}", self.unit)?;
        }
        Ok(())
    }
}

/// A number as text, with an exponent if it would otherwise be long.
pub fn short(value: f64) -> String {
    if value == 0.0 || (1e-5..1e7).contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}

/// Time from any origin, such as the origin of Unix time: 300 years either way. The resolution of a double is then 2
/// µs.
pub const TIME_S: Limits = Limits::new(-1e10, 1e10, "s");

/// Force on a taxel. Noise and zero drift may give readings a little below 0, but nothing pulls on skin. 10 kN is the
/// weight of a tonne, which no tactile skin survives.
pub const FORCE_N: Limits = Limits::new(-1.0, 1e4, "N");

/// Path length of a contact. Only noise can make it negative. An arm on a moving base may drag a contact along for up
/// to a kilometre.
pub const MOTION_M: Limits = Limits::new(-0.01, 1e3, "m");

/// Number of taxels in a contact region: at least one, at most all of the skin.
pub const REGION_TAXELS: Limits = Limits::new(1.0, MAX_TAXELS as f64, "taxels");

/// Largest force in a contact region. Its taxels are pressed, so it is not negative.
pub const REGION_LARGEST_FORCE_N: Limits = Limits::new(0.0, FORCE_N.max, "N");

/// Sum of the forces in a contact region: a hundred taxels at the largest force.
pub const REGION_FORCE_SUM_N: Limits = Limits::new(0.0, 100.0 * FORCE_N.max, "N");

/// Number of taxels of a skin. Frames hold their indices in 16 bits; the largest robot skins have a few thousand.
pub const MAX_TAXELS: usize = 65_536;

/// Number of patches of a skin. Each has its own columns in a data set.
pub const MAX_PATCHES: usize = 1000;

#[cfg(test)]
mod tests {
    use super::*;

    /// Pins that both ends and the value for "off" are allowed, and that everything else is refused, including NaN and
    /// infinity.
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

    /// Pins that numbers stay short as text: 1e300 does not become three hundred zeros.
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
