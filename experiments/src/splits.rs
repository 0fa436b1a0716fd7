//! Trained at one arm stiffness and hand speed, tested at others: the open question of the follow-up study
//! (arXiv 1409.4972).

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use underbrush_classifier::baseline::Logistic;
use underbrush_classifier::decision::Decision;
use underbrush_classifier::estimator::Estimator;
use underbrush_classifier::evaluate::{Evaluation, evaluate};
use underbrush_classifier::feature::FeatureSet;
use underbrush_classifier::recipe::Recipe;
use underbrush_recording::Trial;

use crate::accuracy::Accuracy;
use crate::campaign::{self, Trials};
use crate::classifiers::{LOGISTIC_REGION, LOGISTIC_TAXEL};
use crate::data::{NOMINAL, SETTING_REACHES, SETTINGS};
use crate::error::ExperimentError;
use crate::progress::Progress;

/// How a classifier of one setting fares at another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Split {
    pub classifier: String,
    pub trained: String,
    pub tested: String,
    #[serde(flatten)]
    pub accuracy: Accuracy,
}

/// Taxel trials of one setting, in two folds of whole reaches.
pub struct Setting {
    pub name: &'static str,
    pub folds: [Vec<Trial>; 2],
}

impl Setting {
    /// Folds of the trials of the first `counts` reaches of a campaign of `reaches` of each scene: half of each scene's
    /// in either. The same reaches at every setting, which have the same clutter and goals.
    pub fn new(name: &'static str, taxel_trials: &[Trial], reaches: [u64; 2], counts: [u64; 2]) -> Self {
        let mut folds = [Vec::new(), Vec::new()];
        for trial in taxel_trials {
            let Some(place) = trial.reach else { continue };
            let (scene, index) = match place.checked_sub(reaches[0]) {
                None => (0, place),
                Some(index) => (1, index),
            };
            if index < counts[scene] {
                folds[usize::from(2 * index >= counts[scene])].push(trial.clone());
            }
        }
        Setting { name, folds }
    }
}

/// Runs the other settings and sets each against each; the nominal one is the campaign's own.
pub fn run(seed: u64, quick: bool, own: &[Trial], progress: &dyn Progress) -> Result<Vec<Split>, ExperimentError> {
    let counts = SETTING_REACHES[usize::from(quick)];
    let mut settings = vec![Setting::new(NOMINAL, own, campaign::reaches(quick), counts)];
    for (name, robot) in SETTINGS {
        let campaign = campaign::changed_campaign(seed, counts, |scene| scene.robot = robot)?;
        settings.push(Setting::new(
            name,
            &Trials::of_campaign(&campaign, progress)?.taxel,
            counts,
            counts,
        ));
    }
    splits(&settings)
}

/// Every classifier, learned at every setting from one half of the reaches and tested at every setting on the other half:
/// no clutter is met in both, and all learn from equally many reaches.
pub fn splits(settings: &[Setting]) -> Result<Vec<Split>, ExperimentError> {
    let motion = Recipe {
        features: FeatureSet::FORCE_AND_MOTION,
        ..Recipe::authors()
    };
    let taxel_alone = Logistic {
        features: FeatureSet::FORCE_AND_MOTION,
        ..Logistic::default()
    };
    let estimators: [(&str, Box<dyn Estimator>); 4] = [
        ("hidden Markov models, force, 10 states", Box::new(Recipe::authors())),
        ("hidden Markov models, force and motion, 10 states", Box::new(motion)),
        (LOGISTIC_TAXEL, Box::new(taxel_alone)),
        (LOGISTIC_REGION, Box::new(Logistic::default())),
    ];
    let cases: Vec<_> = estimators
        .iter()
        .flat_map(|estimator| settings.iter().map(move |trained| (estimator, trained)))
        .collect();
    let row = |((classifier, estimator), trained): &(&(&str, Box<dyn Estimator>), &Setting)| {
        let (mut predictions, mut categories) = (vec![Vec::new(); settings.len()], Vec::new());
        for fold in 0..2 {
            let learned = estimator.fit(&trained.folds[1 - fold].iter().collect::<Vec<_>>())?;
            categories = learned.categories();
            for (tested, predictions) in settings.iter().zip(&mut predictions) {
                let evaluation = evaluate(learned.as_ref(), &tested.folds[fold], &Decision::argmax())?;
                predictions.extend(evaluation.predictions);
            }
        }
        let split = |(tested, predictions): (&Setting, Vec<_>)| {
            Ok(Split {
                classifier: (*classifier).into(),
                trained: trained.name.into(),
                tested: tested.name.into(),
                accuracy: Accuracy::of(&Evaluation::of(predictions, &categories, Vec::new())?),
            })
        };
        settings.iter().zip(predictions).map(split).collect()
    };
    let rows: Vec<Result<Vec<Split>, ExperimentError>> = cases.par_iter().map(row).collect();
    Ok(rows
        .into_iter()
        .collect::<Result<Vec<_>, _>>()?
        .into_iter()
        .flatten()
        .collect())
}
