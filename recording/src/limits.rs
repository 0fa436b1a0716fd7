//! Ranges for the numbers in files, the ranges of a tactile sensor's quantities, and the most that a file may hold.
//!
//! A number outside its range is a mistake: a typing error, a wrong unit or a damaged file. Every reader of files
//! has one table of such ranges, each with its reason.

use std::fmt;
use std::path::Path;

use crate::InputError;

/// The smallest and largest allowed value of a number.
///
/// ```
/// use underbrush_recording::Limits;
///
/// const FRICTION: Limits = Limits::new(0.0, 2.0, "");
/// assert!(FRICTION.hold(0.4) && !FRICTION.hold(f64::NAN));
/// ```
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
        Limits { min, max, off: None, unit }
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

/// The first number that is not within its limits: its key, the number, and what is allowed, as text.
pub fn first_outside<K>(numbers: impl IntoIterator<Item = (K, f64, Limits)>) -> Option<(K, String, String)> {
    let outside = numbers.into_iter().find(|(_, value, limits)| !limits.hold(*value));
    outside.map(|(key, value, limits)| (key, short(value), limits.to_string()))
}

/// A number as text, with an exponent if it would otherwise be long.
pub fn short(value: f64) -> String {
    if value == 0.0 || (1e-5..1e7).contains(&value.abs()) { value.to_string() } else { format!("{value:e}") }
}

/// A number to two digits as text, with an exponent if it would otherwise be long.
///
/// ```
/// use underbrush_recording::limits::two_digits;
///
/// assert_eq!([27.04, 7.13e-16, 0.0].map(two_digits), ["27", "7.1e-16", "0"]);
/// ```
pub fn two_digits(value: f64) -> String {
    short(format!("{value:.1e}").parse().unwrap_or(value))
}

/// Time from any origin, such as the origin of Unix time: 300 years either way. The resolution of a double is then 2
/// µs.
pub const TIME_S: Limits = Limits::new(-1e10, 1e10, "s");

/// Force on a taxel. Noise and zero drift may give readings a little below 0, but nothing pulls on skin. 10 kN is the
/// weight of a tonne, which no tactile skin survives.
pub const FORCE_N: Limits = Limits::new(-1.0, 1e4, "N");

/// Force that a taxel senses, in frames that a robot sends. Nothing pulls on skin, so a sensor whose zero drifts below 0 must
/// send 0 or leave the taxel out.
pub const SENSED_FORCE_N: Limits = Limits::new(0.0, FORCE_N.max, "N");

/// Coordinates of a patch, in frames that a robot sends. Choice: large enough for global coordinates. Motion is a difference of
/// coordinates, and is still accurate to some nanometres.
pub const POSITION_M: Limits = Limits::new(-1e8, 1e8, "m");

/// Path length of a contact. Only noise can make it negative. An arm on a moving base may drag a contact along for up
/// to a kilometre.
pub const MOTION_M: Limits = Limits::new(-0.01, 1e3, "m");

/// Number of taxels in a contact region: at least one, at most all of the skin.
pub const REGION_TAXELS: Limits = Limits::new(1.0, MAX_TAXELS as f64, "taxels");

/// Largest force in a contact region. Its taxels are pressed, so it is not negative.
pub const REGION_LARGEST_FORCE_N: Limits = Limits::new(0.0, FORCE_N.max, "N");

/// Sum of the forces in a contact region: a hundred taxels at the largest force.
pub const REGION_FORCE_SUM_N: Limits = Limits::new(0.0, 100.0 * FORCE_N.max, "N");

/// Shares of a whole, and probabilities.
pub const SHARE: Limits = Limits::new(0.0, 1.0, "");

/// Number of taxels of a skin. Frames hold their indices in 16 bits; the largest robot skins have a few thousand.
pub const MAX_TAXELS: usize = 65_536;

/// Number of patches of a skin. Each has its own columns in a data set.
pub const MAX_PATCHES: usize = 1000;

/// The most that a reader takes from one file, so that no file can fill the memory. docs/data.md says why each is enough.
#[derive(Debug)]
pub struct Ceiling {
    /// What is limited.
    pub what: &'static str,
    /// The largest number that is allowed.
    pub most: u64,
    /// The unit.
    pub unit: &'static str,
}

impl Ceiling {
    const fn new(what: &'static str, most: u64, unit: &'static str) -> Self {
        Ceiling { what, most, unit }
    }

    /// An error unless a number that was found in a file is within the ceiling.
    ///
    /// # Errors
    /// [`InputError`] with the ceiling.
    pub fn check(&self, path: &Path, field: &str, found: u64) -> Result<(), InputError> {
        if found <= self.most {
            return Ok(());
        }
        let Ceiling { what, most, unit } = self;
        let allowed = format!("at most {most} {unit}, the limit on {what}");
        let remedy =
            "divide the data among several files, or check what wrote this file; docs/data.md lists the limits";
        Err(InputError::new(path, field, format!("{found} {unit}"), allowed, remedy))
    }
}

/// Text files: 65,536 taxels, each with its place.
pub const TEXT_BYTES: Ceiling = Ceiling::new("scene, arm, skin, experiment, suite and mapping files", 4 << 20, "bytes");

/// JSON files: `nearest-neighbours` keeps its trials, up to two million samples.
pub const JSON_BYTES: Ceiling = Ceiling::new("model files, and JSON files of data sets", 256 << 20, "bytes");

/// Tables of trials as CSV: the rows below, at 80 bytes each.
pub const CSV_BYTES: Ceiling = Ceiling::new("CSV files", 4 << 30, "bytes");

/// Rows of a table: five days of contact at 100 Hz. They take 5 GB of memory.
pub const TABLE_ROWS: Ceiling = Ceiling::new("the rows of a table", 50_000_000, "rows");

/// Rows of a Parquet file of some length. Rows that differ take several bytes each.
pub const ROWS_PER_BYTE: Ceiling =
    Ceiling::new("the rows of a Parquet file above 100,000", 4, "rows for each byte of the file");

/// Rows of a Parquet file of any length.
pub const ROWS_OF_ANY_FILE: u64 = 100_000;

/// Samples of a trial: nearly three hours of one contact at 100 Hz.
pub const TRIAL_SAMPLES: Ceiling = Ceiling::new("the samples of a trial", 1_000_000, "samples");

/// A name or category, which people read.
pub const NAME_BYTES: Ceiling = Ceiling::new("a name or category in a table", 1000, "bytes");

/// Text columns: a million rows with 16 letters, even if none repeats.
pub const TEXT_COLUMN_BYTES: Ceiling =
    Ceiling::new("a text column in a row group of a Parquet file, before compression", 16 << 20, "bytes");

/// What a file declares to hold. Deflate cannot compress further than by 1032.
pub const EXPANSION: Ceiling =
    Ceiling::new("the numbers in a row group of a Parquet file above 64 MiB", 1100, "bytes for each byte of the file");

/// What a file of any length may declare to hold.
pub const EXPANDED_BYTES: u64 = 64 << 20;

/// Meshes that `arm new` reads: the largest of the arms in docs/arms.md has 3 MB.
pub const MESH_BYTES: Ceiling = Ceiling::new("mesh files of an arm", 64 << 20, "bytes");

#[cfg(test)]
mod tests {
    use super::*;

    /// The ceilings that docs/data.md lists, and why they are enough.
    const CEILINGS: [(Ceiling, &str); 10] = [
        (TEXT_BYTES, "65,536 taxels, each with its place"),
        (JSON_BYTES, "nearest-neighbours keeps its trials: two million samples"),
        (CSV_BYTES, "the rows below, at 80 bytes each"),
        (TABLE_ROWS, "five days of contact at 100 Hz; they take 5 GB of memory"),
        (ROWS_PER_BYTE, "rows that differ take several bytes each; rows that do not are no measurement"),
        (TRIAL_SAMPLES, "nearly three hours of one contact at 100 Hz"),
        (NAME_BYTES, "names are read by people"),
        (TEXT_COLUMN_BYTES, "a million rows with 16 letters, even if none repeats"),
        (EXPANSION, "deflate cannot compress further than by 1032"),
        (MESH_BYTES, "the largest of the arms in docs/arms.md has 3 MB"),
    ];

    /// Tests that both ends and the value for "off" are allowed, and that everything else is refused, including NaN and
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

    /// Tests that numbers stay short as text: 1e300 does not become three hundred zeros.
    #[test]
    fn numbers_are_short() {
        for (value, text) in [(1e300, "1e300"), (-1e-300, "-1e-300"), (0.1, "0.1"), (10.0, "10"), (0.0, "0")] {
            assert_eq!(short(value), text);
        }
        assert_eq!((short(f64::NAN), short(f64::INFINITY)), ("NaN".into(), "inf".into()));
    }

    /// Tests that `docs/data.md` lists the limits as they are. After a change, the left side of the failing assertion is
    /// the new text.
    #[test]
    fn the_document_lists_the_limits() {
        let row =
            |(Ceiling { what, most, unit }, why): &(Ceiling, &str)| format!("| {what} | {most} {unit} | {why} |\n");
        let rows: String = CEILINGS.iter().map(row).collect();
        let expected = format!("| what | at most | why this is enough |\n|---|---|---|\n{rows}");
        let document = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/data.md");
        let document = std::fs::read_to_string(document).unwrap();
        let (_, listed) = document.split_once("<!-- limits -->\n\n").unwrap();
        assert_eq!(expected, listed.split_inclusive("|\n\n").next().unwrap().trim_end_matches('\n').to_owned() + "\n");
    }
}
