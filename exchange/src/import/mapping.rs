//! The mapping file: which numbers of a file are the forces on which taxels, in which unit.

use std::cmp::Ordering;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use schemars::{JsonSchema, Schema};
use serde::Deserialize;
use underbrush_recording::limits::{NAME_BYTES, first_outside};
use underbrush_recording::{
    Category, Grid, InputError, Limits, TEXT_BYTES, TRIAL_COLUMNS, is_plain, line_setting, parse_toml, read_text, short,
};

/// Frames per second: from one reading in a hundred seconds to a fast vibration sensor.
pub(super) const RATE_HZ: Limits = Limits::new(0.01, 1e5, "Hz");
/// Number of taxels: as many as a data set may have.
const TAXELS: Limits = Limits::new(1.0, underbrush_recording::limits::MAX_TAXELS as f64, "taxels");
/// Newtons per unit of a reading: from a nanonewton to a tonne.
const SCALE_N: Limits = Limits::new(1e-9, 1e4, "N");
/// Force at a reading of zero.
const OFFSET_N: Limits = Limits::new(-1e4, 1e4, "N");
/// Threshold of contact: within the range of forces.
const THRESHOLD_N: Limits = Limits::new(0.0, 1e4, "N");

/// Longest interruption of a contact: longer ones are two contacts.
const GAP_S: Limits = Limits::new(0.0, 10.0, "s");

/// The placeholder for the number of a taxel in the name of a column.
pub(super) const TAXEL: &str = "{taxel}";

/// How to read trials from a file of another program.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MappingFile {
    /// The times of the frames.
    #[serde(default)]
    pub(super) time: TimeTable,
    /// The forces.
    pub(super) force: ForceTable,
    /// How the forces become trials.
    #[serde(default)]
    pub(super) trial: TrialTable,
    /// The grid of the taxels, by which neighbours in contact form a region; its features need it.
    grid: Option<GridTable>,
    /// Where the taxels are, for recordings, which the classifier `touch` is trained on.
    pub(super) skin: Option<SkinTable>,
    /// Categories by interval of time, in place of a column.
    #[serde(default)]
    label: Vec<Label>,
    /// What else was measured, such as shear or temperature; `--features column:NAME` uses it.
    #[serde(default)]
    pub(super) channel: Vec<Channel>,
}

/// A further column of the trials, in the unit of the file.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Channel {
    /// Its name in the trials, without `+` and commas.
    pub(super) name: Arc<str>,
    /// The column of each taxel, with `{taxel}` in place of its number from 0, or one column for all taxels. A cell without a
    /// number means that nothing was measured there.
    pub(super) from: String,
}

/// The grid of the taxels. Taxel 0 is in the first row and column, taxel 1 in the next column.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct GridTable {
    /// Number of rows.
    rows: u32,
    /// Number of columns; rows times columns is the number of taxels.
    columns: u32,
    /// Whether the last column is a neighbour of the first, as on a closed sleeve.
    #[serde(default)]
    wraps: bool,
}

/// Where the taxels are.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SkinTable {
    /// CSV file, relative to the mapping, with a row for each taxel in the order of their numbers: `x_m`, `y_m`, `z_m`, the outward
    /// normal `normal_x`, `normal_y`, `normal_z`, and `area_m2`.
    pub(super) taxels: PathBuf,
    /// Columns with the pose of the frame of these places in the world: x, y and z in m, and the quaternion x, y, z, w. Without
    /// them the skin does not move.
    pub(super) pose_from: Option<[String; 7]>,
}

/// The category of an interval of time.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct Label {
    /// The number of the reach; every reach if not given.
    pub(super) reach: Option<u64>,
    /// It begins at this time, s.
    pub(super) from_s: f64,
    /// It ends before this time, s.
    pub(super) to_s: f64,
    /// The category.
    pub(super) category: String,
}

/// What one trial is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Cut {
    /// What one taxel feels from the beginning of a contact to its end.
    #[default]
    Contact,
    /// What all taxels together feel in one reach, from the first contact to the last: a slide or a grasp. Its force is
    /// the largest of the taxels, and its region all taxels in contact.
    Reach,
}

/// The times of the frames.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TimeTable {
    /// The column of the times.
    pub(super) from: Option<String>,
    /// Unit of these times: `s` (default), `ms`, `us` or `ns`.
    pub(super) unit: Option<String>,
    /// Frames per second, Hz. Needed if there are no times. Beside times it says, to a hundredth, at which rate the frames of
    /// recordings came; without it the rate is found for each reach, which takes some 150 frames if their times jitter much.
    pub(super) rate_hz: Option<f64>,
}

/// The forces.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ForceTable {
    /// The column of each taxel, with `{taxel}` in place of its number from 0.
    pub(super) from: String,
    /// Number of taxels.
    pub(super) taxels: Option<u32>,
    /// Unit of the forces: `N` (default), `mN`, `kN`, `gf`, `kgf` or `lbf`.
    unit: Option<String>,
    /// For raw readings, instead of `unit`: force of one unit of the reading, N.
    scale_n: Option<f64>,
    /// Force at a reading of zero, N; 0 if not given.
    offset_n: Option<f64>,
}

/// How the forces become trials.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct TrialTable {
    /// Name of the patch of skin.
    pub(super) patch: Option<String>,
    /// A taxel is in contact while its force is above this, N; 0.03 if not given.
    threshold_n: Option<f64>,
    /// A contact ends when the force is no longer above this, N; `threshold_n` if not given. A lower value keeps a force
    /// that varies about the threshold in one trial.
    release_n: Option<f64>,
    /// A contact that is interrupted for at most this long goes on, s; 0 if not given.
    gap_s: Option<f64>,
    /// What one trial is: `contact`, or `reach` for a slide or a grasp; `contact` if not given.
    #[serde(default)]
    pub(super) cut: Cut,
    /// Trials with fewer samples are left out; 1 if not given.
    min_samples: Option<u32>,
    /// The category of all trials.
    pub(super) category: Option<String>,
    /// The column of the category, if it changes.
    pub(super) category_from: Option<String>,
    /// The column of the number of the reach.
    pub(super) reach_from: Option<String>,
}

/// A checked mapping file.
#[derive(Debug)]
pub struct Mapping {
    path: PathBuf,
    text: String,
    pub(super) file: MappingFile,
    /// Units of time in a second.
    per_second: f64,
    /// Newtons per unit of force, and newtons at a reading of zero.
    newton: (f64, f64),
    pub(super) grid: Option<Grid>,
    /// A contact begins when the force of a taxel is above this, N.
    pub(super) threshold_n: f64,
    /// A contact ends when the force is no longer above this, N.
    pub(super) release_n: f64,
    /// An interruption of at most this length does not end a contact, s.
    pub(super) gap_s: f64,
    /// Trials with fewer samples are left out.
    pub(super) min_samples: usize,
}

/// The JSON Schema of mapping files.
pub fn mapping_schema() -> Schema {
    schemars::schema_for!(MappingFile)
}

/// How many of a unit of time make a second. Times are divided by this number, because 1000 is exact in binary and
/// 0.001 is not.
const PER_SECOND: [(&str, f64); 4] = [("s", 1.0), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)];
/// Newtons per unit. Standard gravity is 9.80665 m/s² (CGPM 1901), and a pound is 0.45359237 kg (1959).
const NEWTONS: [(&str, f64); 6] =
    [("N", 1.0), ("mN", 1e-3), ("kN", 1e3), ("gf", 9.80665e-3), ("kgf", 9.80665), ("lbf", 4.4482216152605)];

impl Mapping {
    /// Reads a mapping file.
    ///
    /// # Errors
    /// [`InputError`] with line and field if its content is not allowed, or if it cannot be read.
    pub fn load(path: &Path) -> Result<Self, InputError> {
        let text = read_text(path, &TEXT_BYTES, "a mapping file (TOML, UTF-8)", "check the path")?;
        let allowed = "the keys that `underbrush schema mapping` lists";
        let file: MappingFile = parse_toml(path, &text, "mapping", allowed)?;
        let trial = &file.trial;
        let threshold_n = trial.threshold_n.unwrap_or(0.03);
        let grid = file.grid.as_ref();
        let grid = grid.map(|own| Grid { rows: own.rows as usize, columns: own.columns as usize, wraps: own.wraps });
        let mut mapping = Mapping {
            path: path.to_path_buf(),
            text,
            per_second: 1.0,
            newton: (1.0, file.force.offset_n.unwrap_or(0.0)),
            grid,
            threshold_n,
            release_n: trial.release_n.unwrap_or(threshold_n),
            gap_s: trial.gap_s.unwrap_or(0.0),
            min_samples: trial.min_samples.unwrap_or(1) as usize,
            file,
        };
        mapping.check()?;
        mapping.per_second = mapping.unit("time.unit", mapping.file.time.unit.as_deref(), &PER_SECOND)?;
        let unit = mapping.unit("force.unit", mapping.file.force.unit.as_deref(), &NEWTONS)?;
        mapping.newton.0 = mapping.file.force.scale_n.unwrap_or(unit);
        Ok(mapping)
    }

    /// The factor of a unit; 1 if none is given.
    fn unit(&self, field: &str, name: Option<&str>, units: &[(&str, f64)]) -> Result<f64, InputError> {
        let Some(name) = name else { return Ok(1.0) };
        let known = units.iter().find(|(unit, _)| *unit == name);
        known.map(|(_, factor)| *factor).ok_or_else(|| {
            let names: Vec<&str> = units.iter().map(|(unit, _)| *unit).collect();
            self.fault(field, format!("{name:?}"), names.join(", "))
        })
    }

    fn check(&self) -> Result<(), InputError> {
        let MappingFile { time, force, trial, label: labels, channel: channels, .. } = &self.file;
        let numbers = [
            ("time.rate_hz", time.rate_hz, RATE_HZ),
            ("force.taxels", force.taxels.map(f64::from), TAXELS),
            ("force.scale_n", force.scale_n, SCALE_N),
            ("force.offset_n", force.offset_n, OFFSET_N),
            ("trial.threshold_n", trial.threshold_n, THRESHOLD_N),
            ("trial.release_n", trial.release_n, Limits::new(THRESHOLD_N.min, self.threshold_n, "N")),
            ("trial.gap_s", trial.gap_s, GAP_S),
        ];
        let given = numbers.into_iter().filter_map(|(field, number, limits)| Some((field, number?, limits)));
        if let Some((field, found, allowed)) = first_outside(given) {
            return Err(self.fault(field, found, allowed));
        }
        let is_rate_alone = time.rate_hz.is_some() && time.from.is_none();
        let pairs = [
            ("time.rate_hz", is_rate_alone, "time.unit", time.unit.is_some()),
            ("force.unit", force.unit.is_some(), "force.scale_n", force.scale_n.is_some()),
            ("trial.category", trial.category.is_some(), "trial.category_from", trial.category_from.is_some()),
        ];
        for (one, has_one, other, has_other) in pairs {
            if has_one && has_other {
                return Err(self.fault(other, format!("{one}, too"), format!("one of {one} and {other}")));
            }
        }
        if let Some(Grid { rows, columns, .. }) = self.grid {
            let taxels = self.taxels();
            if rows.checked_mul(columns) != Some(taxels) {
                let found = format!("{rows} x {columns}");
                return Err(self.fault("grid.rows", found, format!("a grid of {taxels} taxels")));
            }
        }
        for (number, own) in channels.iter().enumerate() {
            let field = format!("channel[{number}].name");
            // As features are named, and as cells are read.
            let is_name = is_plain(&own.name) && !own.name.contains(['+', ',']) && own.name.trim() == &*own.name;
            if own.name.is_empty() || !is_name || TRIAL_COLUMNS.contains(&&*own.name) {
                let allowed = "a name that no column of trials has, without `+`, commas and spaces around it";
                return Err(self.fault(&field, format!("{:?}", own.name), allowed));
            }
            if channels[..number].iter().any(|before| before.name == own.name) {
                return Err(self.fault(&field, format!("{:?} again", own.name), "one channel of each name"));
            }
        }
        let span = |own: &Label| format!("{} to {}", short(own.from_s), short(own.to_s));
        for (number, own) in labels.iter().enumerate() {
            if own.from_s.partial_cmp(&own.to_s) != Some(Ordering::Less) {
                return Err(self.fault(&format!("label[{number}].to_s"), span(own), "a time after from_s"));
            }
            let overlaps =
                |other: &&Label| other.reach == own.reach && other.from_s < own.to_s && own.from_s < other.to_s;
            if let Some(other) = labels[..number].iter().find(overlaps) {
                let found = format!("{}, which overlaps {}", span(own), span(other));
                let allowed = "times that no other label of the reach has";
                return Err(self.fault(&format!("label[{number}].from_s"), found, allowed));
            }
        }
        if !labels.is_empty() && trial.category_from.is_some() {
            let allowed = "one of category_from and [[label]]";
            return Err(self.fault("trial.category_from", "[[label]], too".into(), allowed));
        }
        let of_labels =
            labels.iter().enumerate().map(|(number, own)| (format!("label[{number}].category"), &own.category));
        let of_all = trial.category.iter().map(|name| ("trial.category".to_owned(), name));
        for (field, name) in of_all.chain(of_labels) {
            let empty = name.is_empty().then_some("a name");
            if let Some(allowed) = empty.or_else(|| Category::name_fault(name)) {
                return Err(self.fault(&field, format!("{name:?}"), allowed));
            }
        }
        let is_name =
            |name: &&str| !name.contains('/') && is_plain(name) && (1..=NAME_BYTES.most).contains(&(name.len() as u64));
        if let Some(patch) = trial.patch.as_deref().filter(|name| !is_name(name)) {
            let allowed = format!("a name without `/` and control characters, of 1 to {} bytes", NAME_BYTES.most);
            return Err(self.fault("trial.patch", format!("{patch:?}"), allowed));
        }
        Ok(())
    }

    /// An error about a field `table.key`, with the line that sets it.
    pub(super) fn fault(&self, field: &str, found: String, allowed: impl Into<String>) -> InputError {
        let (table, key) = field.rsplit_once('.').unwrap_or(("", field));
        let remedy = match line_setting(&self.text, field) {
            Some(_) => format!("change `{key}` in {}", self.path.display()),
            None => format!("add `{key}` to [{table}] in {}", self.path.display()),
        };
        InputError::new(&self.path, field, found, allowed, remedy).at_line(self.line(field))
    }

    /// The line, from 1, that sets a field `table.key`, or `table[N].key` of a list of tables; the line of the table if the key
    /// is not set, and 1 if there is no such table.
    fn line(&self, field: &str) -> usize {
        let table = field.split('.').next().unwrap_or(field);
        [field, table].iter().find_map(|name| line_setting(&self.text, name)).unwrap_or(1)
    }

    /// Number of taxels in a frame.
    pub(super) fn taxels(&self) -> usize {
        self.file.force.taxels.unwrap_or(1) as usize
    }

    /// The file with the places of the taxels, if the mapping names one.
    pub fn taxels_file(&self) -> Option<PathBuf> {
        self.file.skin.as_ref().map(|skin| self.path.with_file_name("").join(&skin.taxels))
    }

    /// The labels that cover a time of a reach: one of this reach, which counts first, and one of all reaches.
    pub(super) fn labels(&self, reach: u64, time_s: f64) -> [Option<usize>; 2] {
        let holds = |own: &Label| (own.from_s..own.to_s).contains(&time_s);
        [Some(reach), None].map(|of| self.file.label.iter().position(|own| own.reach == of && holds(own)))
    }

    /// The category of a label, or else that of all trials. Empty if neither is given.
    pub(super) fn category(&self, label: Option<usize>) -> &str {
        let category = label.map(|number| self.file.label[number].category.as_str());
        category.or(self.file.trial.category.as_deref()).unwrap_or_default()
    }

    /// A warning for each label that is not among those that cover a frame.
    pub(super) fn unused_labels(&self, used: &BTreeSet<usize>) -> Vec<String> {
        let warning = |(number, Label { from_s, to_s, category, .. }): (usize, &Label)| {
            let (line, path) = (self.line(&format!("label[{number}]")), self.path.display());
            let span = format!("{} to {} s", short(*from_s), short(*to_s));
            format!(
                "no frame is within the [[label]] of {category}, {span} ({path}:{line}): its times are those of the log in \
                 seconds, and its `reach` is a number of the log"
            )
        };
        self.file.label.iter().enumerate().filter(|(number, _)| !used.contains(number)).map(warning).collect()
    }

    /// A time of the file, s.
    pub(super) fn time_s(&self, time: f64) -> f64 {
        time / self.per_second
    }

    /// A reading as a force, N.
    pub(super) fn force_n(&self, reading: f64) -> f64 {
        reading * self.newton.0 + self.newton.1
    }
}
