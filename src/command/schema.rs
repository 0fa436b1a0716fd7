//! `underbrush schema`: the JSON Schema of the scene file.

use crate::failure::Failure;
use crate::output;

/// Prints the schema.
pub fn run() -> Result<(), Failure> {
    let schema = serde_json::to_string_pretty(&underbrush_sim::scene::schema());
    output::lines([schema.map_err(|error| Failure::run(error.to_string()))?])
}
