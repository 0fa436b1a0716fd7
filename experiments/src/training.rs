//! Reaches through the training scenes, and the contact trials cut from them.

use std::collections::BTreeMap;

use underbrush_classifier::trial::{Labels, TrialError, TrialOptions, Unit};
use underbrush_recording::{Dataset, Fault, Recording, Trial};
use underbrush_sim::scene::SceneFile;

use crate::dataset::jobs_of;
use crate::{Campaign, Experiment, Progress, Session, contact_trials};

/// Trials of all reaches of a campaign.
#[derive(Default)]
pub struct Trials {
    /// One per connected component of taxels.
    pub component: Vec<Trial>,
    /// One per taxel.
    pub taxel: Vec<Trial>,
}

/// The training data of a run.
pub struct TrainingData {
    /// The reaches.
    pub dataset: Dataset,
    /// Trials of at least the experiment's number of samples.
    pub trials: Trials,
    /// Taxel trials of any length.
    pub contacts: Vec<Trial>,
}

/// Simulates the training reaches, except those already finished in the run's folder, and extracts trials from them.
pub fn run(session: &Session) -> Result<TrainingData, Fault> {
    let (experiment, progress) = (session.experiment, session.progress);
    let dataset = session.stage("Training reaches", || {
        let campaign = campaign(experiment, session.seed, &reaches(experiment), |_| {})?;
        let folder = session.folder.join("dataset");
        match Dataset::open(&folder) {
            Ok(dataset) if campaign.has_made(&dataset)? => {
                progress.remark(&format!("  taken from {}", folder.display()));
                Ok(dataset)
            }
            _ => Ok(campaign.write(&folder, true, progress)?.dataset()),
        }
    })?;
    let of_any_length = TrialOptions { min_samples: 1, ..experiment.trial_options() };
    let contacts = session.stage("Trials", || Trials::of_dataset(session, &dataset, &of_any_length))?;
    let trials = contacts.lasting(experiment.file.trials.min_samples);
    trials.check_labels(experiment)?;
    Ok(TrainingData { trials, contacts: contacts.taxel, dataset })
}

/// Number of reaches of each training scene.
pub fn reaches(experiment: &Experiment) -> Vec<u64> {
    experiment.file.training.iter().map(|training| training.reaches).collect()
}

/// A campaign with these numbers of reaches of each training scene, after `change` has been applied to each scene. A
/// data set stores the text of a scene and would not show the change, so use changed campaigns only for
/// [`Trials::of_campaign`].
pub fn campaign(
    experiment: &Experiment,
    seed: u64,
    reaches: &[u64],
    change: impl Fn(&mut SceneFile),
) -> Result<Campaign, Fault> {
    let (mut scenes, mut arms) = (Vec::new(), BTreeMap::new());
    for (training, reaches) in experiment.file.training.iter().zip(reaches) {
        let mut scene = experiment.scene(&training.scene)?.clone();
        change(&mut scene.file);
        if let Some(arm) = &experiment.arm {
            arms.insert(scene.name.clone(), arm.clone());
        }
        scenes.push((scene, *reaches));
    }
    Ok(Campaign { scenes, arms, seed, controller: experiment.file.controller, ..Campaign::default() })
}

impl Trials {
    /// The trials of one reach. A patch without a grid has no component trials.
    pub fn cut(recording: &Recording, options: &TrialOptions) -> Result<Self, TrialError> {
        let of_unit = |by| contact_trials::cut(recording, &TrialOptions { by, ..options.clone() });
        let component = match of_unit(Unit::Component) {
            Err(TrialError::NoGrid { .. }) => Vec::new(),
            found => found?,
        };
        Ok(Trials { component, taxel: of_unit(Unit::Taxel)? })
    }

    /// Appends the trials of the reach at a position of the campaign and continues their numbers.
    pub fn append(&mut self, place: usize, label: Option<&str>, other: Trials) {
        for (all, more) in [(&mut self.component, other.component), (&mut self.taxel, other.taxel)] {
            for trial in more {
                all.push(Trial {
                    trial: all.len() as u64,
                    reach: Some(place as u64),
                    category: label.map(str::to_owned).or(trial.category),
                    ..trial
                });
            }
        }
    }

    /// The trials of the run's training reaches, extracted with these options.
    pub fn of_dataset(session: &Session, dataset: &Dataset, options: &TrialOptions) -> Result<Self, Fault> {
        let parts = contact_trials::each_episode(dataset, session.progress, |_, own| Ok(Trials::cut(own, options)?))?;
        Ok(Trials::joined(session.experiment, &reaches(session.experiment), options, parts))
    }

    /// Runs a campaign of the training scenes and keeps only its trials, because the frames of twenty campaigns would fill a disk.
    pub fn of_campaign(experiment: &Experiment, campaign: &Campaign, progress: &dyn Progress) -> Result<Self, Fault> {
        let options = experiment.trial_options();
        let reaches: Vec<u64> = campaign.scenes.iter().map(|(_, reaches)| *reaches).collect();
        let parts = campaign.each(progress, |recording| Ok(Trials::cut(&recording, &options)?))?;
        Ok(Trials::joined(experiment, &reaches, &options, parts))
    }

    /// The trials of all reaches together. They have the labels of their scenes, unless trials are labelled by what
    /// touches the taxel.
    fn joined(experiment: &Experiment, reaches: &[u64], options: &TrialOptions, parts: Vec<Trials>) -> Self {
        let labels: Vec<&str> = experiment.file.training.iter().map(|own| own.label.as_str()).collect();
        let is_labelled = options.labels == Labels::Environment;
        let mut trials = Trials::default();
        for ((place, own), job) in parts.into_iter().enumerate().zip(jobs_of(reaches.iter().copied())) {
            trials.append(place, is_labelled.then(|| labels[job.plan]), own);
        }
        trials
    }

    /// Checks that there are trials of all labels. Classifiers that know fewer categories are right more easily.
    ///
    /// # Errors
    /// If there is no trial of some label.
    pub fn check_labels(&self, experiment: &Experiment) -> Result<(), Fault> {
        let samples = experiment.file.trials.min_samples;
        for label in experiment.labels() {
            let lacks = |trials: &[Trial]| !trials.iter().any(|trial| trial.category.as_deref() == Some(label));
            // A patch without a grid has no component trials at all.
            if lacks(&self.taxel) || (!self.component.is_empty() && lacks(&self.component)) {
                return Err(Fault::Usage(format!(
                    "no trial of {label} in the training reaches has {samples} samples or more; lower trials.min_samples or \
                     trials.threshold_n, or train on more reaches"
                )));
            }
        }
        Ok(())
    }

    /// The trials of at least this many samples, renumbered as if extracted with [`TrialOptions::min_samples`].
    pub fn lasting(&self, min_samples: usize) -> Self {
        let renumbered = |trials: &[Trial]| {
            let long = trials.iter().filter(|trial| trial.samples.len() >= min_samples);
            long.zip(0..).map(|(trial, number)| Trial { trial: number, ..trial.clone() }).collect()
        };
        Trials { component: renumbered(&self.component), taxel: renumbered(&self.taxel) }
    }
}
