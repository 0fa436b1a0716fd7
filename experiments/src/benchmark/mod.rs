//! The benchmark `incidental-contact-2`: three tracks with frozen scenes and figures (`benchmarks/` describes them). Each has
//! a half with public seeds and an audit half, whose seed follows from what is judged.
//!
//! A row of its table depends only on the entry and the data. [`crate::dataset::Campaign`] makes the data, on one
//! machine or many, and a row is the same byte for byte wherever the data were made.

mod counts;
mod frozen;
mod judged_model;
mod objects;
mod reaching;
mod row;
#[cfg(test)]
mod tests;
mod transfer;
mod verdicts;

use std::path::{Path, PathBuf};

use underbrush_recording::{Dataset, Fault, InputError};
use underbrush_sim::controller::ControllerKind;
use underbrush_sim::reach::MakeController;
use underbrush_sim::scene::Scene;

use crate::contact_trials::each_episode;
use crate::dataset::{Campaign, PROGRAM_VERSION};
use crate::verdict_controller::{TRUTH, VerdictControl};
use crate::{Progress, files};
use counts::{Counts, FittedNothing, FrameCounts};

pub use crate::resampled::{Estimate, Halves, Ranking};
pub use judged_model::JudgedModel;
pub(crate) use reaching::Reach;
pub use reaching::Reaching;
pub use row::{BenchmarkRow, EntryRecord, SceneRecord, SetRecord, TrackFigures};
pub use transfer::{Transfer, TransferTo};
pub use verdicts::{ObjectFigures, UnknownIn, Verdicts, VerdictsAt};

/// What is judged, in one of the tracks.
pub enum Entry {
    /// Track 1: a model says what contacts are.
    Verdicts(Box<JudgedModel>),
    /// Track 2: a model says what contacts are, with other arms, speeds and sensors than in training.
    Transfer(Box<JudgedModel>),
    /// Track 3: a controller reaches through clutter.
    Reaching(EnteredController),
}

/// A controller that is judged.
#[derive(Clone, Default)]
pub struct EnteredController {
    /// A controller that comes with the program. If it is not given, the scene's is used.
    pub kind: Option<ControllerKind>,
    /// A user's own controller. Finished reaches are found by its name, so a changed controller needs another name or
    /// folder.
    pub own: Option<MakeController>,
    /// Verdicts for the controller, if it is to have any.
    pub verdicts: Option<VerdictControl>,
}

/// Reaches on which an entry is judged.
pub struct TestSet {
    /// Its name, which is also the name of its folder.
    pub name: String,
    /// The reaches.
    pub campaign: Campaign,
}

impl Entry {
    /// What is judged in this track.
    ///
    /// # Errors
    /// If the track is unknown or judges something else, or the model cannot be read or judged.
    pub fn new(track: &str, model: Option<&Path>, controller: Option<EnteredController>) -> Result<Self, Fault> {
        match (track, model, controller) {
            ("verdicts", Some(model), None) => Ok(Entry::Verdicts(Box::new(JudgedModel::load(model)?))),
            ("transfer", Some(model), None) => Ok(Entry::Transfer(Box::new(JudgedModel::load(model)?))),
            ("reaching", None, Some(own)) if own.kind.is_some() || own.own.is_some() => Ok(Entry::Reaching(own)),
            (track, model, controller) => {
                let [model, controller] =
                    [model.is_some(), controller.is_some()].map(|given| if given { "a" } else { "no" });
                let found = format!("{track:?} with {model} model and {controller} controller");
                let allowed = "verdicts or transfer with a model, reaching with a controller";
                let remedy = "give a model for verdicts and transfer, a controller for reaching";
                Err(InputError::new("argument", "track", found, allowed, remedy).into())
            }
        }
    }

    /// Name of its track.
    pub fn track(&self) -> &'static str {
        match self {
            Entry::Verdicts(_) => "verdicts",
            Entry::Transfer(_) => "transfer",
            Entry::Reaching(_) => "reaching",
        }
    }

    /// The sets on which it is judged: those of the public half, as many of the audit half, and one to fit the class
    /// "nothing" to if the model lacks it; with `quick`, small sets to try things out.
    ///
    /// # Errors
    /// If a controller's verdicts do not suit the arm or are the truth, which no robot knows, or the frozen files are broken.
    pub fn sets(&self, quick: bool) -> Result<Vec<TestSet>, Fault> {
        let set = |name: String, paths: &[&str], reaches: u64, seed: u64| {
            let reaches = if quick { frozen::QUICK_REACHES } else { reaches };
            let scenes: Vec<Scene> = paths.iter().map(|path| frozen::scene(path)).collect::<Result<_, _>>()?;
            let campaign = Campaign { arms: frozen::arms(&scenes)?, ..Campaign::new(scenes, reaches, seed)? };
            Ok::<TestSet, Fault>(TestSet { name, campaign })
        };
        let mut sets = Vec::new();
        match self {
            Entry::Verdicts(model) => {
                for (half, seed) in frozen::halves(self.track(), frozen::VERDICTS_SEED, &model.blake3, &model.blake3) {
                    let name = format!("verdicts-{half}");
                    sets.push(set(name, frozen::VERDICTS_SCENES, frozen::VERDICTS_REACHES, seed)?);
                }
                if !model.knows_nothing() {
                    let name = "fitting".to_owned();
                    sets.push(set(name, frozen::KNOWN_SCENES, frozen::FITTING_REACHES, frozen::FITTING_SEED)?);
                }
            }
            Entry::Transfer(model) => {
                for (half, seed) in frozen::halves(self.track(), frozen::TRANSFER_SEED, &model.blake3, &model.blake3) {
                    for (name, scene) in frozen::SETTINGS {
                        sets.push(set(format!("transfer-{half}-{name}"), &[scene], frozen::TRANSFER_REACHES, seed)?);
                    }
                }
            }
            Entry::Reaching(controller) => {
                if controller.verdicts.as_ref().is_some_and(|own| own.model_blake3() == TRUTH) {
                    let remedy = "give a touch model, or try the truth with `underbrush generate`";
                    return Err(InputError::new("argument", "verdicts", TRUTH, "what a robot can sense", remedy).into());
                }
                let campaign = |name: String, seed| {
                    let mut set = set(name, &[frozen::REACHING_SCENE], frozen::CONTROLLED_REACHES, seed)?;
                    set.campaign.controller = controller.kind;
                    set.campaign.own_controller = controller.own.clone();
                    set.campaign.verdicts = controller.verdicts.clone();
                    Ok::<TestSet, Fault>(set)
                };
                let mut name = campaign(String::new(), 0)?.campaign.controller_name()?;
                let judged = match (&controller.verdicts, &controller.own) {
                    (Some(verdicts), _) => verdicts.model_blake3().to_owned(),
                    (None, Some(_)) => name.clone(),
                    (None, None) => format!("{name} {PROGRAM_VERSION}"),
                };
                if let Some(verdicts) = &controller.verdicts {
                    // Other models give other reaches.
                    name += &format!("-{:.8}", verdicts.model_blake3());
                }
                for (half, seed) in frozen::halves(self.track(), frozen::REACHING_SEED, &judged, "") {
                    sets.push(campaign(format!("reaching-{half}-{name}"), seed)?);
                }
            }
        }
        Ok(sets)
    }

    /// Judges the entry: makes the sets in `folder` that are missing there, and writes the row beside them.
    ///
    /// # Errors
    /// If a reach fails, a file cannot be read or written, the model does not suit the skin, or the row of another
    /// model is in the row's place.
    pub fn run(&self, folder: &Path, quick: bool, progress: &dyn Progress) -> Result<BenchmarkRow, Fault> {
        let planned = self.sets(quick)?;
        let entry = self.record(&planned)?;
        let kind = if quick { "quick-rows" } else { "rows" };
        let file = folder.join(kind).join(format!("{}-{}.json", self.track(), entry.name));
        entry.check_earlier_row(&file)?;
        let mut sets = Vec::new();
        for set in planned {
            progress.stage(&format!("Reaches of the set {}", set.name));
            let written = set.campaign.write(&set_folder(folder, &set.name, quick), true, progress)?;
            sets.push((set.name, written.dataset()));
        }
        progress.stage("Figures");
        let record = |(name, dataset): &(String, Dataset)| SetRecord::of(name, dataset);
        let row = BenchmarkRow {
            benchmark: frozen::NAME.into(),
            track: self.track().into(),
            complete: !quick,
            entry,
            program_version: PROGRAM_VERSION.into(),
            analysis_sources: env!("UNDERBRUSH_ANALYSIS_SOURCES").into(),
            engine: underbrush_sim::physics::ENGINE.into(),
            sets: sets.iter().map(record).collect::<Result<_, _>>()?,
            figures: self.figures(&sets, progress)?,
        };
        files::write_json(&file, &row)?;
        Ok(row)
    }

    fn record(&self, sets: &[TestSet]) -> Result<EntryRecord, Fault> {
        Ok(match self {
            Entry::Verdicts(model) | Entry::Transfer(model) => EntryRecord {
                name: model.name.clone(),
                classifier: Some(model.classifier.clone()),
                model_blake3: Some(model.blake3.clone()),
            },
            Entry::Reaching(controller) => EntryRecord {
                name: sets[0].campaign.controller_name()?,
                classifier: None,
                model_blake3: controller.verdicts.as_ref().map(|own| own.model_blake3().to_owned()),
            },
        })
    }

    fn figures(&self, sets: &[(String, Dataset)], progress: &dyn Progress) -> Result<TrackFigures, Fault> {
        let judged = |(_, set): &(String, Dataset), model: &JudgedModel| {
            each_episode(set, progress, |_, recording| Ok((recording.scene.clone(), model.judge(recording)?)))
        };
        Ok(match self {
            Entry::Verdicts(model) => {
                let [public, audit] = [judged(&sets[0], model)?, judged(&sets[1], model)?];
                let fitting = sets.get(2).map(|set| judged(set, model)).transpose()?.unwrap_or_default();
                let frames: Vec<&FrameCounts> = fitting.iter().map(|(_, reach)| &reach.frames).collect();
                let nothing = FittedNothing::fit(&frames);
                let ranking = verdicts::ranking([&public, &audit]);
                let [public, audit] = [public, audit].map(|half| verdicts::figures(&half, nothing));
                TrackFigures::Verdicts(Halves { ranking, public, audit })
            }
            Entry::Transfer(model) => {
                let of_set = |set| Ok(judged(set, model)?.iter().map(|(_, reach)| reach.at_end()).collect());
                let settings = sets.iter().map(of_set).collect::<Result<Vec<Vec<Counts>>, Fault>>()?;
                let (public, audit) = settings.split_at(frozen::SETTINGS.len());
                let ranking = transfer::ranking([public, audit]);
                let [public, audit] = [public, audit].map(transfer::figures);
                TrackFigures::Transfer(Halves { ranking, public, audit })
            }
            Entry::Reaching(_) => {
                let goals = frozen::scene(frozen::REACHING_SCENE)?.file.goals.number();
                let of_set =
                    |(_, set): &(String, Dataset)| each_episode(set, progress, |_, reach| Ok(Reach::of(goals, reach)));
                let [public, audit] = [of_set(&sets[0])?, of_set(&sets[1])?];
                let ranking = reaching::ranking([&public, &audit]);
                let [public, audit] = [public, audit].map(|half| reaching::figures(&half));
                TrackFigures::Reaching(Halves { ranking, public, audit })
            }
        })
    }
}

/// The folder of a set inside the benchmark's folder.
pub fn set_folder(folder: &Path, name: &str, quick: bool) -> PathBuf {
    folder.join(if quick { "quick-sets" } else { "sets" }).join(name)
}
