//! The benchmark `incidental-contact-1`: three tracks with frozen scenes, seeds and figures (`benchmarks/` describes
//! them).
//!
//! A row of its table depends only on the entry and the data. [`crate::dataset::Campaign`] makes the data, on one
//! machine or many, and a row is the same byte for byte wherever the data were made.

mod contacts;
mod frozen;
mod judged_model;
mod ranked;
mod reaching;
mod row;
#[cfg(test)]
mod tests;
mod transfer;
mod verdicts;

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use underbrush_recording::disk::Dataset;
use underbrush_recording::fault::Fault;
use underbrush_recording::{InputError, Recording};
use underbrush_sim::controller::ControllerKind;
use underbrush_sim::reach::MakeController;
use underbrush_sim::scene::Scene;

use crate::dataset::{Campaign, PROGRAM_VERSION};
use crate::files;
use crate::progress::Progress;
use crate::verdict_controller::{TRUTH, VerdictControl};

pub use crate::resampled::Estimate;
pub use judged_model::JudgedModel;
pub use reaching::Reaching;
pub use row::{EntryRecord, Figures, Row, SceneRecord, SetRecord};
pub use transfer::{Transfer, TransferTo};
pub use verdicts::{ContactCounts, Verdicts, VerdictsAt};

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
    /// Names of the tracks.
    pub const TRACKS: [&str; 3] = ["verdicts", "transfer", "reaching"];

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
                let allowed = format!("one of {}", Entry::TRACKS.join(", "));
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

    /// The sets on which it is judged; with `quick`, small sets to try things out.
    ///
    /// # Errors
    /// If a controller's verdicts do not suit the arm, or the frozen files are broken.
    pub fn sets(&self, quick: bool) -> Result<Vec<TestSet>, Fault> {
        let set = |name: String, paths: &[&str], reaches: u64, seed: u64| {
            let reaches = if quick { frozen::QUICK_REACHES } else { reaches };
            let scenes: Vec<Scene> = paths.iter().map(|path| frozen::scene(path)).collect::<Result<_, _>>()?;
            let campaign = Campaign { arms: frozen::arms(&scenes)?, ..Campaign::new(scenes, reaches, seed)? };
            Ok::<TestSet, Fault>(TestSet { name, campaign })
        };
        let judged = frozen::JUDGED_REACHES;
        match self {
            Entry::Verdicts(_) => {
                let name = "verdicts".to_owned();
                Ok(vec![set(name, frozen::VERDICTS_SCENES, judged, frozen::VERDICTS_SEED)?])
            }
            Entry::Transfer(_) => (frozen::SETTINGS.iter())
                .map(|(name, scene)| set(format!("transfer-{name}"), &[scene], judged, frozen::TRANSFER_SEED))
                .collect(),
            Entry::Reaching(controller) => {
                let scenes = [frozen::REACHING_SCENE];
                let mut set = set(String::new(), &scenes, frozen::CONTROLLED_REACHES, frozen::REACHING_SEED)?;
                set.campaign.controller = controller.kind;
                set.campaign.own_controller = controller.own.clone();
                set.campaign.verdicts = controller.verdicts.clone();
                set.name = format!("reaching-{}", set.campaign.controller_name()?);
                if let Some(verdicts) = &controller.verdicts {
                    // Other models give other reaches.
                    set.name += &format!("-{}", verdicts.model_blake3().get(..8).unwrap_or(TRUTH));
                }
                Ok(vec![set])
            }
        }
    }

    /// Judges the entry: makes the sets in `folder` that are missing there, and writes the row beside them.
    ///
    /// # Errors
    /// If a reach fails, a file cannot be read or written, the model does not suit the skin, or the row of another
    /// model is in the row's place.
    pub fn run(&self, folder: &Path, quick: bool, progress: &dyn Progress) -> Result<Row, Fault> {
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
        let row = Row {
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
                name: match sets.first() {
                    Some(set) => set.campaign.controller_name()?,
                    None => String::new(),
                },
                classifier: None,
                model_blake3: controller.verdicts.as_ref().map(|own| own.model_blake3().to_owned()),
            },
        })
    }

    fn figures(&self, sets: &[(String, Dataset)], progress: &dyn Progress) -> Result<Figures, Fault> {
        let contacts = |set: &Dataset, model: &JudgedModel| {
            each_reach(set, progress, |recording| Ok((recording.scene.clone(), model.contacts(recording)?)))
        };
        Ok(match self {
            Entry::Verdicts(model) => {
                let found = sets.iter().map(|(_, set)| contacts(set, model));
                Figures::Verdicts(verdicts::figures(&found.collect::<Result<Vec<_>, _>>()?.concat()))
            }
            Entry::Transfer(model) => {
                let of_set = |(_, set): &(String, Dataset)| {
                    let found = contacts(set, model)?;
                    Ok(found.into_iter().map(|(_, contacts)| contacts).collect())
                };
                let settings = sets.iter().map(of_set).collect::<Result<Vec<_>, Fault>>()?;
                Figures::Transfer(transfer::figures(&settings))
            }
            Entry::Reaching(_) => {
                let goals = frozen::scene(frozen::REACHING_SCENE)?.file.goals.count;
                let of_set = |(_, set): &(String, Dataset)| {
                    each_reach(set, progress, |reach| {
                        Ok(reaching::Reach::of(goals, &reach.goals, &reach.contacts, &reach.objects))
                    })
                };
                let reaches = sets.iter().map(of_set).collect::<Result<Vec<_>, _>>()?.concat();
                Figures::Reaching(reaching::figures(&reaches))
            }
        })
    }
}

/// The folder of a set inside the benchmark's folder.
pub fn set_folder(folder: &Path, name: &str, quick: bool) -> PathBuf {
    folder.join(if quick { "quick-sets" } else { "sets" }).join(name)
}

/// Applies `of` to all reaches of a set, several at a time, and returns the results in the order of the reaches.
fn each_reach<T: Send>(
    set: &Dataset,
    progress: &dyn Progress,
    of: impl Fn(&Recording) -> Result<T, Fault> + Sync,
) -> Result<Vec<T>, Fault> {
    let reaches = set.episodes().len();
    let count = progress.count("reaches", reaches as u64, 0);
    (0..reaches)
        .into_par_iter()
        .with_max_len(1)
        .map(|index| {
            let found = of(&set.read_reach(index)?);
            count.advance();
            found
        })
        .collect()
}
