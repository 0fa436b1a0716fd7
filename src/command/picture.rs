//! The picture of a reach.

use std::path::{Path, PathBuf};

use underbrush_recording::{Frame, Recording};
use underbrush_report::picture;
use underbrush_sim::scene::SceneFile;
use underbrush_sim::simulation::Simulation;
use underbrush_sim::snapshot::Snapshot;

use super::overwrite::Overwrite;
use crate::failure::Failure;
use crate::{input, output};

/// The file to write, and the moment to draw in it.
pub struct Picture {
    path: Option<PathBuf>,
    /// The frame in which the most taxels read a force.
    fullest: Option<Snapshot>,
}

impl Picture {
    /// A picture without a moment yet.
    ///
    /// # Errors
    /// If the file is not SVG, is there already and may not be overwritten, or cannot be written.
    pub fn new(path: Option<PathBuf>, overwrite: Overwrite, inputs: &[PathBuf]) -> Result<Self, Failure> {
        if let Some(path) = &path {
            require_svg("--picture", "a picture", path)?;
            overwrite.file(path, inputs)?;
        }
        Ok(Picture { path, fullest: None })
    }

    /// Keeps what the picture needs of a frame.
    pub fn observe(&mut self, simulation: &Simulation, frame: &Frame) {
        let fullest = self.fullest.as_ref().map(|snapshot| snapshot.frame.taxels.len());
        if self.path.is_some() && fullest.is_none_or(|most| frame.taxels.len() > most) {
            self.fullest = Some(Snapshot::take(simulation, frame));
        }
    }

    /// Writes the file.
    pub fn write(&self, scene: &SceneFile, recording: &Recording) -> Result<(), Failure> {
        let (Some(path), Some(snapshot)) = (&self.path, &self.fullest) else { return Ok(()) };
        let (seed, reach, time_s) = (recording.seed, recording.reach_index, snapshot.frame.time_s);
        let caption = format!("{}, seed {seed}, reach {reach}: {time_s:.2} s after the start", scene.summary);
        let categories = input::object_categories(recording);
        let svg = picture::draw(snapshot, &recording.layout, &categories, &scene.workspace, &caption);
        output::write_file(path, svg.as_bytes())
    }
}

/// Demands that the file of an option is SVG.
///
/// # Errors
/// If its name ends otherwise.
pub fn require_svg(option: &str, what: &str, path: &Path) -> Result<(), Failure> {
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("svg")) {
        return Ok(());
    }
    let path = path.display();
    Err(Failure::usage(format!("{option} {path}: {what} is written as SVG; give a file name that ends in .svg")))
}
