//! The controllers that ship, by name.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use underbrush_recording::Fault;

use super::{Controller, Mapped, ModelPredictive, Preset};
use crate::arm::Arm;

/// A controller that ships; by default the one with the parameters of the authors' robot with its flipper.
///
/// ```
/// use underbrush_sim::controller::ControllerKind;
///
/// let kind = ControllerKind::from_name("cody-2013")?;
/// assert_eq!(kind.name(), "cody-2013");
/// // An unknown name gives the known ones.
/// assert!(ControllerKind::from_name("cody").unwrap_err().to_string().contains("cody-2013"));
/// # Ok::<(), underbrush_sim::controller::UnknownController>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(try_from = "String")]
pub enum ControllerKind {
    /// The model-predictive controller with the parameters of [`Preset::cody_2013`].
    #[default]
    Cody2013,
    /// The model-predictive controller with the parameters of [`Preset::ijrr_foliage`].
    IjrrFoliage,
    /// `Cody2013` without tactile feedback.
    Blind,
    /// A map of what was touched and a planned way round, with the speed and force limit of `Cody2013`.
    Mapped,
}

/// The list of them.
const ALL: [ControllerKind; 4] =
    [ControllerKind::Cody2013, ControllerKind::IjrrFoliage, ControllerKind::Blind, ControllerKind::Mapped];

/// The error for an unknown name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown controller `{0}`, expected one of {list}", list = ControllerKind::names().join(", "))]
pub struct UnknownController(String);

impl From<UnknownController> for Fault {
    fn from(error: UnknownController) -> Self {
        Fault::Usage(error.to_string())
    }
}

impl ControllerKind {
    /// Names of all controllers in scene files and recordings.
    pub fn names() -> [&'static str; ALL.len()] {
        ALL.map(ControllerKind::name)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        self.preset().name
    }

    /// The controller with this name.
    ///
    /// # Errors
    /// When there is none.
    pub fn from_name(name: &str) -> Result<ControllerKind, UnknownController> {
        ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| UnknownController(name.to_string()))
    }

    /// Its parameters: those that were published, or those that it shares with a published controller.
    pub fn preset(self) -> Preset {
        match self {
            ControllerKind::Cody2013 => Preset::cody_2013(),
            ControllerKind::IjrrFoliage => Preset::ijrr_foliage(),
            // No force is above this, so it ignores all contacts.
            ControllerKind::Blind => Preset { name: "blind", ignored_force_n: f64::INFINITY, ..Preset::cody_2013() },
            ControllerKind::Mapped => Preset { name: "mapped", ..Preset::cody_2013() },
        }
    }

    /// The controller of an arm, with these parameters. `Blind` ignores all contacts with any of them.
    pub fn controller(self, preset: Preset, arm: &Arm) -> Box<dyn Controller> {
        match self {
            ControllerKind::Cody2013 | ControllerKind::IjrrFoliage => Box::new(ModelPredictive::new(preset, arm)),
            ControllerKind::Blind => {
                Box::new(ModelPredictive::new(Preset { ignored_force_n: f64::INFINITY, ..preset }, arm))
            }
            ControllerKind::Mapped => Box::new(Mapped::new(preset, arm)),
        }
    }
}

impl TryFrom<String> for ControllerKind {
    type Error = UnknownController;

    fn try_from(name: String) -> Result<Self, UnknownController> {
        ControllerKind::from_name(&name)
    }
}

impl JsonSchema for ControllerKind {
    fn schema_name() -> Cow<'static, str> {
        "ControllerKind".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({ "type": "string", "enum": ControllerKind::names() })
    }
}
