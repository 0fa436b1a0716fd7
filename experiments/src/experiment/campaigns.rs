//! Several independent campaigns, from successive seeds: mean and spread of the cross-validation table, the trial
//! counts and the comparison of classifiers.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use underbrush_recording::Fault;

use super::classifiers::{self, Compared};
use super::table_one;
use super::training_data::{self, TrialsPerReach};
use crate::accuracy::{Accuracy, Figures, Part, Spread};
use crate::table_cell::{Cell, Ordering, mean_difference, orderings};
use crate::training::{self, Trials};
use crate::{Experiment, Session, Unit};

/// The campaigns; `None` if only one was requested.
#[derive(Serialize)]
pub struct ComparedCampaigns {
    /// Means and spreads.
    pub campaigns: Option<Campaigns>,
}

/// Means and spreads over campaigns.
#[derive(Serialize)]
pub struct Campaigns {
    /// The campaigns' seeds.
    pub seeds: Vec<u64>,
    /// The cross-validation table.
    pub table_1: Vec<Cell<CampaignFigures>>,
    /// By recipe: mean absolute difference of the mean cells from the published ones.
    pub mean_absolute_difference_points: BTreeMap<String, f64>,
    /// Published statements on the mean cells.
    pub orderings: Vec<Ordering>,
    /// Trials per reach.
    pub trials_per_reach: Vec<CampaignTrials>,
    /// Other classifiers.
    pub classifiers: Vec<Compared<CampaignFigures>>,
}

/// The figures of a cell over campaigns.
#[derive(Serialize)]
pub struct CampaignFigures {
    /// The figures of all trials.
    #[serde(flatten)]
    pub all: Figures<Spread>,
    /// The figures of the trials in which something truly touched the skin; `None` if no campaign has such trials.
    pub touched: Option<Figures<Spread>>,
    /// The figures of the other trials; `None` if no campaign has such trials.
    pub untouched: Option<Figures<Spread>>,
}

/// Trials per reach over campaigns.
#[derive(Serialize)]
pub struct CampaignTrials {
    /// What a trial is made of.
    pub by: Unit,
    /// The label.
    pub category: String,
    /// Trials per reach.
    pub per_reach: Spread,
    /// The published number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paper: Option<f64>,
}

/// The results of one campaign that enter the mean of many.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OneOfMany {
    /// Trials per reach.
    pub trials_per_reach: Vec<TrialsPerReach>,
    /// The cross-validation table.
    pub table_1: Vec<Cell>,
    /// Other classifiers.
    pub classifiers: Vec<Compared>,
}

/// Runs the further campaigns. Each campaign's result is cached.
pub fn run(session: &Session) -> Result<ComparedCampaigns, Fault> {
    if session.campaigns < 2 {
        return Ok(ComparedCampaigns { campaigns: None });
    }
    let first = OneOfMany {
        trials_per_reach: session.once(training_data::run)?.trials_per_reach.clone(),
        table_1: session.once(table_one::run)?.table_1.clone(),
        classifiers: session.once(classifiers::run)?.classifiers.clone(),
    };
    session.stage("Further campaigns", || {
        let count = session.progress.count("further campaigns", session.campaigns - 1, 0);
        let mut measured = vec![(session.seed, first)];
        for number in 1..session.campaigns {
            let seed = session.seed.wrapping_add(number);
            measured.push((seed, session.kept("seed", seed, || measure(session, seed))?));
            count.advance();
        }
        Ok(ComparedCampaigns { campaigns: Campaigns::of(session.experiment, &measured)? })
    })
}

/// Runs the campaign of one seed, unless it is cached, and caches it where [`run`] finds it. This way campaigns can be
/// run on other machines.
///
/// # Errors
/// Those of its stages, or a file that cannot be written.
pub fn run_one(session: &Session, seed: u64) -> Result<(), Fault> {
    session.kept("seed", seed, || measure(session, seed)).map(drop)
}

/// The campaign of a seed.
fn measure(session: &Session, seed: u64) -> Result<OneOfMany, Fault> {
    let experiment = session.experiment;
    let campaign = training::campaign(experiment, seed, &training::reaches(experiment), |_| {})?;
    let trials = Trials::of_campaign(experiment, &campaign, session.progress)?;
    trials.check_labels(experiment)?;
    let cells = table_one::evaluate(experiment, &trials, &experiment.file.recipes)?;
    Ok(OneOfMany {
        trials_per_reach: training_data::per_reach(experiment, &trials),
        table_1: cells.into_iter().map(|(cell, _)| cell).collect(),
        classifiers: classifiers::compare(experiment, &trials.taxel)?,
    })
}

impl Campaigns {
    /// Means and spreads over campaigns, each with its seed; `None` without campaigns. Figures are matched by name.
    pub fn of(experiment: &Experiment, campaigns: &[(u64, OneOfMany)]) -> Result<Option<Self>, Fault> {
        let Some((_, first)) = campaigns.first() else { return Ok(None) };
        let mut table_1 = Vec::new();
        for Cell { key, paper, .. } in &first.table_1 {
            let name = format!("cross-validation, {}", key.with_recipe());
            let own = matched(campaigns, &name, |campaign| &campaign.table_1, |cell| cell.key == *key)?;
            let figures = CampaignFigures::of(own.iter().map(|cell| &cell.figures));
            table_1.push(Cell { key: key.clone(), figures, paper: *paper });
        }
        let mut trials_per_reach = Vec::new();
        for row in &first.trials_per_reach {
            let name = format!("trials per reach, {}, {}", row.by.name(), row.category);
            let is_same = |other: &TrialsPerReach| (other.by, &other.category) == (row.by, &row.category);
            let own = matched(campaigns, &name, |campaign| &campaign.trials_per_reach, is_same)?;
            trials_per_reach.push(CampaignTrials {
                by: row.by,
                category: row.category.clone(),
                per_reach: Spread::of(&own.iter().map(|row| row.per_reach).collect::<Vec<_>>()),
                paper: row.paper,
            });
        }
        let mut classifiers = Vec::new();
        for Compared { classifier, .. } in &first.classifiers {
            let is_same = |own: &Compared| own.classifier == *classifier;
            let own = matched(campaigns, classifier, |campaign| &campaign.classifiers, is_same)?;
            let figures = CampaignFigures::of(own.iter().map(|own| &own.figures));
            classifiers.push(Compared { classifier: classifier.clone(), figures });
        }
        Ok(Some(Campaigns {
            seeds: campaigns.iter().map(|(seed, _)| *seed).collect(),
            mean_absolute_difference_points: mean_difference(&table_1, |own| own.all.accuracy.mean),
            orderings: orderings(experiment, &table_1, |own| own.all.accuracy.mean),
            trials_per_reach,
            classifiers,
            table_1,
        }))
    }
}

/// The one result of this name in each campaign.
fn matched<'a, T>(
    campaigns: &'a [(u64, OneOfMany)],
    name: &str,
    results: fn(&OneOfMany) -> &Vec<T>,
    is_named: impl Fn(&T) -> bool,
) -> Result<Vec<&'a T>, Fault> {
    let one = |(seed, campaign): &'a (u64, OneOfMany)| {
        let mut found = results(campaign).iter().filter(|own| is_named(own));
        match (found.next(), found.next()) {
            (Some(figure), None) => Ok(figure),
            (first, _) => {
                let found = if first.is_some() { "several results" } else { "nothing" };
                Err(Fault::Run(format!(
                    "the campaign of seed {seed} has {found} under the name {name:?} where one is needed; start again with \
                     --force"
                )))
            }
        }
    };
    campaigns.iter().map(one).collect()
}

impl CampaignFigures {
    fn of<'a>(accuracies: impl Iterator<Item = &'a Accuracy>) -> Self {
        let accuracies: Vec<&Accuracy> = accuracies.collect();
        let part = |of: fn(&Accuracy) -> Option<&Part>| {
            let parts: Vec<&Part> = accuracies.iter().filter_map(|own| of(own)).collect();
            (!parts.is_empty()).then(|| Figures::over(&parts, Part::figures, Spread::of))
        };
        CampaignFigures {
            all: Figures::over(&accuracies, Accuracy::figures, Spread::of),
            touched: part(|own| own.touched.as_ref()),
            untouched: part(|own| own.untouched.as_ref()),
        }
    }
}
