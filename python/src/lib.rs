//! The native module of the Python package `underbrush`. It converts arguments and results, and holds no physics and no
//! statistics. Without the feature `extension` it is empty.
#![cfg(feature = "extension")]
#![allow(clippy::too_many_arguments, reason = "options by name")]

mod argument;
mod arm;
mod array;
mod classifier;
mod controller;
mod dataset;
mod environment;
mod failure;
mod fitting;
mod frame;
mod generate;
mod given;
mod json;
mod online;
mod picture;
mod pool;
mod progress;
mod python_classifier;
mod reach;
mod scene;
mod simulate;
mod simulation;
mod study;
mod table;
mod touch;
mod trials;

use arm::{PyArm, Skin, patch_index};
use classifier::PyModel;
use dataset::PyDataset;
use failure::{Answer, Failure, locked, place, places, show_warning, warn};
use frame::PyFrame;
use picture::PyCamera;
use pool::alone;
use progress::{Reported, Stop, watched};
use scene::{PyScene, scene};
use table::{Column, PyTable};
use trials::Trials;

/// The native part of underbrush.
#[pyo3::pymodule(gil_used = true)]
mod _core {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::{
        arm::{PyArm, Skin},
        array::Numbers,
        classifier::PyModel,
        controller::{PyControllerInput, ShippedController},
        dataset::PyDataset,
        environment::PyEnvironments,
        fitting::{Options, classifiers, evaluate_trials, fit},
        frame::PyFrame,
        generate::{generate, generate_again, merge},
        online::{Online, online},
        picture::{_check_free, _with_recordings, PyCamera, replay_page},
        reach::Reach,
        scene::PyScene,
        simulate::simulate,
        simulation::{PySimulation, step_many},
        study::{
            benchmark, benchmark_part, benchmark_sets, check, checks, inspect, reproduce, run_campaign,
            run_command_line, validate,
        },
        table::PyTable,
        touch::PyTouchModel,
        trials::Trials,
    };

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        underbrush_experiments::show_warnings(crate::show_warning);
        module.add("__version__", env!("CARGO_PKG_VERSION"))?;
        module.add("FILM_FPS", underbrush_render::Film::FPS)?;
        module.add("PROGRAM_VERSION", underbrush_experiments::dataset::PROGRAM_VERSION)
    }
}
