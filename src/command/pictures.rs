//! The pictures of a reach: one moment, and an animation.

use std::path::{Path, PathBuf};

use underbrush_recording::{Frame, Recording};
use underbrush_report::picture;
use underbrush_sim::scene::SceneFile;
use underbrush_sim::simulation::Simulation;
use underbrush_sim::snapshot::Snapshot;

use super::overwrite::Overwrite;
use crate::failure::Failure;
use crate::{input, output};

/// An animation is drawn from the moments of every tenth frame, 0.1 s apart.
const MOMENT_FRAMES: usize = 10;

/// The files to write, and the moments to draw in them.
pub struct Pictures {
    picture: Option<PathBuf>,
    animation: Option<PathBuf>,
    /// The frame in which the most taxels read a force.
    fullest: Option<Snapshot>,
    moments: Vec<Snapshot>,
    frames: usize,
}

impl Pictures {
    /// Pictures without moments yet.
    ///
    /// # Errors
    /// If a file is not SVG, is there already and may not be overwritten, or cannot be written.
    pub fn new(
        picture: Option<PathBuf>,
        animation: Option<PathBuf>,
        overwrite: Overwrite,
        inputs: &[PathBuf],
    ) -> Result<Self, Failure> {
        let files = [("--picture", "a picture", &picture), ("--animation", "an animation", &animation)];
        for (option, what, path) in files {
            path.as_deref().map_or(Ok(()), |path| require_svg(option, what, path))?;
        }
        for path in picture.iter().chain(&animation) {
            overwrite.file(path, inputs)?;
        }
        Ok(Pictures { picture, animation, fullest: None, moments: Vec::new(), frames: 0 })
    }

    /// Keeps what the pictures need of a frame.
    pub fn observe(&mut self, simulation: &Simulation, frame: &Frame) {
        let fullest = self.fullest.as_ref().map(|snapshot| snapshot.frame.taxels.len());
        if self.picture.is_some() && fullest.is_none_or(|most| frame.taxels.len() > most) {
            self.fullest = Some(Snapshot::take(simulation, frame));
        }
        if self.animation.is_some() && self.frames.is_multiple_of(MOMENT_FRAMES) {
            self.moments.push(Snapshot::take(simulation, frame));
        }
        self.frames += 1;
    }

    /// Writes the files.
    pub fn write(&self, scene: &SceneFile, recording: &Recording) -> Result<(), Failure> {
        let categories = input::object_categories(recording);
        let (layout, workspace) = (&recording.layout, &scene.workspace);
        let name = format!("{}, seed {}, reach {}", scene.summary, recording.seed, recording.reach_index);
        if let (Some(path), Some(snapshot)) = (&self.picture, &self.fullest) {
            let caption = format!("{name}: {:.2} s after the start", snapshot.frame.time_s);
            let svg = picture::draw(snapshot, layout, &categories, workspace, &caption);
            output::write_file(path, svg.as_bytes())?;
        }
        if let Some(path) = &self.animation {
            let seconds = recording.frames.len() as f64 / recording.rate_hz;
            let caption = format!("{name}: {seconds:.0} s in a loop");
            if let Some(svg) = picture::animate(&self.moments, layout, &categories, workspace, &caption) {
                output::write_file(path, svg.as_bytes())?;
            }
        }
        Ok(())
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
