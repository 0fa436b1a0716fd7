//! Reaches on which models are tested. They are drawn one after the other until enough of them meet the experiment's
//! requirement, which is checked against the ground truth.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use underbrush_classifier::trial::{ContactTrial, TrialOptions, taxel_trials};
use underbrush_recording::disk::{DiskError, read_recording, write_recording};
use underbrush_recording::{Category, Fault, Recording};
use underbrush_sim::reach::ReachPlan;

use crate::definition::TestScene;
use crate::run_folder::{self, Plan};
use crate::{Experiment, Progress, Session, files, in_parallel};

/// The requirement on a reach.
enum Wanted {
    /// The patch touches this category and nothing else, and the category presses on a taxel in at least one taxel
    /// trial.
    Only(Category),
    /// The patch touches all of these.
    All(Vec<Category>),
    /// The patch touches the outlier before it touches any of these, and then one of these.
    OutlierFirst(Vec<Category>),
    /// The patch touches an object of a category that is not among these.
    Unknown(Vec<Category>),
}

/// Reaches of one scene that meet the requirement.
pub struct Found {
    /// Name of the scene.
    pub scene: String,
    /// Number of reaches drawn until enough were found or the limit was reached.
    pub drawn: u64,
    /// The reaches.
    pub reaches: Vec<Recording>,
}

/// All reaches on which models are tested.
pub struct TestReaches {
    /// Reaches that touch one category alone.
    pub engineered: Vec<(Category, Found)>,
    /// Reaches that touch every category.
    pub general: Option<Found>,
    /// Reaches that meet the outlier first.
    pub outlier: Option<Found>,
    /// Reaches that touch another outlier.
    pub second_outlier: Option<Found>,
}

struct Search {
    /// The name of its files: the section of the experiment file with the scene, because several sections may name one scene.
    name: String,
    plan: ReachPlan,
    options: TrialOptions,
    wanted: Wanted,
    enough: usize,
    max_draws: u64,
}

/// Written when a search is complete, so that the search need not be repeated.
#[derive(Default, Serialize, Deserialize)]
struct Index {
    drawn: u64,
    found: Vec<u64>,
}

impl Wanted {
    fn is(&self, recording: &Recording, options: &TrialOptions) -> Result<bool, Fault> {
        let patch = recording.layout.chosen_patch(options.patch.as_deref());
        // Contacts are sorted by their first frame.
        let contacts = recording.contacts.iter().filter(|contact| contact.patch.map(usize::from) == patch);
        let touched: Vec<Category> = contacts.filter_map(|contact| recording.category_of(contact.object)).collect();
        Ok(match self {
            Wanted::Only(category) => {
                let only = !touched.is_empty() && touched.iter().all(|other| other == category);
                // Spurious readings and crosstalk make trials, too.
                let felt = |found: &ContactTrial| found.trial.touched() == Some(true);
                only && taxel_trials(recording, options)?.iter().any(felt)
            }
            Wanted::All(categories) => categories.iter().all(|category| touched.contains(category)),
            Wanted::Unknown(known) => touched.iter().any(|category| !known.contains(category)),
            Wanted::OutlierFirst(known) => {
                let outlier = touched.iter().position(|category| *category == Category::OUTLIER);
                let first_known = touched.iter().position(|category| known.contains(category));
                outlier.zip(first_known).is_some_and(|(outlier, known)| outlier < known)
            }
        })
    }
}

impl Search {
    /// Draws the reaches, or reads those that an earlier run has cached in `folder`.
    fn run(&self, folder: &Path, plan: Plan, progress: &dyn Progress) -> Result<Found, Fault> {
        let scene = self.plan.scene.name.clone();
        let file = |index: u64| folder.join(format!("{}-{index}.parquet", self.name));
        let index_file = folder.join(format!("{}.json", self.name));
        let mut new = BTreeMap::new();
        let Index { drawn, found } = run_folder::result(&index_file, plan, progress, || {
            let mut index = Index::default();
            while index.drawn < self.max_draws && index.found.len() < self.enough {
                let recording = self.plan.run_until(index.drawn, &mut |_| {}, &|| progress.is_stopped())?;
                if self.wanted.is(&recording, &self.options)? {
                    write_recording(&file(index.drawn), &recording)?;
                    index.found.push(index.drawn);
                    new.insert(index.drawn, recording);
                }
                index.drawn += 1;
            }
            Ok(index)
        })?;
        let reach = |index| new.remove(&index).map_or_else(|| self.cached(&file(index), index, progress), Ok);
        let reaches = found.into_iter().map(reach).collect::<Result<_, _>>()?;
        Ok(Found { scene, drawn, reaches })
    }

    /// The cached reach of an index. If its file is missing or damaged, the reach is drawn again.
    fn cached(&self, file: &Path, index: u64, progress: &dyn Progress) -> Result<Recording, Fault> {
        match read_recording(file) {
            Err(DiskError::Input(error)) if !error.storage => {
                let (file, found) = (file.display(), &error.found);
                progress.remark(&format!("{file}: cannot be used ({found}), so the reach is drawn again"));
            }
            read => return Ok(read?),
        }
        let recording = self.plan.run_until(index, &mut |_| {}, &|| progress.is_stopped())?;
        write_recording(file, &recording)?;
        Ok(recording)
    }
}

/// The plan of the reaches of a scene, by its path in the experiment file.
pub fn plan(experiment: &Experiment, source: &str, seed: u64) -> Result<ReachPlan, Fault> {
    let scene = experiment.scene(source)?.clone();
    Ok(ReachPlan::with_arm(scene, experiment.arm.clone(), experiment.file.controller, seed)?)
}

/// Draws all test reaches, scenes in parallel.
pub fn run(session: &Session) -> Result<TestReaches, Fault> {
    let (experiment, progress) = (session.experiment, session.progress);
    let file = &experiment.file;
    let known: Vec<Category> = experiment.labels().into_iter().filter_map(|label| experiment.category(label)).collect();
    let search = |section: &str, source: &str, wanted, enough, max_draws| {
        let plan = plan(experiment, source, session.seed)?;
        Ok::<_, Fault>(Search {
            name: format!("{section}-{}", plan.scene.name),
            plan,
            options: experiment.trial_options(),
            wanted,
            enough,
            max_draws,
        })
    };
    // The longest reaches first, so that no thread waits for them at the end.
    let mut searches = Vec::new();
    for (section, own, wanted) in [
        ("outlier", file.outlier.as_ref(), Wanted::OutlierFirst(known.clone())),
        ("second-outlier", file.second_outlier.as_ref(), Wanted::Unknown(known.clone())),
        ("general", file.general.as_ref(), Wanted::All(known.clone())),
    ] {
        if let Some(own) = own {
            searches.push(search(section, &own.scene, wanted, own.reaches, own.max_draws)?);
        }
    }
    let mut categories = Vec::new();
    for own in &file.engineered {
        let Some(category) = experiment.category(&own.label) else { continue };
        let section = format!("engineered-{}", categories.len());
        categories.push(category);
        searches.push(search(&section, &own.scene, Wanted::Only(category), 1, own.max_draws)?);
    }
    if searches.is_empty() {
        return Ok(TestReaches { engineered: Vec::new(), general: None, outlier: None, second_outlier: None });
    }
    session.stage("Engineered, general and outlier reaches", || {
        let folder = session.folder.join("reaches");
        files::create_folder(&folder)?;
        let count = progress.count("experiments", searches.len() as u64, 0);
        let plan = session.plan_of(session.seed);
        let found = in_parallel(searches.par_iter().with_max_len(1), |search| {
            let found = search.run(&folder, plan.clone(), progress);
            count.advance();
            found
        });
        let mut found = found?.into_iter();
        let mut next = |own: &Option<TestScene>| own.as_ref().and_then(|_| found.next());
        let (outlier, second_outlier, general) = (next(&file.outlier), next(&file.second_outlier), next(&file.general));
        Ok(TestReaches { engineered: categories.into_iter().zip(found).collect(), general, outlier, second_outlier })
    })
}

#[cfg(test)]
mod tests;
