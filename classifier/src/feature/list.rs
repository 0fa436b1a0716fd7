//! The list of features that a classifier can use of each sample.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::{LazyLock, Mutex, PoisonError};

use underbrush_recording::limits::{self, Limits};
use underbrush_recording::{Sample, TRIAL_COLUMNS, is_plain};

/// One number per sample: its name, its range with the unit, and how it is read.
pub struct Feature {
    /// Name on the command line.
    pub name: &'static str,
    /// Column in trial tables, and name in model files. It ends in the unit, if there is one.
    pub column: &'static str,
    /// What it is, in one line.
    pub description: &'static str,
    /// The possible values, and their unit.
    pub limits: Limits,
    /// Factor that scales typical values to about one, for classifiers that do not standardize their input.
    pub to_order_one: f64,
    /// Reads the value of the column from a sample; `None` if the sample has no such value.
    pub(super) read: fn(&Sample, column: &str) -> Option<f64>,
    /// Whether it describes the contact region. If so, live data need a patch whose taxels form a grid.
    pub of_region: bool,
}

/// Sensed force on the taxel. Forces of incidental contact are around 1 N.
pub const FORCE: Feature = Feature {
    name: "force",
    column: "force_n",
    description: "sensed force, N: of the taxel, or the largest in the component",
    limits: limits::FORCE_N,
    to_order_one: 1.0,
    read: |sample, _| Some(sample.force_n),
    of_region: false,
};

/// Path length of the contact since it began. Contacts slide for centimetres.
pub const MOTION: Feature = Feature {
    name: "motion",
    column: "motion_m",
    description: "contact motion, m: how far the contact has travelled since it began",
    limits: limits::MOTION_M,
    to_order_one: 100.0,
    read: |sample, _| sample.motion_m,
    of_region: false,
};

/// Contact area as the number of taxels in contact. Regions have about ten taxels at most.
pub const AREA: Feature = Feature {
    name: "area",
    column: "region_taxels",
    description: "contact area: number of taxels in the contact region",
    limits: limits::REGION_TAXELS,
    to_order_one: 0.1,
    read: |sample, _| sample.region.map(|region| f64::from(region.taxels)),
    of_region: true,
};

/// Largest sensed force in the contact region.
pub const REGION_MAX_FORCE: Feature = Feature {
    name: "region-max-force",
    column: "region_largest_force_n",
    description: "largest sensed force in the contact region, N",
    limits: limits::REGION_LARGEST_FORCE_N,
    to_order_one: 1.0,
    read: |sample, _| sample.region.map(|region| region.largest_force_n),
    of_region: true,
};

/// Sum of the sensed forces in the contact region.
pub const REGION_FORCE_SUM: Feature = Feature {
    name: "region-force-sum",
    column: "region_force_sum_n",
    description: "sum of the sensed forces in the contact region, N",
    limits: limits::REGION_FORCE_SUM_N,
    to_order_one: 0.1,
    read: |sample, _| sample.region.map(|region| region.force_sum_n),
    of_region: true,
};

/// All features but channels. To add one, write its entry above and name it here.
pub const FEATURES: [&Feature; 5] = [&FORCE, &MOTION, &AREA, &REGION_MAX_FORCE, &REGION_FORCE_SUM];

/// What the name of a channel begins with.
pub(super) const CHANNEL: &str = "column:";

/// The channels that were named so far. A feature lives as long as the program, so that sets of features can be copied.
static CHANNELS: LazyLock<Mutex<BTreeMap<String, &'static Feature>>> = LazyLock::new(Mutex::default);

impl Feature {
    /// The feature with this name or column, or with `column:NAME` that of the column NAME of a table of trials
    /// ([`underbrush_recording::Channels`]). NAME has neither `+` nor `,`, which stand between the features of a set, and is not a
    /// column that says what a trial is.
    pub fn find(name: &str) -> Option<&'static Feature> {
        let column = name.strip_prefix(CHANNEL);
        let listed = FEATURES.into_iter().find(|feature| match column {
            Some(column) => feature.column == column,
            None => feature.name == name || feature.column == name,
        });
        let is_name = |column: &str| !column.is_empty() && !column.contains(['+', ',']) && is_plain(column);
        let is_sound = |column: &&str| is_name(column) && !TRIAL_COLUMNS.contains(column);
        listed.or_else(|| column.filter(is_sound).map(Feature::channel))
    }

    fn channel(column: &str) -> &'static Feature {
        let mut channels = CHANNELS.lock().unwrap_or_else(PoisonError::into_inner);
        channels.entry(column.to_owned()).or_insert_with(|| {
            let name: &'static str = Box::leak(format!("{CHANNEL}{column}").into_boxed_str());
            Box::leak(Box::new(Feature {
                name,
                column: &name[CHANNEL.len()..],
                description: "a channel of a table of trials",
                limits: Limits::new(f64::MIN, f64::MAX, ""),
                to_order_one: 1.0,
                read: |sample, column| sample.channels.get(column),
                of_region: false,
            }))
        })
    }

    /// Its value in a sample; `None` if the sample has no such value.
    pub fn read(&self, sample: &Sample) -> Option<f64> {
        (self.read)(sample, self.column)
    }

    /// Whether it is a channel: a column of a table of trials about which only the name is known.
    pub fn is_channel(&self) -> bool {
        self.name.starts_with(CHANNEL)
    }

    /// Its name in files of models.
    pub fn key(&self) -> &'static str {
        if self.is_channel() { self.name } else { self.column }
    }
}

impl fmt::Debug for Feature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

// No two features share a column, so it identifies them.
impl PartialEq for Feature {
    fn eq(&self, other: &Self) -> bool {
        self.column == other.column
    }
}

impl Eq for Feature {}
