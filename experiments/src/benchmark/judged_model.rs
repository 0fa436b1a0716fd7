//! A model of any kind that follows a reach and answers, frame by frame, what touches each taxel.
//!
//! Contacts are as the benchmark defines them: a taxel is in contact while it senses more than [`THRESHOLD_N`].

use std::path::Path;
use std::sync::Arc;

use underbrush_classifier::any_model::{self, AnyModel, OnlineJudge, OnlineModel};
use underbrush_classifier::evaluate::NOTHING;
use underbrush_classifier::touch::TouchVerdict;
use underbrush_classifier::trial::PatchImage;
use underbrush_classifier::{OnlineClassifier, OnlineError, OnlineOptions};
use underbrush_recording::disk::file_blake3;
use underbrush_recording::{Fault, Frame, InputError, Recording, SkinLayout};

use super::counts::{Counts, FrameCounts};
use super::frozen::{FLIPPER, FOREARM, THRESHOLD_N};
use super::objects::{CATEGORIES, END, JudgedObject, ObjectLog, Standing, truth_of};

/// A model that is judged.
pub struct JudgedModel {
    /// Name of its file without the ending.
    pub name: String,
    /// BLAKE3 hash of its file, hexadecimal.
    pub blake3: String,
    /// Name of its classifier.
    pub classifier: String,
    model: OnlineModel,
}

/// What a model says in a reach.
pub(super) struct JudgedReach {
    /// The objects that touch the forearm, and those that touch the flipper; `None` if the model does not judge it, or the
    /// arm has none.
    pub(super) objects: [Option<Vec<JudgedObject>>; 2],
    /// The taxels of the forearm in contact, frame by frame.
    pub(super) frames: FrameCounts,
}

impl JudgedReach {
    /// The verdicts on the objects that touch the forearm, at their end.
    pub(super) fn at_end(&self) -> Counts {
        Counts::of(self.objects[0].as_deref().unwrap_or_default(), END)
    }
}

impl JudgedModel {
    /// Reads a model file of any kind.
    ///
    /// # Errors
    /// If it cannot be read, does not know both leaf and trunk, or judges another patch.
    pub fn load(path: &Path) -> Result<Self, Fault> {
        let model = any_model::load(path)?;
        let blake3 = file_blake3(path)?;
        let (classifier, model) = match model {
            AnyModel::Touch(model) => {
                if let Some(patch) = model.options().patch.as_deref().filter(|patch| *patch != FOREARM) {
                    return Err(InputError::new(path, "options.patch", patch, FOREARM, "fit it to that patch").into());
                }
                ("touch", OnlineModel::Touch(Arc::from(model)))
            }
            AnyModel::OfTrials(model) => {
                (model.classifier.name(), OnlineModel::of_trials(model, Some(FOREARM.to_owned()), Some(THRESHOLD_N)))
            }
        };
        let categories = model.categories();
        if let Some(missing) = CATEGORIES.iter().find(|name| !categories.iter().any(|own| own == *name)) {
            let found = format!("no {missing}, only {}", categories.join(", "));
            let remedy = "train it on leaves and trunks, as with the benchmark's training set";
            return Err(InputError::new(path, "categories", found, "leaf and trunk", remedy).into());
        }
        Ok(JudgedModel {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            blake3,
            classifier: classifier.to_owned(),
            model,
        })
    }

    /// Whether it can answer that nothing touches a taxel.
    pub(super) fn knows_nothing(&self) -> bool {
        matches!(self.model, OnlineModel::Touch(_)) || self.model.categories().iter().any(|own| own == NOTHING)
    }

    /// What it says in a reach. It is shown what a robot knows and no ground truth.
    ///
    /// # Errors
    /// If it cannot judge this skin.
    pub(super) fn judge(&self, recording: &Recording) -> Result<JudgedReach, Fault> {
        let layout = &recording.layout;
        let (mut judging, standing, flipper) = self.begin(layout)?;
        let image = |patch| PatchImage::new(layout, Some(patch), THRESHOLD_N);
        let mut images = vec![image(FOREARM)?];
        if flipper {
            images.push(image(FLIPPER)?);
        }
        let mut answers: Vec<Vec<TouchVerdict>> =
            images.iter().map(|image| vec![TouchVerdict::Nothing; image.patch().taxels.len()]).collect();
        let mut logs: Vec<ObjectLog> = images.iter().map(|_| ObjectLog::new(standing)).collect();
        let mut frames = FrameCounts::default();
        let category = |object: u16| recording.category_of(object);
        for (index, frame) in recording.frames.iter().enumerate() {
            answers.iter_mut().for_each(|own| own.fill(TouchVerdict::Nothing));
            Self::answer(&mut judging, &frame.sensed(), &images, &mut answers)?;
            for (place, image) in images.iter_mut().enumerate() {
                image.read(frame)?;
                for (taxel, answer) in answers[place].iter().enumerate().filter(|own| image.is_in_contact(own.0)) {
                    let pressing = image.pressing(taxel);
                    if let Some(object) = pressing {
                        logs[place].push(object, *answer);
                    }
                    let truth = pressing.map_or(Some(TouchVerdict::Nothing), |object| truth_of(category(object)?));
                    if let Some(truth) = truth.filter(|_| place == 0) {
                        frames.push(image.sensed_force_n(taxel), *answer, truth);
                    }
                }
                logs[place].end_frame(index);
            }
        }
        let mut objects = logs.into_iter().map(|log| log.finish(category));
        Ok(JudgedReach { objects: [objects.next(), objects.next()], frames })
    }

    /// Begins a reach: what judges it, which of its verdicts on an object stands, and whether it judges the flipper. A touch
    /// model judges both patches, and a classifier of trials follows each of them on its own.
    fn begin(&self, layout: &SkinLayout) -> Result<(Vec<OnlineJudge>, Standing, bool), Fault> {
        let flipper = layout.patch_index(FLIPPER);
        let mut judging = vec![self.model.begin(layout)?];
        match &self.model {
            OnlineModel::Touch(model) => {
                let judged = model.options().judged_patches(layout);
                Ok((judging, Standing::Latest, flipper.is_some_and(|own| judged.contains(&own))))
            }
            OnlineModel::OfTrials(model, options) => {
                let options = OnlineOptions { patch: Some(FLIPPER.to_owned()), ..options.clone() };
                match flipper.map(|_| OnlineClassifier::new(model.classifier.as_ref(), layout, &options)) {
                    // Its taxels form no grid, so there are no contact regions on it.
                    None | Some(Err(OnlineError::NoRegion { .. })) => {}
                    Some(own) => judging.push(OnlineJudge::OfTrials(Box::new(own?))),
                }
                let flipper = judging.len() == 2;
                Ok((judging, Standing::MostOfTheTime, flipper))
            }
        }
    }

    /// Shows the model the next frame, and writes its answers for the taxels of each patch.
    fn answer(
        judging: &mut [OnlineJudge],
        sensed: &Frame,
        images: &[PatchImage],
        answers: &mut [Vec<TouchVerdict>],
    ) -> Result<(), Fault> {
        for (place, judge) in judging.iter_mut().enumerate() {
            match judge {
                OnlineJudge::Touch(classifier) => {
                    classifier.update(sensed)?;
                    let categories = classifier.model().categories();
                    for own in classifier.taxels() {
                        let image = images.iter().position(|image| image.patch_index() == own.patch);
                        let Some(image) = image else { continue };
                        answers[image][own.taxel] = TouchVerdict::named(own.touch.name(categories), &CATEGORIES);
                    }
                }
                OnlineJudge::OfTrials(online) => {
                    for own in online.update(sensed)? {
                        answers[place][own.taxel] = TouchVerdict::named(own.verdict.name(), &CATEGORIES);
                    }
                }
            }
        }
        Ok(())
    }
}
