//! Classifies what an arm touches: hidden Markov models distinguish leaf, trunk and outlier, taxel by taxel, from the
//! forces (and motions) that tactile skin senses in incidental contact. This follows Bhattacharjee, Kapusta, Rehg and
//! Kemp, "Rapid Categorization of Object Properties from Incidental Contact with a Tactile Sensing Robot Arm", 2013.
//!
//! The modules follow the data:
//!
//! | step | where |
//! |---|---|
//! | a recording is cut into trials, from contact to break | [`trial::taxel_trials`], [`trial::component_trials`] |
//! | samples become features | [`feature::FeatureSet`], [`feature::FEATURES`] |
//! | an estimator is fitted to trials | [`estimator::Estimator`]; the list of all: [`registry::CLASSIFIERS`] |
//! | … one hidden Markov model per category | [`recipe::Recipe`], [`HmmClassifier`], [`hmm`] |
//! | … or another classifier | [`baseline`], [`stream_feature`] |
//! | a classifier is saved and loaded | [`Model`] |
//! | it scores trials, or contacts while the arm moves | [`estimator::Classifier`], [`online::OnlineClassifier`] |
//! | scores become a verdict | [`decision::Decision`] |
//! | verdicts become tables with confidence intervals | [`evaluate`] |
//!
//! Nothing here depends on the simulator: recordings of a real robot and any table of trials work as well.
//!
//! # Tutorial
//!
//! This trains on twenty presses against something soft and twenty against something stiff, and then classifies a new
//! press.
//!
//! ```
//! use underbrush_classifier::decision::Decision;
//! use underbrush_classifier::recipe::Recipe;
//! use underbrush_classifier::{Classifier, HmmClassifier};
//! use underbrush_recording::{Sample, Trial};
//!
//! // 0.3 s at 100 Hz, pressing in at 5 cm/s; the k-th press is a little harder or softer than the others.
//! fn press(category: Option<&str>, stiffness_n_per_m: f64, k: u64) -> Trial {
//!     let samples = (0..30)
//!         .map(|t| {
//!             let time_s = f64::from(t) * 0.01;
//!             let force_n = stiffness_n_per_m * 0.05 * time_s * (1.0 + 0.2 * (k as f64 + 0.7 * f64::from(t)).sin());
//!             Sample { time_s, force_n, ..Sample::default() }
//!         })
//!         .collect();
//!     Trial { trial: k, category: category.map(str::to_owned), reach: None, patch: None, taxel: None, samples }
//! }
//! let soft = (0..20).map(|k| press(Some("leaf"), 30.0, k));
//! let stiff = (20..40).map(|k| press(Some("trunk"), 200.0, k));
//! let trials: Vec<Trial> = soft.chain(stiff).collect();
//!
//! let recipe = Recipe { states: 5, ..Recipe::authors() };
//! let models = HmmClassifier::train(&trials, &recipe)?;
//! println!("{:?}", models.training["leaf"].stop);
//!
//! let scores = models.scores_of_all(&[&press(None, 180.0, 99)])?;
//! let judge = Decision::paper().prepare(&models.categories())?;
//! let verdict = judge.choose(&scores[0]);
//! assert_eq!(verdict.name(), "trunk");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod any_model;
pub mod baseline;
mod boosted;
pub mod decision;
mod document;
mod error;
pub mod estimator;
pub mod evaluate;
mod fault;
pub mod feature;
pub mod fit_options;
mod frequency;
pub mod hmm;
mod hmm_classifier;
mod model_file;
pub mod online;
#[cfg(feature = "onnx")]
pub mod onnx;
pub mod paper_rule;
mod provenance;
pub mod recipe;
pub mod registry;
mod seal;
pub mod stream_feature;
pub mod touch;
pub mod trial;

pub use decision::{Decision, Rule};
pub use document::{Document, FORMAT};
pub use error::{ModelError, ValueFault};
pub use estimator::{Classifier, ClassifierKind, Estimator, is_trained};
pub use evaluate::{Evaluation, FoldBy, Folds, ThresholdTargets, cross_validate};
pub use feature::{FeatureError, FeatureSet, SampleFault};
pub use frequency::frequencies;
pub use hmm::{ScoreKind, TrainingHistory};
pub use hmm_classifier::HmmClassifier;
pub use model_file::{Model, schema as model_schema};
pub use online::{OnlineClassifier, OnlineError, OnlineOptions};
pub use paper_rule::Scores;
pub use provenance::{DataKind, DataSource, Provenance};
pub use recipe::Recipe;
pub use touch::{TouchClassifier, TouchModel, TouchOptions};
pub use trial::TrialError;
