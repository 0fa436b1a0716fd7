//! Pictures and films of reaches and arms, without a browser: `--still`, `--picture` and `--video`.

use std::path::{Path, PathBuf};

use clap::Args;
use glam::DVec3;
use serde_json::json;
use underbrush_recording::Recording;
use underbrush_render::{Camera, Film, RenderError, Size, Stage, fullest};
use underbrush_replay::Source;
use underbrush_report::replayed;
use underbrush_sim::arm::Arm;
use underbrush_sim::scene::{Scene, SceneCamera};

use crate::options::{number, pair, whole};
use crate::{Failure, Overwrite, output, progress};

/// Size of a picture, and of the pictures of a film, if nothing else is said.
const SIZE: Size = Size { width: 1280, height: 720 };
const FILM_SIZE: Size = Size { width: 640, height: 360 };

/// The options of pictures and films of `underbrush replay`.
#[derive(Args)]
pub struct PictureArguments {
    /// Draw one moment of a reach to this file, without a browser
    #[arg(long, value_name = "FILE.png", groups = ["file", "picture"], conflicts_with_all = ["model", "patch", "port", "no_open"])]
    still: Option<PathBuf>,
    /// Write a film of a reach to this file, without a browser. It plays in a loop
    #[arg(long, value_name = "FILE.gif", groups = ["file", "picture"], conflicts_with_all = ["model", "patch", "port", "no_open"])]
    video: Option<PathBuf>,
    /// With --still: the moment, s after the start [default: when the most taxels read a force]
    #[arg(
        long,
        value_name = "S",
        requires = "still",
        conflicts_with_all = ["out", "video"],
        value_parser = number(|_: &f64| true, "must be a time in s")
    )]
    time: Option<f64>,
    /// Take the picture with this camera of the scene file. Recordings do not know their scene; data sets do
    #[arg(long, value_name = "NAME", conflicts_with_all = ["out", "eye", "target"], requires = "picture")]
    camera: Option<String>,
    /// Width and height, 64 to 1280 pixels each [default: 1280x720, of films 640x360, of a camera its own]
    #[arg(long, value_name = "WxH", value_parser = size, conflicts_with = "out", requires = "picture")]
    size: Option<Size>,
    /// Where the picture is taken from, m, world frame: x, y, z [default: right of the arm, as near as everything fits]
    #[arg(long, value_name = "X,Y,Z", value_parser = place, allow_hyphen_values = true, conflicts_with = "out", requires = "picture")]
    eye: Option<DVec3>,
    /// What is in the middle of the picture, m, world frame: x, y, z [default: the middle of everything]
    #[arg(long, value_name = "X,Y,Z", value_parser = place, allow_hyphen_values = true, conflicts_with = "out", requires = "picture")]
    target: Option<DVec3>,
    /// With --video: pictures per second, 1 to 50, each shown for whole hundredths of a second, so that 30 becomes 33
    #[arg(long, value_name = "N", requires = "video", conflicts_with_all = ["out", "still"], default_value_t = Film::FPS, value_parser = whole(1..=50_u16))]
    fps: u16,
    /// With --video: how many times as fast as in reality it plays, 0.1 to 100
    #[arg(long, value_name = "X", requires = "video", conflicts_with_all = ["out", "still"], default_value_t = 1.0, value_parser = number(|speed: &f64| (0.1..=100.0).contains(speed), "give a number from 0.1 to 100"))]
    speed: f64,
}

/// Reads a size such as 640x360.
fn size(text: &str) -> Result<Size, String> {
    let (width, height) = pair(text, 'x').ok_or("give width and height in pixels, such as 640x360")?;
    Size { width, height }.check().map_err(|error| error.to_string())
}

fn place(text: &str) -> Result<DVec3, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(str::parse).collect();
    let place = numbers.ok().and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    place.map(DVec3::from).ok_or_else(|| "give three numbers in m, such as 0.5,-1,0.3".to_owned())
}

impl PictureArguments {
    /// Draws a picture or a film of one of the reaches, if one is asked for, and returns whether it is. The file must have
    /// been checked by [`PictureArguments::check`].
    pub fn run(&self, source: &Source, chosen: &[usize], json: bool) -> Result<bool, Failure> {
        let Some(path) = self.still.as_ref().or(self.video.as_ref()) else { return Ok(false) };
        let &[number] = chosen else {
            let reaches = source.reaches.len();
            let text = format!("a picture shows one reach; choose one of {reaches} with --reaches N, from 0");
            return Err(Failure::usage(text));
        };
        let recording = source.recording(number)?;
        let camera = self.scene_camera(&recording.scene, source.scene_text(number))?;
        let stage = replayed::stage(&recording, source.stated_limit_n(number))?;
        // A camera of the scene shows what a camera sees.
        let stage = if camera.is_none() { stage.with_arrows() } else { stage };
        let (size, camera) = self.view(&stage, camera.as_ref());
        let (bytes, frames) = if self.still.is_some() {
            let number = self.moment(&recording)?;
            let scene = stage.moment(number as u32, &recording.frames[number]);
            (scene.png(&camera(number as u32)?, size)?, 1)
        } else {
            let film = Film { size, delay: (100.0 / f64::from(self.fps)).round() as u16, speed: self.speed };
            let pictures = film.frames(&recording).len();
            let bar = progress::bar(pictures as u64, "pictures");
            (film.draw(&recording, &stage, camera, move |drawn| bar.inc(drawn as u64))?, pictures)
        };
        output::write_file(path, &bytes)?;
        let (bytes, path) = (bytes.len(), path.display().to_string());
        output::result(json, &json!({ "file": path, "pictures": frames, "bytes": bytes }), || {
            let megabytes = bytes as f64 / 1e6;
            format!("{path}: {} in {megabytes:.2} MB", output::counted(frames, "picture", "pictures"))
        })?;
        Ok(true)
    }

    /// Demands that the file can be written and has the right ending.
    pub fn check(&self, overwrite: Overwrite, inputs: &[PathBuf]) -> Result<(), Failure> {
        if let Some(still) = &self.still {
            return overwrite.ending(still, &["png"], "choose such a name", inputs);
        }
        let Some(video) = &self.video else { return Ok(()) };
        let remedy = "choose such a name; `python -m underbrush.video film` writes .mp4 and .webp";
        overwrite.ending(video, &["gif"], remedy, inputs)
    }

    /// The camera of the scene file that is asked for.
    fn scene_camera(&self, scene: &str, text: Option<&str>) -> Result<Option<SceneCamera>, Failure> {
        let Some(name) = &self.camera else { return Ok(None) };
        let refused = |allowed: &str| Failure::usage(format!("--camera {name}: allowed: {allowed}"));
        let text = text.ok_or_else(|| refused("only with a data set, because a recording alone stores no cameras; give a data set, or use --eye and --target"))?;
        let cameras = Scene::parse(scene, text.to_owned())?.file.cameras;
        let names: Vec<&str> = cameras.iter().map(|camera| camera.name.as_str()).collect();
        let named = cameras.iter().find(|camera| camera.name == *name).cloned();
        let none = || match names.join(", ") {
            names if names.is_empty() => refused(&format!("no name, as the scene {scene} has no cameras; use --eye")),
            names => refused(&format!("the cameras of the scene {scene} ({names}); choose one of them")),
        };
        named.ok_or_else(none).map(Some)
    }

    /// The size of the pictures, and where they are taken from in each frame.
    fn view<'a>(
        &'a self,
        stage: &'a Stage,
        camera: Option<&'a SceneCamera>,
    ) -> (Size, impl Fn(u32) -> Result<Camera, RenderError> + Sync + 'a) {
        let own = camera.map(|camera| Size { width: camera.size_px[0], height: camera.size_px[1] });
        let default = if self.still.is_some() { SIZE } else { FILM_SIZE };
        let size = self.size.or(own).unwrap_or(default);
        let standard = stage.camera(size.aspect());
        let eye_world = self.eye.unwrap_or(standard.eye_world);
        let target_world = self.target.unwrap_or(standard.target_world);
        // Where the view is straight down or up, what is before the arm is at the top.
        let is_vertical = (target_world - eye_world).cross(standard.up_world).length() < 1e-6;
        let up_world = if is_vertical { DVec3::X } else { standard.up_world };
        let free = Camera { eye_world, target_world, up_world, ..standard };
        (size, move |number| camera.map_or(Ok(free), |camera| stage.scene_camera(camera, number)))
    }

    /// The number of the frame that a picture shows.
    fn moment(&self, recording: &Recording) -> Result<usize, Failure> {
        let Some(time_s) = self.time else { return Ok(fullest(recording)) };
        let last_s = recording.frames.last().map_or(0.0, |frame| frame.time_s);
        if (0.0..=last_s).contains(&time_s) {
            return Ok(recording.frames.partition_point(|frame| frame.time_s < time_s - 1e-9));
        }
        let allowed = format!("0 to {last_s:.2}, the length of the reach in s");
        Err(Failure::usage(format!("--time {time_s}: allowed: {allowed}; choose a moment of it")))
    }
}

/// Draws the moment of a reach in which the most taxels read a force. The controller allows a taxel `limit_n`, N.
pub fn write_fullest(recording: &Recording, limit_n: Option<f64>, path: &Path) -> Result<(), Failure> {
    Ok(output::write_file(path, &replayed::png(recording, fullest(recording), SIZE, limit_n)?)?)
}

/// Draws an arm in its start posture.
pub fn write_arm(arm: &Arm, path: &Path) -> Result<(), Failure> {
    let (scene, camera) = Stage::arm(arm, SIZE.aspect())?;
    Ok(output::write_file(path, &scene.png(&camera, SIZE)?)?)
}
