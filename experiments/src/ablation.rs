//! What each part of reality is worth: Table I with one thing changed at a time.

use serde::{Deserialize, Serialize};
use underbrush_classifier::evaluate::TableOneUnit;
use underbrush_classifier::recipe::Recipe;
use underbrush_recording::disk::Dataset;

use crate::accuracy::Accuracy;
use crate::campaign::{self, AUTHORS, Trials};
use crate::comparison;
use crate::data::{CHANGES, Change};
use crate::error::ExperimentError;
use crate::measurement::{Cell, Measurement, TrialsPerReach};
use crate::progress::Progress;

/// The campaign with one thing changed, in the authors' recipe.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Ablated {
    pub change: String,
    /// From the paper, over the twelve cells, points.
    pub mean_absolute_difference_points: f64,
    /// The paper's orderings that hold in all their pairs of cells, and how many there are.
    pub orderings_holding: usize,
    pub orderings: usize,
    /// Pairs of cells in the paper's order, and how many there are.
    pub pairs_holding: usize,
    pub pairs: usize,
    /// Means over six cells each, per cent.
    pub component: MeanAccuracy,
    pub taxel: MeanAccuracy,
    pub trials_per_reach: Vec<TrialsPerReach>,
    pub table_1: Vec<Cell>,
}

/// Means over the cells of one unit, per cent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeanAccuracy {
    pub accuracy: f64,
    pub balanced_accuracy: f64,
    pub majority_baseline: f64,
}

/// The name of the row in which nothing is changed.
pub const AS_IS: &str = "as is";

impl Ablated {
    pub fn new(change: &str, cells: impl IntoIterator<Item = Cell>, trials_per_reach: Vec<TrialsPerReach>) -> Self {
        let table_1: Vec<Cell> = cells.into_iter().filter(|cell| cell.key.recipe == AUTHORS).collect();
        let difference = |cell: &Cell| (cell.accuracy.accuracy - cell.paper).abs();
        let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
        let of = |unit: TableOneUnit| {
            let over = |value: fn(&Accuracy) -> f64| {
                let own = table_1.iter().filter(|cell| cell.key.by == unit);
                mean(own.map(|cell| value(&cell.accuracy)).collect())
            };
            MeanAccuracy {
                accuracy: over(|own| own.accuracy),
                balanced_accuracy: over(|own| own.balanced_accuracy),
                majority_baseline: over(|own| own.majority_baseline),
            }
        };
        let orderings = comparison::orderings_of(table_1.iter().map(|cell| (&cell.key, cell.accuracy.accuracy)));
        Ablated {
            change: change.into(),
            mean_absolute_difference_points: mean(table_1.iter().map(difference).collect()),
            orderings_holding: orderings.iter().filter(|ordering| ordering.holds).count(),
            orderings: orderings.len(),
            pairs_holding: orderings.iter().map(|ordering| ordering.pairs_holding).sum(),
            pairs: orderings.iter().map(|ordering| ordering.pairs).sum(),
            component: of(TableOneUnit::Component),
            taxel: of(TableOneUnit::Taxel),
            trials_per_reach,
            table_1,
        }
    }
}

/// The campaign as it is, and with each of [`CHANGES`]; for runs of the paper's size.
pub fn run(
    seed: u64,
    dataset: &Dataset,
    as_is: &Measurement,
    progress: &dyn Progress,
) -> Result<Vec<Ablated>, ExperimentError> {
    let reaches = campaign::reaches(false);
    let mut rows = vec![Ablated::new(
        AS_IS,
        as_is.table_1.clone(),
        as_is.trials_per_reach.clone(),
    )];
    for (name, _, change) in CHANGES {
        let trials = match change {
            Change::Cut(options) => Trials::of_dataset(dataset, &options(), progress)?,
            Change::Scene(change) => {
                Trials::of_campaign(&campaign::changed_campaign(seed, reaches, change)?, progress)?
            }
        };
        let (cells, _) = trials.table_1(AUTHORS, &Recipe::authors())?;
        rows.push(Ablated::new(name, cells, trials.per_reach(reaches)));
    }
    Ok(rows)
}
