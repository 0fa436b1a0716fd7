//! The native module of the Python package `underbrush`. It converts arguments and results, and holds no physics and no
//! statistics. Without the feature `extension` it is empty.
#![cfg(feature = "extension")]
#![allow(clippy::too_many_arguments, reason = "options by name")]

mod arguments;
mod arm;
mod array;
mod benchmark;
mod classifier;
mod command_line;
mod controller;
mod controller_input;
mod dataset;
mod environment;
mod evaluation;
mod failure;
mod fitting;
mod frame;
mod generate;
mod given;
mod interrupt;
mod json;
mod online;
mod picture;
mod pool;
mod progress;
mod python_classifier;
mod reach;
mod replay;
mod scene;
mod sequences;
mod simulation;
mod skin;
mod study;
mod table;
mod touch;
mod trials;
mod validation;
mod warning;

use arm::PyArm;
use classifier::PyModel;
use dataset::PyDataset;
use failure::{Answer, Failure, locked, place, places};
use frame::PyFrame;
use interrupt::Stop;
use pool::alone;
use progress::{Reported, watched};
use scene::PyScene;
use skin::{Skin, patch_index};
use table::{Column, PyTable};
use trials::Trials;

/// The native part of underbrush.
#[pyo3::pymodule(gil_used = true)]
mod _core {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::{
        arm::PyArm,
        array::Numbers,
        benchmark::{benchmark, benchmark_part, benchmark_sets},
        classifier::PyModel,
        command_line::run_command_line,
        controller::ShippedController,
        controller_input::PyControllerInput,
        dataset::PyDataset,
        environment::PyEnvironments,
        evaluation::evaluate_trials,
        fitting::{Options, classifiers, fit},
        frame::PyFrame,
        generate::{generate, generate_again, merge},
        online::{Online, online},
        picture::PyCamera,
        reach::{Reach, simulate},
        replay::{_check_free, replay_page},
        scene::PyScene,
        simulation::{PySimulation, step_many},
        skin::Skin,
        study::{check, inspect, reproduce, run_campaign},
        table::PyTable,
        touch::PyTouchModel,
        trials::Trials,
        validation::{checks, validate},
    };

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        underbrush_experiments::show_warnings(crate::warning::show);
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("PROGRAM_VERSION", underbrush_experiments::dataset::PROGRAM_VERSION)
    }
}
