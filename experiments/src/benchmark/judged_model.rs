//! A model of any kind that follows a reach and answers, frame by frame, what touches each taxel.
//!
//! Contacts are as the benchmark defines them: every taxel of the patch from the first frame above [`THRESHOLD_N`] to
//! the last.

use std::path::Path;
use std::sync::Arc;

use underbrush_classifier::any_model::{self, AnyModel};
use underbrush_classifier::decision::{Decision, Judge};
use underbrush_classifier::evaluate::NOTHING;
use underbrush_classifier::online::OnlineOptions;
use underbrush_classifier::online_model::{OnlineJudge, OnlineModel};
use underbrush_classifier::trial::PatchImage;
use underbrush_recording::disk::file_blake3;
use underbrush_recording::fault::Fault;
use underbrush_recording::{Category, Frame, InputError, Recording};

use super::contacts::{Answer, Class, Contact, OpenContact, SILENCE};
use super::frozen::{PATCH, THRESHOLD_N};

/// A model that is judged.
pub struct JudgedModel {
    /// Name of its file without the ending.
    pub name: String,
    /// BLAKE3 hash of its file, hexadecimal.
    pub blake3: String,
    /// Name of its classifier.
    pub classifier: String,
    model: OnlineModel,
    /// The classes of its categories.
    classes: Vec<Class>,
    /// Tells by how much the scores of a classifier of trials differ.
    judge: Judge,
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
                if let Some(patch) = model.options().patch.as_deref().filter(|patch| *patch != PATCH) {
                    let remedy = "fit it to that patch";
                    return Err(InputError::new(path, "options.patch", patch, PATCH, remedy).into());
                }
                ("touch", OnlineModel::Touch(Arc::from(model)))
            }
            AnyModel::OfTrials(model) => {
                let options = OnlineOptions::new(Some(PATCH.to_owned()), Some(THRESHOLD_N), Decision::argmax());
                (model.classifier.name(), OnlineModel::OfTrials(Box::new(model), options))
            }
        };
        let categories = model.categories();
        let needed = [Category::LEAF, Category::TRUNK].map(Category::name);
        if let Some(missing) = needed.iter().find(|name| !categories.iter().any(|own| own == *name)) {
            let found = format!("no {missing}, only {}", categories.join(", "));
            let remedy = "train it on leaves and trunks, as with the benchmark's training set";
            return Err(InputError::new(path, "categories", found, "leaf and trunk", remedy).into());
        }
        Ok(JudgedModel {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            blake3,
            classifier: classifier.to_owned(),
            model,
            classes: categories.iter().map(|name| class_of(name)).collect(),
            judge: Decision::argmax().prepare(&categories)?,
        })
    }

    /// All contacts of a reach.
    ///
    /// # Errors
    /// If the model cannot judge this skin.
    pub(super) fn contacts(&self, recording: &Recording) -> Result<Vec<Contact>, Fault> {
        let mut judging = self.model.begin(&recording.layout)?;
        let patch = recording.layout.patch_index(PATCH).unwrap_or_default();
        let mut image = PatchImage::new(&recording.layout, Some(PATCH), THRESHOLD_N)?;
        let taxels = image.patch().taxels.len();
        let mut answers = vec![SILENCE; taxels];
        let mut open: Vec<Option<OpenContact>> = vec![None; taxels];
        let mut contacts = Vec::new();
        for (index, frame) in recording.frames.iter().enumerate() {
            image.read(index, frame)?;
            answers.fill(SILENCE);
            self.answer(&mut judging, patch, frame, &mut answers)?;
            for (taxel, open) in open.iter_mut().enumerate() {
                if image.is_in_contact(taxel) {
                    open.get_or_insert_default().push(answers[taxel], image.pressing(taxel, recording));
                } else if let Some(ended) = open.take() {
                    contacts.extend(ended.close());
                }
            }
        }
        contacts.extend(open.into_iter().flatten().filter_map(OpenContact::close));
        Ok(contacts)
    }

    /// Processes the next frame and writes the answer for each taxel that the model judges.
    fn answer(
        &self,
        judging: &mut OnlineJudge,
        patch: usize,
        frame: &Frame,
        answers: &mut [Answer],
    ) -> Result<(), Fault> {
        let classes = &self.classes;
        match judging {
            OnlineJudge::Touch(classifier) => {
                classifier.update(frame)?;
                for taxel in classifier.taxels().iter().filter(|taxel| taxel.patch == patch) {
                    let probabilities = classifier.probabilities(taxel.region);
                    let likeliest = likeliest(classes, probabilities);
                    let is_touch = (1.0 - taxel.nothing) * largest(probabilities) >= taxel.nothing;
                    answers[taxel.taxel] = Answer {
                        likeliest: if is_touch { likeliest } else { Class::Nothing },
                        trunk: is_trunk(classes, probabilities),
                        unlike: -classifier.regions()[taxel.region].share_beyond,
                    };
                }
            }
            OnlineJudge::OfTrials(online) => {
                for taxel in online.update(frame)? {
                    answers[taxel.taxel] = Answer {
                        likeliest: likeliest(classes, &taxel.scores),
                        trunk: is_trunk(classes, &taxel.scores),
                        // The paper calls a contact an outlier if the margin between the best two categories is small.
                        unlike: -self.judge.margin(&taxel.scores).map_or(0.0, |(_, margin)| margin),
                    };
                }
            }
        }
        Ok(())
    }
}

fn class_of(category: &str) -> Class {
    match category {
        _ if category == Category::LEAF.name() => Class::Leaf,
        _ if category == Category::TRUNK.name() => Class::Trunk,
        NOTHING => Class::Nothing,
        _ => Class::Other,
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}

/// The class with the largest value; the first one if several classes have it.
fn likeliest(classes: &[Class], values: &[f64]) -> Class {
    let best = classes.iter().zip(values).reduce(|best, other| if other.1 > best.1 { other } else { best });
    best.map_or(Class::Nothing, |(class, _)| *class)
}

fn is_trunk(classes: &[Class], values: &[f64]) -> Option<bool> {
    let of = |wanted: Class| classes.iter().zip(values).find(|(class, _)| **class == wanted).map(|(_, value)| *value);
    let (leaf, trunk) = (of(Class::Leaf)?, of(Class::Trunk)?);
    (leaf != trunk).then_some(trunk > leaf)
}
