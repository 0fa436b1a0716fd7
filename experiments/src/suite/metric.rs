//! The metrics that a suite can bound. Each has one value per reach, or none if it cannot be measured in that reach.

use serde::Serialize;
use underbrush_classifier::evaluate::{self, JudgedObject, Stream, Tally};
use underbrush_classifier::touch::TouchVerdict;
use underbrush_recording::math::{larger, median};
use underbrush_recording::{Category, ContactForces, Recording};
use underbrush_sim::audit;

/// How the values of all reaches become one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Statistic {
    /// Their mean.
    Mean,
    /// Their mean; each is a share from 0 to 1.
    Share,
    /// The largest.
    Largest,
}

impl Statistic {
    /// The largest value that a metric can have. None is negative.
    pub fn end(self) -> f64 {
        if self == Statistic::Share { 1.0 } else { f64::INFINITY }
    }
}

/// On which sides `--bless` bounds a metric for which the file has no bound yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// Any change matters.
    Both,
    /// More is better.
    AtLeast,
    /// Less is better.
    AtMost,
}

/// What a metric is computed from.
pub struct Measured<'a> {
    /// The reach.
    pub recording: &'a Recording,
    /// Number of goals that the scene gives.
    pub goals: u32,
    /// The verdicts, if the suite has a model.
    pub stream: Option<&'a Stream>,
    /// The objects that it touches, if the suite has a touch model.
    pub objects: &'a [JudgedObject],
}

/// A metric.
#[derive(Debug)]
pub struct Metric {
    /// Its key in suite files; the unit is in the name, and shares have none.
    pub name: &'static str,
    /// One sentence on its value in one reach.
    pub summary: &'static str,
    /// Whether it is measured for one category of objects.
    pub by_category: bool,
    /// Whether it needs the verdicts of a model.
    pub needs_model: bool,
    /// Whether that must be a touch model.
    pub needs_touch_model: bool,
    /// How the values of all reaches become one number.
    pub statistic: Statistic,
    /// Whether its values are counted, so that few reaches may agree by chance.
    pub counts: bool,
    /// On which sides it is bounded by default.
    pub sides: Sides,
    /// The upper bound, if it does not depend on what was found.
    pub limit: Option<f64>,
    /// Its value in one reach. `None` if it cannot be measured there, for example without contact with that category.
    pub of_reach: fn(&Measured, Option<Category>) -> Option<f64>,
}

const PLAIN: Metric = Metric {
    name: "",
    summary: "",
    by_category: false,
    needs_model: false,
    needs_touch_model: false,
    statistic: Statistic::Mean,
    counts: false,
    sides: Sides::Both,
    limit: None,
    of_reach: |_, _| None,
};
const LARGEST: Metric = Metric { statistic: Statistic::Largest, sides: Sides::AtMost, ..PLAIN };
const COUNTED_SHARE: Metric = Metric { statistic: Statistic::Share, counts: true, sides: Sides::AtLeast, ..PLAIN };
const FORCE: Metric = Metric { by_category: true, ..PLAIN };
const VERDICT: Metric =
    Metric { by_category: true, needs_model: true, statistic: Statistic::Share, sides: Sides::AtMost, ..PLAIN };
const TOUCH: Metric = Metric { needs_touch_model: true, ..VERDICT };

/// All metrics, in the order of the documentation.
///
/// ```
/// use underbrush_experiments::suite::metric::METRICS;
///
/// let shares = METRICS.iter().filter(|metric| metric.needs_model);
/// assert!(shares.clone().count() > 0);
/// assert!(METRICS.iter().all(|metric| !metric.summary.is_empty()));
/// ```
pub const METRICS: [Metric; 17] = [
    Metric {
        name: "audit",
        summary: "Largest error of the physics, each relative to the simulator's own bound for it",
        limit: Some(1.0),
        of_reach: |reach, _| Some(audit_share(reach.recording)),
        ..LARGEST
    },
    Metric {
        name: "overlap_without_patch_m",
        summary: "Largest overlap of two shapes, m, that should press on each other but for which no contact was found",
        limit: Some(0.0),
        of_reach: |reach, _| Some(reach.recording.audit.overlap_without_patch_m),
        ..LARGEST
    },
    Metric {
        name: "goals_reached",
        summary: "Share of the scene's goals that were reached",
        of_reach: |reach, _| Some(reach.recording.goal_outcomes().reached as f64 / f64::from(reach.goals.max(1))),
        ..COUNTED_SHARE
    },
    Metric {
        name: "touched",
        summary: "1 if the arm touches such an object at all, else 0",
        by_category: true,
        of_reach: |reach, category| Some(f64::from(reach.recording.contact_forces(category).contacts.min(1) as u8)),
        ..COUNTED_SHARE
    },
    Metric {
        name: "mean_force_n",
        summary: "Mean force between a link and such an object while they touch",
        of_reach: |reach, category| force(reach, category, |forces| forces.mean_n),
        ..FORCE
    },
    Metric {
        name: "peak_force_n",
        summary: "Largest force between a link and such an object",
        of_reach: |reach, category| force(reach, category, |forces| forces.peak_n),
        ..FORCE
    },
    Metric {
        name: "largest_force_n",
        summary: "The same, and the largest of all reaches counts instead of their mean",
        by_category: true,
        of_reach: |reach, category| force(reach, category, |forces| forces.peak_n),
        ..LARGEST
    },
    Metric {
        name: "taxel_force_n",
        summary: "Largest reading of a taxel on which such an object presses",
        of_reach: taxel_force_n,
        ..FORCE
    },
    Metric {
        name: "right",
        summary: "Share of the taxels in contact with such an object, over all frames, whose verdict is right; \
                  `right.outlier` is the share of outlier contact that is found",
        sides: Sides::AtLeast,
        of_reach: |reach, category| share(reach, category, |tally| tally.right),
        ..VERDICT
    },
    Metric {
        name: "wrong",
        summary: "Share of those taxels whose verdict is another category, outlier for what is not one, or nothing",
        of_reach: |reach, category| share(reach, category, |tally| tally.wrong),
        ..VERDICT
    },
    Metric {
        name: "uncertain",
        summary: "Share of those taxels that have no verdict yet",
        of_reach: |reach, category| share(reach, category, |tally| tally.uncertain),
        ..VERDICT
    },
    Metric {
        name: "called_outlier",
        summary: "Share of those taxels that are called an outlier",
        of_reach: |reach, category| share(reach, category, |tally| tally.unknown),
        ..VERDICT
    },
    Metric {
        name: "objects_called_unknown",
        summary: "Share of such objects whose last verdict is unknown, by a touch model; contacts of one place are one object",
        of_reach: objects_called_unknown,
        ..TOUCH
    },
    Metric {
        name: "called_nothing",
        summary: "Share of those taxels that are called nothing, which only a touch model does",
        of_reach: |reach, category| share(reach, category, |tally| tally.nothing),
        ..TOUCH
    },
    Metric {
        name: "spurious_called_nothing",
        summary: "Share of the taxels with a reading on which nothing presses, over all frames, that a touch model calls nothing",
        by_category: false,
        sides: Sides::AtLeast,
        of_reach: |reach, _| share(reach, None, |tally| tally.nothing),
        ..TOUCH
    },
    Metric {
        name: "samples_to_right",
        summary: "Median over the taxel contacts with such objects that are ever judged rightly: samples from the first \
                  reading above the threshold to the first right verdict",
        statistic: Statistic::Mean,
        counts: true,
        of_reach: samples_to_right,
        ..VERDICT
    },
    Metric {
        name: "taxels_per_frame",
        summary: "Mean number of taxels that the classifier updates in a frame with contact",
        by_category: false,
        statistic: Statistic::Mean,
        of_reach: taxels_per_frame,
        ..VERDICT
    },
];

impl Metric {
    /// The metric with this name.
    pub fn find(name: &str) -> Option<&'static Metric> {
        static LIST: [Metric; METRICS.len()] = METRICS;
        LIST.iter().find(|metric| metric.name == name)
    }
}

fn audit_share(recording: &Recording) -> f64 {
    // A figure with a bound of 0 is a metric of its own.
    let bounds = audit::bounds(&recording.layout).filter(|bound| bound.max > 0.0);
    let shares = bounds.map(|bound| (bound.field.get)(&recording.audit) / bound.max);
    shares.fold(0.0, larger)
}

fn force(reach: &Measured, category: Option<Category>, value: fn(&ContactForces) -> f64) -> Option<f64> {
    let forces = reach.recording.contact_forces(category);
    (forces.contacts > 0).then(|| value(&forces))
}

fn taxel_force_n(reach: &Measured, category: Option<Category>) -> Option<f64> {
    let category = category?;
    let readings = reach.recording.frames.iter().flat_map(|frame| &frame.taxels);
    let presses = |object: u16| reach.recording.category_of(object) == Some(category);
    let pressed = readings.filter(|reading| reading.object.is_some_and(presses));
    pressed.map(|reading| reading.sensed_force_n).reduce(f64::max)
}

/// A share of the taxels in contact with objects of a category, or with nothing.
fn share(reach: &Measured, truth: Option<Category>, part: fn(&Tally) -> usize) -> Option<f64> {
    let tally = reach.stream?.tally_of(truth);
    tally.share(part(&tally))
}

fn objects_called_unknown(reach: &Measured, category: Option<Category>) -> Option<f64> {
    let category = category?;
    let own: Vec<&JudgedObject> = reach.objects.iter().filter(|own| own.truth == category.name()).collect();
    let called = own.iter().filter(|own| own.at_end == TouchVerdict::Unknown.name(&[])).count();
    evaluate::share(called, own.len())
}

fn samples_to_right(reach: &Measured, category: Option<Category>) -> Option<f64> {
    let contacts = reach.stream?.contacts.iter().filter(|contact| Some(contact.truth) == category);
    median(contacts.filter_map(|contact| contact.first_right).map(|samples| samples as f64).collect())
}

fn taxels_per_frame(reach: &Measured, _: Option<Category>) -> Option<f64> {
    let taxels = reach.stream?.frames.iter().map(|frame| frame.in_contact as f64);
    evaluate::mean(taxels.filter(|taxels| *taxels > 0.0))
}
