//! A controller that presses less on trunks and unknown objects than on leaves, because a touch model tells it what its
//! skin touches.
//!
//! The inner controller has one force limit for all contacts. The outer controller judges every taxel in contact in
//! each frame, and gives each contact the limit for its verdict.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use serde::Serialize;
use underbrush_classifier::touch::{TouchClassifier, TouchModel, TouchVerdict};
use underbrush_recording::{Dataset, Fault, Frame, InputError, JSON_BYTES, MappedObstacle, read_text};
use underbrush_sim::controller::{AllowedForces, ContactVerdict, Controller, ControllerOutput, TaxelContact, Touched};
use underbrush_sim::{ControllerInput, ControllerKind, ReachPlan, Scene};

/// The suffix of the name of a controller with the verdicts of a touch model.
pub const WITH_VERDICTS: &str = "+verdicts";
/// The suffix of the name of a controller that is told the true categories.
pub const WITH_TRUTH: &str = "+truth";

/// The value of `--verdicts` that tells the controller the true categories.
pub const TRUTH: &str = "truth";
/// The value of `--verdicts` that tells the controller nothing.
pub const NONE: &str = "none";
/// The key of the force that is allowed on unknown objects, among those of categories.
const UNKNOWN: &str = "unknown";

/// What judges contacts, and the forces that its verdicts allow. Together they turn a controller into one with verdicts.
#[derive(Clone, Debug)]
pub struct VerdictControl {
    judge: Judge,
    /// Forces by category that replace the usual ones and those of the scene, N.
    asked_n: BTreeMap<String, f64>,
}

/// What judges contacts.
#[derive(Clone, Debug)]
enum Judge {
    /// Nothing: the simulator tells the true categories.
    Truth,
    /// A touch model.
    Model { model: Arc<TouchModel>, blake3: String },
}

/// The parameters of verdict control that data sets store.
#[derive(Serialize)]
pub struct VerdictParameters<'a> {
    /// BLAKE3 hash of the model's file, hexadecimal; `truth` for the true categories.
    pub touch_model_blake3: &'a str,
    /// Version of the sources that compute the verdicts.
    pub sources: &'static str,
    /// How hard the arm may press on which objects.
    pub allowed_force_n: AllowedForces,
}

impl VerdictControl {
    /// The verdicts that the value of an option asks for: [`TRUTH`], [`NONE`], or the path of a touch model.
    ///
    /// # Errors
    /// As [`VerdictControl::load`].
    pub fn named(value: &Path) -> Result<Option<Self>, InputError> {
        match value.to_str() {
            Some(NONE) => Ok(None),
            Some(TRUTH) => Ok(Some(VerdictControl::truth())),
            _ => VerdictControl::load(value).map(Some),
        }
    }

    /// The true categories, which no robot knows. They bound what any model can gain.
    pub fn truth() -> Self {
        VerdictControl { judge: Judge::Truth, asked_n: BTreeMap::new() }
    }

    /// Reads the file of a touch model. The forces are those of [`AllowedForces::default`].
    ///
    /// # Errors
    /// [`InputError`] if it cannot be read, or is no such model.
    pub fn load(path: &Path) -> Result<Self, InputError> {
        let text = read_text(path, &JSON_BYTES, "the readable file of a touch model", "check the path")?;
        VerdictControl::from_json(path, &text)
    }

    /// As [`VerdictControl::load`], from the file's text; the path is for errors only.
    ///
    /// # Errors
    /// As [`VerdictControl::load`].
    pub fn from_json(path: &Path, text: &str) -> Result<Self, InputError> {
        let model = Arc::new(TouchModel::from_json(path, text)?);
        let judge = Judge::Model { model, blake3: blake3::hash(text.as_bytes()).to_hex().to_string() };
        Ok(VerdictControl { judge, asked_n: BTreeMap::new() })
    }

    /// The same verdicts with these forces on categories, N, or on `unknown` objects, instead of the scene's.
    ///
    /// # Errors
    /// If the touch model never gives a verdict of such a name.
    pub fn with_asked(self, asked_n: impl IntoIterator<Item = (String, f64)>) -> Result<Self, Fault> {
        let asked_n: BTreeMap<String, f64> = asked_n.into_iter().collect();
        if let Judge::Model { model, .. } = &self.judge {
            let is_verdict = |name: &String| name == UNKNOWN || model.categories().contains(name);
            if let Some(name) = asked_n.keys().find(|name| !is_verdict(name)) {
                let verdicts = model.categories().join(", ");
                let text = format!("no verdict of the touch model is called {name}; allowed: {verdicts}, {UNKNOWN}");
                return Err(Fault::Usage(text));
            }
        }
        Ok(VerdictControl { asked_n, ..self })
    }

    /// BLAKE3 hash of the model's file, hexadecimal; [`TRUTH`] for the true categories.
    pub fn model_blake3(&self) -> &str {
        match &self.judge {
            Judge::Truth => TRUTH,
            Judge::Model { blake3, .. } => blake3,
        }
    }

    /// The forces that are allowed in a scene.
    fn allowed_in(&self, scene: &Scene) -> AllowedForces {
        let mut categories_n = AllowedForces::default().categories_n;
        let others = scene.file.allowed_force_n.iter().chain(&self.asked_n);
        categories_n.extend(others.map(|(name, force_n)| (name.clone(), *force_n)));
        AllowedForces { unknown_n: categories_n.remove(UNKNOWN), categories_n }
    }

    /// Asks for the forces that a data set stores for a scene, where the scene does not give them itself.
    pub(crate) fn ask_as_stored(&mut self, scene: &Scene, stored: AllowedForces) {
        let own = self.allowed_in(scene);
        let unknown = stored.unknown_n.filter(|_| stored.unknown_n != own.unknown_n);
        let others =
            stored.categories_n.into_iter().filter(|(name, force_n)| own.categories_n.get(name) != Some(force_n));
        self.asked_n.extend(others.chain(unknown.map(|force_n| (UNKNOWN.to_owned(), force_n))));
    }

    /// The parameters of verdict control in a scene that data sets store.
    pub fn parameters(&self, scene: &Scene) -> VerdictParameters<'_> {
        VerdictParameters {
            touch_model_blake3: self.model_blake3(),
            sources: env!("UNDERBRUSH_ANALYSIS_SOURCES"),
            allowed_force_n: self.allowed_in(scene),
        }
    }

    /// The plan with verdicts for its controller.
    ///
    /// # Errors
    /// [`Fault`] if the controller uses no contacts, or the arm's skin lacks the model's patch.
    pub fn applied_to(&self, mut plan: ReachPlan) -> Result<ReachPlan, Fault> {
        if let Some((ControllerKind::Blind, _)) = plan.controller.shipped {
            let text = "the controller blind ignores all contacts and so all verdicts; choose another controller";
            return Err(Fault::Usage(text.into()));
        }
        let (classifier, suffix) = match &self.judge {
            Judge::Truth => (None, WITH_TRUTH),
            Judge::Model { model, .. } => {
                (Some(TouchClassifier::new(model.clone(), &plan.arm.skin.layout)?), WITH_VERDICTS)
            }
        };
        plan.has_true_verdicts = classifier.is_none();
        if let Some(name) = self.asked_n.keys().find(|name| classifier.is_none() && !plan.scene.has_verdict(name)) {
            log::warn!(
                "warning: nothing in scene {} is a {name}, so its allowed force has no effect there",
                plan.scene.name
            );
        }
        let allowed = Arc::new(self.allowed_in(&plan.scene));
        Ok(plan.with_controller_within(move |inner| {
            Box::new(VerdictController {
                name: format!("{}{suffix}", inner.name()),
                inner,
                classifier: classifier.clone(),
                allowed: allowed.clone(),
                is_judged: false,
            })
        }))
    }
}

/// Checks that the given touch model is the one that gave the verdicts of a data set, or that none is given if the set
/// has no verdicts.
pub(crate) fn check_model(dataset: &Dataset, verdicts: Option<&VerdictControl>) -> Result<(), Fault> {
    let mut parameters = dataset.plan().provenance.controller_parameters.values();
    let stored = parameters.find_map(|scene| scene.get("verdicts")?.get("touch_model_blake3")?.as_str());
    let given = verdicts.map(VerdictControl::model_blake3);
    if stored == given {
        return Ok(());
    }
    let path = dataset.dir().join("meta/provenance.json");
    let found = match given {
        None => "no verdicts".into(),
        Some(TRUTH) => "the true categories".into(),
        Some(hash) => format!("a touch model with BLAKE3 hash {hash}"),
    };
    let (allowed, remedy) = match stored {
        Some(TRUTH) => ("the true categories".into(), "give --verdicts truth"),
        Some(hash) => (
            format!("the touch model that the controller used, with BLAKE3 hash {hash}"),
            "give its file with --verdicts",
        ),
        None => ("none: the controller had no verdicts".into(), "leave out --verdicts"),
    };
    Err(InputError::new(path, "controller_parameters", found, allowed, remedy).into())
}

/// A controller whose contacts have limits that depend on verdicts. Taxels of patches other than the model's keep the
/// usual limit.
struct VerdictController {
    name: String,
    inner: Box<dyn Controller>,
    /// `None` if the contacts come with their true categories.
    classifier: Option<TouchClassifier>,
    allowed: Arc<AllowedForces>,
    /// Whether the last frame could be judged. A frame with numbers that are not finite cannot be judged.
    is_judged: bool,
}

impl VerdictController {
    /// The verdict on a contact. A taxel under the model's threshold, or on a patch that it does not judge, has none.
    fn verdict(&self, contact: &TaxelContact) -> Option<ContactVerdict> {
        let Some(classifier) = &self.classifier else { return contact.verdict.clone() };
        let mut taxels = classifier.taxels().iter().filter(|_| self.is_judged);
        let own = taxels.find(|own| (own.patch, own.taxel) == (contact.patch, contact.taxel))?;
        let categories = classifier.model().categories();
        let probabilities = classifier.probabilities(own.region);
        let (touched, probability) = match own.touch {
            TouchVerdict::Nothing => (Touched::Nothing, own.nothing),
            TouchVerdict::Category(index) => {
                (Touched::Category(categories[index].as_str().into()), probabilities[index])
            }
            TouchVerdict::Uncertain => (Touched::Uncertain, probabilities.iter().copied().fold(0.0, f64::max)),
            TouchVerdict::Unknown => (Touched::Unknown, 1.0 - classifier.regions()[own.region].share_beyond),
        };
        Some(ContactVerdict { touched, probability })
    }
}

impl Controller for VerdictController {
    fn name(&self) -> &str {
        &self.name
    }

    fn rate_hz(&self) -> f64 {
        self.inner.rate_hz()
    }

    fn observe(&mut self, frame: &Frame) {
        self.is_judged = self.classifier.as_mut().is_some_and(|classifier| classifier.update(frame).is_ok());
        self.inner.observe(frame);
    }

    fn map(&self) -> Vec<MappedObstacle> {
        self.inner.map()
    }

    fn control(&mut self, input: &ControllerInput) -> ControllerOutput {
        let mut judged = input.clone();
        judged.contacts.retain_mut(|contact| {
            let verdict = self.verdict(contact);
            self.allowed.apply(contact, verdict)
        });
        self.inner.control(&judged)
    }
}
