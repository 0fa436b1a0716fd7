//! The native module of the Python package `underbrush`. It converts arguments and results, and holds no physics and no
//! statistics. Without the feature `extension` it is empty.
#![cfg(feature = "extension")]

use pyo3::prelude::*;

mod arguments;
mod arm;
mod array;
mod benchmark;
mod body;
mod classifier;
mod controller;
mod controller_input;
mod dataset;
mod environment;
mod evaluation;
mod failure;
mod fitting;
mod frame;
mod generate;
mod interrupt;
mod json;
mod merge;
mod model_kind;
mod online;
mod pickled;
mod pool;
mod progress;
mod python_classifier;
mod reach;
mod replay;
mod scene;
mod sequences;
mod simulate;
mod simulation;
mod skin;
mod source;
mod study;
mod table;
mod touch;
mod trial;
mod trials;
mod validation;
mod warning;

/// The native part of underbrush.
#[pymodule(gil_used = true)]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("PROGRAM_VERSION", underbrush_experiments::dataset::PROGRAM_VERSION)?;
    warning::show();
    scene::add_to(module)?;
    skin::add_to(module)?;
    frame::add_to(module)?;
    arm::add_to(module)?;
    simulation::add_to(module)?;
    controller_input::add_to(module)?;
    controller::add_to(module)?;
    reach::add_to(module)?;
    simulate::add_to(module)?;
    table::add_to(module)?;
    dataset::add_to(module)?;
    generate::add_to(module)?;
    merge::add_to(module)?;
    trial::add_to(module)?;
    trials::add_to(module)?;
    classifier::add_to(module)?;
    fitting::add_to(module)?;
    evaluation::add_to(module)?;
    online::add_to(module)?;
    touch::add_to(module)?;
    environment::add_to(module)?;
    validation::add_to(module)?;
    replay::add_to(module)?;
    study::add_to(module)?;
    benchmark::add_to(module)?;
    array::add_to(module)
}
