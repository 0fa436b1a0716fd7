//! The reaches of data sets, recordings and tables of contact trials: a list, and one at a time.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use underbrush_recording::disk::{Dataset, Episode, is_folder, is_recording, read_recording, read_trials};
use underbrush_recording::{Fault, GoalOutcomes, Outcome, Recording, SkinLayout, period_s, stop};

use crate::judging::unjudged;
use crate::pack::pack;
use crate::{Judging, ReplayContext, trial_table};

/// One line of the list of reaches.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Its place in the list, from 0.
    pub number: usize,
    /// Name of the data set or recording, without its folder.
    pub source: String,
    /// Name of the scene.
    pub scene: String,
    /// The campaign's seed, as text, because JavaScript's numbers have 53 bits.
    pub seed: String,
    /// Index of the reach in its campaign.
    pub reach_index: u64,
    /// Name of the controller.
    pub controller: String,
    /// The worst outcome of its goals.
    pub outcome: Outcome,
    /// The number of goals with each outcome.
    pub goal_outcomes: GoalOutcomes,
    /// Length, s.
    pub duration_s: f64,
    /// Number of contacts.
    pub contacts: usize,
    /// Largest contact force, N.
    pub peak_force_n: f64,
    /// The bounds of the audit that it exceeds.
    pub audit_warnings: Vec<String>,
    /// Whether the reach is still being simulated.
    pub running: bool,
    /// Whether it is from a robot's log or a table of its trials, so that nobody knows seed and controller.
    pub log: bool,
    /// Whether it is from a table of contact trials. A table has no arm, and nothing says how the reach went.
    pub table: bool,
}

/// Where a reach is read from.
enum Place {
    Dataset { input: usize, index: usize },
    File(PathBuf),
    Memory(Box<Held>),
}

/// A recording in memory.
pub struct Held {
    /// The recording.
    pub recording: Recording,
    /// The model whose verdicts are shown with it, in place of that of the source.
    pub judging: Option<Judging>,
}

/// The reaches of some data sets and recordings.
///
/// ```
/// use underbrush_recording::fault::Fault;
/// use underbrush_replay::{ReplayContext, Source};
///
/// let folder = tempfile::tempdir()?;
/// let table = folder.path().join("trials.csv");
/// std::fs::write(&table, "trial,reach,patch,taxel,time_s,force_n\n0,0,palm,3,0.00,0.2\n0,0,palm,3,0.01,0.3\n")?;
/// let context = ReplayContext { force_limit_n: |_| None, stated_limit_n: None, audit_warnings: |_, _| Vec::new() };
/// let source = Source::open(&[table], context, None)?;
/// assert_eq!(source.reaches.len(), 1);
/// assert!(source.pack(0)?.starts_with(b"ubreplay"));
/// assert!(matches!(source.pack(1), Err(Fault::Usage(_))));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Source {
    datasets: Vec<Dataset>,
    places: Vec<Place>,
    /// The list of reaches.
    pub reaches: Vec<Summary>,
    known: ReplayContext,
    judging: Option<Judging>,
    /// Whether there was a warning of the rate of frames.
    has_warned: bool,
}

impl Source {
    /// Opens data sets (folders), recordings and tables of contact trials, in this order. Warns once if frames come at another
    /// rate than those that the model was fitted to.
    ///
    /// # Errors
    /// [`Fault::Input`] for a path that is none of these, and for damaged files; [`Fault::Usage`] if the model does
    /// not fit the skin.
    pub fn open(paths: &[PathBuf], known: ReplayContext, judging: Option<Judging>) -> Result<Self, Fault> {
        let mut source = Source::new(known, judging);
        for path in paths {
            stop::check();
            let ends_with = |ending: &str| path.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending));
            if is_folder(path)? {
                source.add_dataset(path)?;
            } else if ends_with("csv") || ends_with("parquet") && !is_recording(path)? {
                source.add_table(path)?;
            } else {
                source.add_recording(path)?;
            }
        }
        Ok(source)
    }

    /// Recordings in memory, in this order.
    ///
    /// # Errors
    /// [`Fault::Usage`] if a model does not fit the skin.
    pub fn of(recordings: Vec<Held>, known: ReplayContext) -> Result<Self, Fault> {
        let mut source = Source::new(known, None);
        for held in recordings {
            if let Some(judging) = &held.judging {
                judging.begin(&held.recording.layout).map_err(unjudged(&held.recording.scene))?;
            }
            source.list(&held.recording, String::new());
            source.places.push(Place::Memory(Box::new(held)));
        }
        Ok(source)
    }

    fn new(known: ReplayContext, judging: Option<Judging>) -> Self {
        Source { datasets: Vec::new(), places: Vec::new(), reaches: Vec::new(), known, judging, has_warned: false }
    }

    /// The reaches with these numbers, each once; all reaches if there are no numbers.
    pub fn chosen(&self, numbers: &[usize]) -> Vec<usize> {
        if numbers.is_empty() {
            return (0..self.reaches.len()).collect();
        }
        let mut seen = BTreeSet::new();
        numbers.iter().copied().filter(|number| seen.insert(*number)).collect()
    }

    /// The recording of a reach.
    ///
    /// # Errors
    /// [`Fault::Usage`] if there is no such reach, and [`Fault::Input`] for damaged files.
    pub fn recording(&self, number: usize) -> Result<Cow<'_, Recording>, Fault> {
        Ok(match self.places.get(number) {
            Some(Place::Dataset { input, index }) => Cow::Owned(self.datasets[*input].read_reach(*index)?),
            Some(Place::File(path)) => Cow::Owned(read_recording(path)?),
            Some(Place::Memory(held)) => Cow::Borrowed(&held.recording),
            None => return Err(no_such_reach(number, self.places.len())),
        })
    }

    /// The text of the scene of a reach of a data set; of other reaches it is not known.
    pub fn scene_text(&self, number: usize) -> Option<&str> {
        let Some(Place::Dataset { input, .. }) = self.places.get(number) else { return None };
        let mut scenes = self.datasets[*input].plan().provenance.scenes.iter();
        scenes.find(|scene| scene.name == self.reaches[number].scene).map(|scene| scene.file.text.as_str())
    }

    /// The force that the controller allows a taxel in a reach, N: as its data set says it, or else as the context does.
    pub fn stated_limit_n(&self, number: usize) -> Option<f64> {
        match self.places.get(number) {
            Some(Place::Dataset { input, index }) => self.datasets[*input].force_limit_n(*index),
            _ => self.known.stated_limit_n,
        }
    }

    /// The bytes of a reach for the page.
    ///
    /// # Errors
    /// As [`Source::recording`] and [`pack`].
    pub fn pack(&self, number: usize) -> Result<Vec<u8>, Fault> {
        let own = match self.places.get(number) {
            Some(Place::Memory(held)) => held.judging.as_ref(),
            _ => None,
        };
        let known = ReplayContext { stated_limit_n: self.stated_limit_n(number), ..self.known };
        pack(&*self.recording(number)?, &known, own.or(self.judging.as_ref()))
    }

    fn add_dataset(&mut self, path: &Path) -> Result<(), Fault> {
        let dataset = Dataset::open(path)?;
        let rate_hz = dataset.plan().rate_hz;
        self.check(path, &dataset.plan().layout, Some(rate_hz))?;
        let peaks = dataset.peak_contact_forces_n()?;
        let input = self.datasets.len();
        for (index, (episode, peak_force_n)) in dataset.episodes().iter().zip(peaks).enumerate() {
            let line = Summary::new(episode, rate_hz, &dataset.plan().layout, &self.known);
            self.reaches.push(Summary { number: self.places.len(), source: file_name(path), peak_force_n, ..line });
            self.places.push(Place::Dataset { input, index });
        }
        self.datasets.push(dataset);
        Ok(())
    }

    fn add_recording(&mut self, path: &Path) -> Result<(), Fault> {
        let recording: Recording = read_recording(path)?;
        self.check(path, &recording.layout, Some(recording.rate_hz))?;
        self.list(&recording, file_name(path));
        self.places.push(Place::File(path.to_path_buf()));
        Ok(())
    }

    fn add_table(&mut self, path: &Path) -> Result<(), Fault> {
        if let Some(judging) = &self.judging {
            trial_table::check_model(path, judging)?;
        }
        let trials = read_trials(path)?;
        let rate_hz = period_s(&trials).map(f64::recip);
        for recording in trial_table::reaches(path, &trials)? {
            self.check(path, &recording.layout, rate_hz)?;
            self.list(&recording, file_name(path));
            self.places.push(Place::Memory(Box::new(Held { recording, judging: None })));
        }
        Ok(())
    }

    /// An error if the model does not fit the skin of a file. Warns once if it was fitted to frames at another rate than these, Hz.
    fn check(&mut self, path: &Path, layout: &SkinLayout, rate_hz: Option<f64>) -> Result<(), Fault> {
        if let Some(judging) = &self.judging {
            judging.begin(layout).map_err(unjudged(&path.display().to_string()))?;
            self.has_warned = self.has_warned || judging.by.provenance().warn_of_rate(path.display(), rate_hz);
        }
        Ok(())
    }

    /// Adds a recording to the list.
    fn list(&mut self, recording: &Recording, source: String) {
        let number = self.reaches.len();
        self.reaches.push(Summary { number, source, ..Summary::of(recording, &self.known) });
    }
}

impl Summary {
    /// The line of a reach, as far as the entry of a data set says what is in it.
    fn new(episode: &Episode, rate_hz: f64, layout: &SkinLayout, known: &ReplayContext) -> Self {
        Summary {
            number: 0,
            source: String::new(),
            scene: episode.scene.clone(),
            seed: episode.seed.to_string(),
            reach_index: episode.reach_index,
            controller: episode.controller.clone(),
            outcome: episode.outcome,
            goal_outcomes: episode.goal_outcomes,
            duration_s: episode.frames as f64 / rate_hz,
            contacts: episode.contacts,
            peak_force_n: 0.0,
            audit_warnings: (known.audit_warnings)(&episode.audit, layout),
            running: false,
            log: episode.controller == Recording::UNKNOWN_CONTROLLER,
            table: false,
        }
    }

    /// The line of a recording without a number and a source.
    pub fn of(recording: &Recording, known: &ReplayContext) -> Self {
        let forces = recording.contacts.iter().map(|contact| contact.peak_force_n);
        Summary {
            peak_force_n: forces.fold(0.0, f64::max),
            table: recording.joint_names.is_empty(),
            ..Summary::new(&Episode::of(recording), recording.rate_hz, &recording.layout, known)
        }
    }
}

/// The fault that there is no reach with this number.
pub fn no_such_reach(number: usize, count: usize) -> Fault {
    Fault::Usage(format!("there is no reach {number}; give a number below {count}"))
}

/// The last part of a path, also for a path such as `.`.
fn file_name(path: &Path) -> String {
    let whole = fs::canonicalize(path);
    let whole = whole.as_deref().unwrap_or(path);
    whole.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned())
}
