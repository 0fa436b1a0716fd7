//! A controller that presses less on trunks and unknown objects than on leaves, because a touch model tells it what its
//! skin touches.
//!
//! The inner controller has one force limit for all contacts. The outer controller judges every taxel in contact in
//! each frame, and gives each contact the limit for its verdict.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use serde::Serialize;
use underbrush_classifier::touch::{Touch, TouchClassifier, TouchModel};
use underbrush_recording::disk::Dataset;
use underbrush_recording::fault::Fault;
use underbrush_recording::limits::JSON_BYTES;
use underbrush_recording::{Frame, InputError, read_text};
use underbrush_sim::controller::{Controller, ControllerInput, ControllerKind, ControllerOutput, TaxelContact};
use underbrush_sim::reach::{PlannedController, ReachPlan};

/// The suffix of the name of a controller with verdicts.
pub const WITH_VERDICTS: &str = "+verdicts";

/// How hard the arm may press on which objects, N. The controller's own limit holds for everything else.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AllowedForces {
    /// The limits by the name of a known category, N.
    pub categories_n: BTreeMap<String, f64>,
    /// The limit on objects unlike all known categories, N.
    pub unknown_n: f64,
}

impl Default for AllowedForces {
    /// 6 N on leaves, twice the 3 N of `cody-2013`. A leaf bends away before a taxel feels as much (5.4 N at most in 14
    /// mixed reaches), so this limit hardly ever holds the arm back. 1.5 N on trunks and unknown objects, half of the
    /// limit of `cody-2013`. This limit must be above 1 N, the force at which the controller begins to take a reading
    /// for a contact, because the force of a contact over its limit may not rise at all.
    fn default() -> Self {
        AllowedForces { categories_n: [("leaf".to_owned(), 6.0), ("trunk".to_owned(), 1.5)].into(), unknown_n: 1.5 }
    }
}

/// What a verdict means for a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Allowance {
    /// The reading is not a contact.
    Ignored,
    /// The controller's own limit holds.
    Usual,
    /// The contact has this limit, N.
    AtMost(f64),
}

impl AllowedForces {
    /// What a verdict means for a contact; `categories` are the model's categories.
    pub fn of(&self, touch: Touch, categories: &[String]) -> Allowance {
        match touch {
            Touch::Nothing => Allowance::Ignored,
            Touch::Uncertain => Allowance::Usual,
            Touch::Unknown => Allowance::AtMost(self.unknown_n),
            Touch::Category(index) => {
                let own = categories.get(index).and_then(|name| self.categories_n.get(name));
                own.map_or(Allowance::Usual, |force_n| Allowance::AtMost(*force_n))
            }
        }
    }
}

impl Allowance {
    /// The contact with its limit; `None` if it is to be ignored.
    pub fn apply(self, contact: &TaxelContact) -> Option<TaxelContact> {
        let allowed_force_n = match self {
            Allowance::Ignored => return None,
            Allowance::Usual => contact.allowed_force_n,
            Allowance::AtMost(force_n) => Some(force_n),
        };
        Some(TaxelContact { allowed_force_n, ..contact.clone() })
    }
}

/// A touch model and the forces that its verdicts allow. Together they turn a controller into one with verdicts.
#[derive(Clone, Debug)]
pub struct VerdictControl {
    model: Arc<TouchModel>,
    model_blake3: String,
    allowed: AllowedForces,
}

/// The parameters of verdict control that data sets store.
#[derive(Serialize)]
pub struct VerdictParameters<'a> {
    /// BLAKE3 hash of the model's file, hexadecimal.
    pub touch_model_blake3: &'a str,
    /// Version of the sources that compute the verdicts.
    pub sources: &'static str,
    /// How hard the arm may press on which objects.
    pub allowed_force_n: &'a AllowedForces,
}

impl VerdictControl {
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
        Ok(VerdictControl {
            model: Arc::new(TouchModel::from_json(path, text)?),
            model_blake3: blake3::hash(text.as_bytes()).to_hex().to_string(),
            allowed: AllowedForces::default(),
        })
    }

    /// The same model with other allowed forces.
    pub fn with_allowed(self, allowed: AllowedForces) -> Self {
        VerdictControl { allowed, ..self }
    }

    /// BLAKE3 hash of the model's file, hexadecimal.
    pub fn model_blake3(&self) -> &str {
        &self.model_blake3
    }

    /// The parameters of verdict control that data sets store.
    pub fn parameters(&self) -> VerdictParameters<'_> {
        VerdictParameters {
            touch_model_blake3: &self.model_blake3,
            sources: env!("UNDERBRUSH_ANALYSIS_SOURCES"),
            allowed_force_n: &self.allowed,
        }
    }

    /// The plan with verdicts for its controller.
    ///
    /// # Errors
    /// [`Fault`] if the controller uses no contacts, or the arm's skin lacks the model's patch.
    pub fn applied_to(&self, plan: ReachPlan) -> Result<ReachPlan, Fault> {
        if let PlannedController::Shipped(ControllerKind::Blind, _) = plan.controller {
            let text = "the controller blind ignores all contacts and so all verdicts; choose another controller";
            return Err(Fault::Usage(text.into()));
        }
        let layout = &plan.arm.skin.layout;
        let classifier = TouchClassifier::new(self.model.clone(), layout)?;
        let allowed = Arc::new(self.allowed.clone());
        Ok(plan.with_controller_within(move |inner| {
            Box::new(VerdictController {
                name: format!("{}{WITH_VERDICTS}", inner.name()),
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
    let mut parameters = dataset.provenance().controller_parameters.values();
    let stored = parameters.find_map(|scene| scene.get("verdicts")?.get("touch_model_blake3")?.as_str());
    let given = verdicts.map(VerdictControl::model_blake3);
    if stored == given {
        return Ok(());
    }
    let path = dataset.dir().join("meta/provenance.json");
    let found = given.map_or("no touch model".into(), |hash| format!("a touch model with BLAKE3 hash {hash}"));
    let (allowed, remedy) = match stored {
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
    classifier: TouchClassifier,
    allowed: Arc<AllowedForces>,
    /// Whether the last frame could be judged. A frame with numbers that are not finite cannot be judged.
    is_judged: bool,
}

impl VerdictController {
    fn allowance(&self, contact: &TaxelContact) -> Allowance {
        let mut taxels = self.classifier.taxels().iter().filter(|_| self.is_judged);
        // A taxel under the model's threshold, or on a patch that it does not judge, has no verdict.
        let found = taxels.find(|verdict| (verdict.patch, verdict.taxel) == (contact.patch, contact.taxel));
        let Some(verdict) = found else {
            return Allowance::Usual;
        };
        self.allowed.of(verdict.touch, self.classifier.model().categories())
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
        self.is_judged = self.classifier.update(frame).is_ok();
        self.inner.observe(frame);
    }

    fn control(&mut self, input: &ControllerInput<'_>) -> ControllerOutput {
        let contacts = input.contacts.iter();
        let contacts: Vec<TaxelContact> =
            contacts.filter_map(|contact| self.allowance(contact).apply(contact)).collect();
        self.inner.control(&ControllerInput { contacts: &contacts, ..input.clone() })
    }
}
