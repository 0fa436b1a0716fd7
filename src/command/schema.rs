//! `underbrush schema`: the JSON Schema of a file that a person edits or another program writes.

use clap::{Args, ValueEnum};
use serde::Serialize;
use serde_json::Value;

use crate::{Failure, output};

/// Options of `underbrush schema`.
#[derive(Args)]
pub struct SchemaOptions {
    /// The kind of file
    #[arg(value_enum, default_value = "scene")]
    file: Kind,
}

/// The kinds of file that have a schema.
#[derive(Clone, Copy, ValueEnum)]
pub enum Kind {
    /// Scene: what stands in front of the arm, and how it is sensed
    Scene,
    /// Arm: the properties of an arm that its URDF cannot express
    Arm,
    /// Skin: patches of taxels on an arm's links
    Skin,
    /// Experiment: scenes to train and test on, classifiers, and figures to compare with
    Experiment,
    /// Suite: scenes with bounds on the results of running them, for `underbrush check`
    Suite,
    /// Mapping: where a file of another robot holds times and forces, for `underbrush import`
    Mapping,
    /// Model: a fitted classifier of trials
    Model,
    /// Touch: a fitted classifier of frames (--classifier touch)
    Touch,
}

impl Kind {
    /// The schema.
    pub fn schema(self) -> impl Serialize + Into<Value> {
        match self {
            Kind::Scene => underbrush_sim::scene::schema(),
            Kind::Arm => underbrush_sim::arm::schema(),
            Kind::Skin => underbrush_sim::arm::skin_schema(),
            Kind::Experiment => underbrush_experiments::definition::schema(),
            Kind::Suite => underbrush_experiments::suite::schema(),
            Kind::Mapping => underbrush_exchange::import::mapping_schema(),
            Kind::Model => underbrush_classifier::model_schema(),
            Kind::Touch => underbrush_classifier::touch::TouchModel::schema(),
        }
    }
}

/// Prints the schema.
pub fn run(options: SchemaOptions, _json: bool) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(&options.file.schema());
    output::line(&text.map_err(|error| Failure::run(error.to_string()))?)
}
