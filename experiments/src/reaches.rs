//! Reaches to test models on: drawn one after the other until enough do what the experiment asks for, by ground truth.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use underbrush_classifier::trial::taxel_trials;
use underbrush_recording::disk::{read_recording, write_recording};
use underbrush_recording::{Category, Recording};
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;

use crate::data::{self, SceneSource};
use crate::error::ExperimentError;
use crate::files;
use crate::kept;
use crate::progress::Progress;

/// What is asked of a reach.
#[derive(Clone, Copy)]
pub enum Wanted {
    /// The forearm touches this category, feels it, and touches nothing else.
    Only(Category),
    /// The forearm touches leaf and trunk.
    LeafAndTrunk,
    /// The forearm touches the outlier before it touches any leaf or trunk, and then one of these.
    OutlierFirst,
}

/// Reaches of one scene that do what is asked.
pub struct Found {
    pub scene: String,
    /// Reaches drawn until enough were found, or no more were to be drawn.
    pub drawn: u64,
    pub reaches: Vec<Recording>,
}

/// All that models are tested on.
pub struct TestReaches {
    pub engineered: Vec<(Category, Found)>,
    pub mixed: Found,
    pub outlier: Found,
}

struct Search {
    source: SceneSource,
    wanted: Wanted,
    enough: usize,
    most: u64,
}

/// Written when a search is over, so that it need not be done again.
#[derive(Serialize, Deserialize)]
struct Index {
    drawn: u64,
    found: Vec<u64>,
}

impl Wanted {
    fn is(self, recording: &Recording) -> Result<bool, ExperimentError> {
        let options = data::trial_options();
        let forearm = recording.layout.chosen_patch(options.patch.as_deref());
        // Contacts are sorted by their first frame.
        let touched: Vec<Category> = recording
            .contacts
            .iter()
            .filter(|contact| contact.patch.map(usize::from) == forearm)
            .filter_map(|contact| recording.objects.get(usize::from(contact.object)))
            .map(|object| object.category)
            .collect();
        Ok(match self {
            Wanted::Only(category) => {
                let only = !touched.is_empty() && touched.iter().all(|other| *other == category);
                only && !taxel_trials(recording, &options)?.is_empty()
            }
            Wanted::LeafAndTrunk => touched.contains(&Category::LEAF) && touched.contains(&Category::TRUNK),
            Wanted::OutlierFirst => {
                let known = |category: &Category| matches!(*category, Category::LEAF | Category::TRUNK);
                let outlier = touched.iter().position(|category| *category == Category::OUTLIER);
                let first_known = touched.iter().position(known);
                outlier.zip(first_known).is_some_and(|(outlier, known)| outlier < known)
            }
        })
    }
}

impl Search {
    /// Draws, or reads what an earlier run has kept in `folder`.
    fn run(&self, folder: &Path, run: (u64, bool), progress: &dyn Progress) -> Result<Found, ExperimentError> {
        let plan = plan(self.source, run.0)?;
        let scene = plan.scene.name.clone();
        let file = |index: u64| -> PathBuf { folder.join(format!("{scene}-{index}.parquet")) };
        let index_file = folder.join(format!("{scene}.json"));
        if let Some(Index { drawn, found }) = kept::load(&index_file, run, progress) {
            let reaches = found.iter().map(|index| read_recording(file(*index)));
            let reaches = reaches.collect::<Result<_, _>>()?;
            return Ok(Found { scene, drawn, reaches });
        }
        let (mut drawn, mut reaches) = (0, Vec::new());
        while drawn < self.most && reaches.len() < self.enough {
            let recording = plan.run(drawn, &mut |_, _| {})?;
            if self.wanted.is(&recording)? {
                write_recording(file(drawn), &recording)?;
                reaches.push(recording);
            }
            drawn += 1;
        }
        let index = Index {
            drawn,
            found: reaches.iter().map(|recording| recording.reach_index).collect(),
        };
        kept::store(&index_file, run, &index)?;
        Ok(Found { scene, drawn, reaches })
    }
}

/// The plan of the reaches of a scene, for a second look at one of them.
pub fn plan((path, text): SceneSource, seed: u64) -> Result<ReachPlan, ExperimentError> {
    let scene = Scene::parse(path, text.into())?;
    Ok(ReachPlan::new(scene, data::CONTROLLER, seed)?)
}

fn search_mixed(quick: bool) -> Search {
    Search {
        source: data::MIXED,
        wanted: Wanted::LeafAndTrunk,
        enough: data::MIXED_REACHES[usize::from(quick)],
        most: data::MIXED_DRAWS,
    }
}

/// Draws all test reaches, scenes in parallel.
pub fn draw(folder: &Path, seed: u64, quick: bool, progress: &dyn Progress) -> Result<TestReaches, ExperimentError> {
    files::create_folder(folder)?;
    // The longest first, so that no thread waits for them in the end.
    let mut searches = vec![
        Search {
            source: data::OUTLIER,
            wanted: Wanted::OutlierFirst,
            enough: data::OUTLIER_REACHES[usize::from(quick)],
            most: data::OUTLIER_DRAWS,
        },
        search_mixed(quick),
    ];
    searches.extend(data::ENGINEERED.iter().map(|(source, category)| Search {
        source: *source,
        wanted: Wanted::Only(*category),
        enough: 1,
        most: data::ENGINEERED_DRAWS,
    }));
    let count = progress.count("experiments", searches.len() as u64, 0);
    let found: Vec<Result<Found, ExperimentError>> = searches
        .par_iter()
        .with_max_len(1)
        .map(|search| {
            let found = search.run(folder, (seed, quick), progress);
            count.advance();
            found
        })
        .collect();
    drop(count);
    let mut found = found.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter();
    let mut next = || {
        found
            .next()
            .ok_or_else(|| ExperimentError::Request("a search for reaches gave nothing".into()))
    };
    let (outlier, mixed) = (next()?, next()?);
    let engineered = data::ENGINEERED
        .iter()
        .map(|(_, category)| Ok((*category, next()?)))
        .collect::<Result<_, ExperimentError>>()?;
    Ok(TestReaches {
        engineered,
        mixed,
        outlier,
    })
}
