//! What is that arm touching? Hidden Markov models that tell leaf from trunk from outlier, taxel by taxel, from the forces
//! (and motions) that tactile skin feels in incidental contact, after Bhattacharjee, Kapusta, Rehg and Kemp,
//! "Rapid Categorization of Object Properties from Incidental Contact with a Tactile Sensing Robot Arm", 2013.
//!
//! The way through the crate is that of the data:
//!
//! | step | where |
//! |---|---|
//! | a recording is cut into trials, from contact to break | [`trial::taxel_trials`], [`trial::component_trials`] |
//! | a trial becomes a matrix of features | [`feature::FeatureSet`] |
//! | trials train one model per category, by a recipe | [`ModelSet::train`], [`recipe::Recipe`], [`hmm`] |
//! | models score a trial, or a stream while the arm moves | [`ModelSet::score`], [`online::OnlineClassifier`] |
//! | scores become a verdict | [`decision::Decision`] |
//! | anything else that learns from trials stands beside them | [`estimator::Estimator`], [`baseline`] |
//! | verdicts become tables with confidence intervals | [`evaluate`] |
//!
//! Nothing here knows the simulator: recordings of a real robot and anyone's table of trials will do.
//!
//! # Tutorial
//!
//! Twenty presses against something soft and twenty against something stiff; train; ask about a new one.
//!
//! ```
//! use underbrush_classifier::ModelSet;
//! use underbrush_classifier::decision::Decision;
//! use underbrush_classifier::recipe::Recipe;
//! use underbrush_recording::{Sample, Trial};
//!
//! // 0.3 s at 100 Hz, pressing in at 5 cm/s; the k-th press is a little harder or softer than the others.
//! fn press(category: Option<&str>, stiffness_n_per_m: f64, k: u64) -> Trial {
//!     let samples = (0..30)
//!         .map(|t| {
//!             let time_s = f64::from(t) * 0.01;
//!             let force_n = stiffness_n_per_m * 0.05 * time_s * (1.0 + 0.2 * (k as f64 + 0.7 * f64::from(t)).sin());
//!             Sample { time_s, force_n, motion_m: None, region: None, touched: None }
//!         })
//!         .collect();
//!     Trial { trial: k, category: category.map(str::to_owned), reach: None, patch: None, taxel: None, samples }
//! }
//! let soft = (0..20).map(|k| press(Some("leaf"), 30.0, k));
//! let stiff = (20..40).map(|k| press(Some("trunk"), 200.0, k));
//! let trials: Vec<Trial> = soft.chain(stiff).collect();
//!
//! let recipe = Recipe { states: 5, ..Recipe::authors() };
//! let (models, report) = ModelSet::train(&trials, &recipe)?;
//! println!("{:?}", report.categories["leaf"].stop);
//!
//! let scores = models.score(&press(None, 180.0, 99), models.score_kind())?;
//! let verdict = Decision::paper().prepare(&models.categories())?.judge(&scores)?;
//! assert_eq!(verdict.name(), "trunk");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod baseline;
pub mod decision;
pub mod estimator;
pub mod evaluate;
pub mod feature;
pub mod hmm;
mod model_file;
mod model_set;
pub mod online;
pub mod recipe;
pub mod stream_feature;
pub mod trial;

pub use model_file::FORMAT;
pub use model_set::{ModelError, ModelSet, TrainingReport, is_trained};
