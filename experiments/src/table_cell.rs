//! Cells of the cross-validation table (the paper's Table I), and how they compare with each other and with published
//! figures.

use std::collections::{BTreeMap, BTreeSet};
use std::mem::replace;

use serde::{Deserialize, Serialize};
use underbrush_classifier::feature::FeatureSet;
use underbrush_recording::distinct;

use crate::accuracy::Accuracy;
use crate::definition::{Experiment, OrderingName, Unit};

/// A cell of the table, of one campaign or of many.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Cell<F = Accuracy> {
    /// Which cell.
    #[serde(flatten)]
    pub key: CellKey,
    /// Its figures here.
    #[serde(flatten)]
    pub figures: F,
    /// The published accuracy, per cent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paper: Option<f64>,
}

/// Which cell of the table, in which recipe.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CellKey {
    /// What a trial is made of.
    pub by: Unit,
    /// Features that the models use.
    pub features: FeatureSet,
    /// Number of hidden states.
    pub states: usize,
    /// Name of the recipe.
    pub recipe: String,
}

impl CellKey {
    /// The cell without its recipe, as text.
    pub fn name(&self) -> String {
        let (by, features, states) = (self.by.name(), self.features, self.states);
        format!("{by}, {features}, {states} {}", if states == 1 { "state" } else { "states" })
    }

    /// The cell with its recipe, as text.
    pub fn with_recipe(&self) -> String {
        format!("{}, {} recipe", self.name(), possessive(&self.recipe))
    }
}

/// The name of a recipe as it stands before the word "recipe": `authors'` or `modern`.
pub fn possessive(recipe: &str) -> &str {
    if recipe == "authors" { "authors'" } else { recipe }
}

/// A published statement on the table, and whether it holds here.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Ordering {
    /// Name of the recipe.
    pub recipe: String,
    /// The statement.
    pub statement: String,
    /// Whether it holds in every pair of cells.
    pub holds: bool,
    /// Pairs of cells that it compares.
    pub pairs: usize,
    /// Pairs in which it holds.
    pub pairs_holding: usize,
    /// The pairs in which it does not hold.
    pub failing: Vec<String>,
}

/// A key with its accuracy, per cent.
type KeyedAccuracy<'a> = (&'a CellKey, f64);

/// Mean absolute difference of the cells from the published ones, by recipe, points. Cells without a published figure do not
/// count.
///
/// ```
/// use underbrush_classifier::FeatureSet;
/// use underbrush_experiments::table_cell::mean_difference;
/// use underbrush_experiments::{Cell, CellKey, Unit};
///
/// let cells = [(80.0, Some(82.0)), (91.0, Some(90.0)), (70.0, None)].map(|(figures, paper)| {
///     let key = CellKey { by: Unit::Taxel, features: FeatureSet::FORCE, states: 10, recipe: "authors".into() };
///     Cell { key, figures, paper }
/// });
/// assert_eq!(mean_difference(&cells, |accuracy| *accuracy)["authors"], 1.5);
/// ```
pub fn mean_difference<F>(cells: &[Cell<F>], accuracy: fn(&F) -> f64) -> BTreeMap<String, f64> {
    let mut sums: BTreeMap<String, (f64, usize)> = BTreeMap::new();
    for cell in cells {
        let Some(published) = cell.paper else { continue };
        let (sum, count) = sums.entry(cell.key.recipe.clone()).or_default();
        *sum += (accuracy(&cell.figures) - published).abs();
        *count += 1;
    }
    let mean = |(recipe, (sum, count)): (String, (f64, usize))| (recipe, sum / count as f64);
    sums.into_iter().map(mean).collect()
}

/// Checks the published statements on the cells of one or more recipes. A pair with a missing cell does not count,
/// and a statement without any pair is left out.
pub fn orderings<F>(experiment: &Experiment, cells: &[Cell<F>], accuracy: fn(&F) -> f64) -> Vec<Ordering> {
    let statements = experiment.published().map_or(&[][..], |own| &own.orderings);
    let cells: Vec<KeyedAccuracy> = cells.iter().map(|cell| (&cell.key, accuracy(&cell.figures))).collect();
    let recipes = distinct(cells.iter().map(|(key, _)| &key.recipe));
    let check = |recipe: &String, name: OrderingName| {
        let own: Vec<&KeyedAccuracy> = cells.iter().filter(|(key, _)| key.recipe == *recipe).collect();
        let states: BTreeSet<usize> = own.iter().map(|(key, _)| key.states).collect();
        let (statement, strict) = statement(name, &states);
        let (mut pairs, mut failing) = (0, Vec::new());
        for (high_key, high) in own.iter().copied() {
            let lower = lower(name, high_key, &states);
            for (low_key, low) in own.iter().copied().filter(|(key, _)| lower.as_ref() == Some(*key)) {
                pairs += 1;
                if !(high > low || (!strict && high == low)) {
                    failing.push(format!("{} {high:.1} %, {} {low:.1} %", high_key.name(), low_key.name()));
                }
            }
        }
        (pairs > 0).then(|| Ordering {
            recipe: recipe.clone(),
            statement,
            holds: failing.is_empty(),
            pairs,
            pairs_holding: pairs - failing.len(),
            failing,
        })
    };
    let of_recipe = |recipe| statements.iter().filter_map(move |name| check(recipe, *name));
    recipes.into_iter().flat_map(of_recipe).collect()
}

/// A statement as text, and whether equal accuracies contradict it.
fn statement(name: OrderingName, states: &BTreeSet<usize>) -> (String, bool) {
    match name {
        OrderingName::TaxelsOverComponents => ("taxels are told apart better than components".into(), true),
        OrderingName::ForceOverForceAndMotion => ("force alone is at least as good as force and motion".into(), false),
        OrderingName::MoreStates => {
            let mut states = states.iter().map(usize::to_string);
            let fewest = states.next().unwrap_or_default();
            let more = match states.collect::<Vec<_>>().as_slice() {
                [] => "more".to_owned(),
                [one] => one.clone(),
                [others @ .., most] => format!("{} and {most}", others.join(", ")),
            };
            (format!("{more} states are better than {fewest}"), true)
        }
    }
}

/// The cell of which a statement says that its accuracy is lower than that of this one, if it says so of any.
fn lower(name: OrderingName, high: &CellKey, states: &BTreeSet<usize>) -> Option<CellKey> {
    let fewest = *states.first()?;
    let mut low = high.clone();
    let is_higher = match name {
        OrderingName::TaxelsOverComponents => replace(&mut low.by, Unit::Component) == Unit::Taxel,
        OrderingName::ForceOverForceAndMotion => {
            replace(&mut low.features, FeatureSet::FORCE_AND_MOTION) == FeatureSet::FORCE
        }
        OrderingName::MoreStates => replace(&mut low.states, fewest) > fewest,
    };
    is_higher.then_some(low)
}
