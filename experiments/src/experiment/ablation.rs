//! Ablation: the cross-validation table with one thing changed at a time.

use serde::{Deserialize, Serialize};
use underbrush_classifier::trial::{Labels, TrialOptions};
use underbrush_recording::Fault;
use underbrush_sim::scene::SceneFile;
use underbrush_sim::sensor::SensorModel;

use super::table_one;
use super::training_data::{self, TrialsPerReach};
use crate::accuracy::{Accuracy, Figures};
use crate::definition::{AblationName, Experiment, Unit};
use crate::table_cell::{mean_difference, orderings};
use crate::training::{self, Trials};
use crate::{Cell, Session};

/// The results of the ablation.
#[derive(Serialize)]
pub struct AblationResults {
    /// First without a change, then with each change. Empty if the experiment has none.
    pub ablation: Vec<Ablated>,
}

/// The table with one thing changed, in the first recipe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ablated {
    /// Name of the change.
    pub change: String,
    /// Mean absolute difference from the published cells, points; `None` if none are published.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean_absolute_difference_points: Option<f64>,
    /// Number of published statements that hold in all their pairs of cells.
    pub orderings_holding: usize,
    /// Number of statements.
    pub orderings: usize,
    /// Pairs of cells in the published order.
    pub pairs_holding: usize,
    /// Number of pairs.
    pub pairs: usize,
    /// Means over the component cells, per cent.
    pub component: Option<Figures<f64>>,
    /// Means over the taxel cells, per cent.
    pub taxel: Option<Figures<f64>>,
    /// Trials per reach.
    pub trials_per_reach: Vec<TrialsPerReach>,
    /// The cells.
    pub table_1: Vec<Cell>,
}

/// Name of the row without a change.
pub const AS_IS: &str = "as is";

/// The effect of a change.
enum Change {
    /// Trials are extracted from the same reaches in another way.
    Cut(fn(TrialOptions) -> TrialOptions),
    /// The reaches are simulated with a changed scene.
    Scene(fn(&mut SceneFile)),
}

/// Name of a change in tables, and its effect.
pub fn described(name: AblationName) -> (&'static str, &'static str) {
    match name {
        AblationName::LabelsByContact => (
            "labels by contact",
            "a trial's category is that of the object that touches the taxel, not that of the scene",
        ),
        AblationName::TrialsOfAnyLength => {
            ("trials of any length", "trials with fewer samples than a model has states are kept")
        }
        AblationName::NoSpuriousReadings => ("no spurious readings", "untouched taxels read no force"),
        AblationName::NoCreep => ("no creep", "a taxel reads nothing after a contact has ended"),
        AblationName::PerfectSensor => ("perfect sensor", "the sensed force is the true force"),
        AblationName::NoPatience => {
            ("no patience limit", "the controller's own rule ends a goal, and each goal is retried once")
        }
    }
}

fn change(name: AblationName) -> Change {
    match name {
        AblationName::LabelsByContact => Change::Cut(|options| TrialOptions { labels: Labels::Contact, ..options }),
        AblationName::TrialsOfAnyLength => Change::Cut(|options| TrialOptions { min_samples: 1, ..options }),
        AblationName::NoSpuriousReadings => Change::Scene(|scene| scene.sensor.spurious_share = 0.0),
        AblationName::NoCreep => Change::Scene(|scene| scene.sensor.creep_share_per_decade = 0.0),
        AblationName::PerfectSensor => Change::Scene(|scene| scene.sensor.model = SensorModel::Ideal),
        AblationName::NoPatience => Change::Scene(|scene| {
            scene.goals.patience_s = None;
            scene.goals.retries = 1;
        }),
    }
}

impl Ablated {
    /// A row of the first recipe's cells.
    pub fn new(
        experiment: &Experiment,
        change: &str,
        cells: impl IntoIterator<Item = Cell>,
        trials_per_reach: Vec<TrialsPerReach>,
    ) -> Self {
        let recipe = experiment.main_recipe_name().name();
        let table_1: Vec<Cell> = cells.into_iter().filter(|cell| cell.key.recipe == recipe).collect();
        let of = |unit: Unit| {
            let own: Vec<&Accuracy> =
                table_1.iter().filter(|cell| cell.key.by == unit).map(|cell| &cell.figures).collect();
            let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
            (!own.is_empty()).then(|| Figures::over(&own, Accuracy::figures, mean))
        };
        let orderings = orderings(experiment, &table_1, |own| own.accuracy);
        Ablated {
            change: change.into(),
            mean_absolute_difference_points: mean_difference(&table_1, |own| own.accuracy).remove(recipe),
            orderings_holding: orderings.iter().filter(|ordering| ordering.holds).count(),
            orderings: orderings.len(),
            pairs_holding: orderings.iter().map(|ordering| ordering.pairs_holding).sum(),
            pairs: orderings.iter().map(|ordering| ordering.pairs).sum(),
            component: of(Unit::Component),
            taxel: of(Unit::Taxel),
            trials_per_reach,
            table_1,
        }
    }
}

/// The table without a change, and with each of the experiment's changes.
pub fn run(session: &Session) -> Result<AblationResults, Fault> {
    let experiment = session.experiment;
    if experiment.file.ablation.is_empty() {
        return Ok(AblationResults { ablation: Vec::new() });
    }
    let (data, as_is) = (session.once(training::run)?, session.once(table_one::run)?);
    let counted = session.once(training_data::run)?;
    let reaches = training::reaches(experiment);
    let rows = || {
        let trials_per_reach = counted.trials_per_reach.clone();
        let mut rows = vec![Ablated::new(experiment, AS_IS, as_is.table_1.clone(), trials_per_reach)];
        for name in &experiment.file.ablation {
            let trials = match change(*name) {
                Change::Cut(options) => {
                    Trials::of_dataset(session, &data.dataset, &options(experiment.trial_options()))?
                }
                Change::Scene(change) => {
                    let campaign = training::campaign(experiment, session.seed, &reaches, change)?;
                    Trials::of_campaign(experiment, &campaign, session.progress)?
                }
            };
            // Classifiers that know fewer categories are right more easily, so there are no cells then.
            let cells = match trials.check_labels(experiment) {
                Ok(()) => table_one::evaluate(experiment, &trials, &[experiment.main_recipe_name()])?,
                Err(fault) => {
                    session.progress.remark(&format!("{}: {fault}", described(*name).0));
                    Vec::new()
                }
            };
            let cells = cells.into_iter().map(|(cell, _)| cell);
            let trials_per_reach = training_data::per_reach(experiment, &trials);
            rows.push(Ablated::new(experiment, described(*name).0, cells, trials_per_reach));
        }
        Ok(rows)
    };
    let ablation = session.stage("Ablation", || session.kept("ablation", session.seed, rows))?;
    Ok(AblationResults { ablation })
}
