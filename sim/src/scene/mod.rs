//! Scenes: the ranges from which the clutter of a reach is drawn. This module reads and checks scene files; their keys
//! are in `file.rs`. See `scenes/` for examples and `underbrush schema` for the JSON Schema.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use underbrush_recording::limits::{TEXT_BYTES, first_outside, short};
use underbrush_recording::{
    Category, FRAME_PERIOD_S, InputError, PLAIN, is_plain, line_setting, parse_toml, read_text,
};

use crate::arm::Arm;
use crate::materials::MaterialFile;
use crate::object::COLLIDING_KINDS;
use crate::range::{DrawError, Limited, PLACE_M, Placement, YAW_DEG};
use crate::sensor::OptionFault;
use content::objects_hash;

mod camera;
mod content;
mod file;
pub mod limits;
mod shipped;

pub use camera::SceneCamera;
pub use file::{Goals, Objects, PhysicsSection, ProgressRule, RobotSection, SceneFile, Workspace};
pub use shipped::{shipped, shipped_by_name};

/// One scene: the ranges from which the clutter of each reach is drawn.
///
/// ```
/// use underbrush_sim::scene::Scene;
///
/// let text = "summary = \"Two trunks\"\n[[objects.trunk]]\ncount = 2\ndiameter_m = 0.03\n";
/// let scene = Scene::parse("trunks.toml", text.into())?;
/// assert_eq!(scene.file.objects.groups().len(), 1);
/// // An error names the line.
/// let error = Scene::parse("trunks.toml", text.replace("0.03", "3.0")).unwrap_err();
/// assert!(error.to_string().contains("diameter_m"), "{error}");
/// # Ok::<(), underbrush_recording::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    /// Name: the file's name without its extension.
    pub name: String,
    /// Names the random numbers that its reaches draw: the key `stream`, or else what the file says of the objects. Scenes
    /// with the same stream, seed and index of a reach draw the same numbers.
    pub stream: String,
    /// The file.
    pub path: PathBuf,
    /// Its text, for the provenance of data sets and for the lines in error messages.
    pub text: String,
    /// Its contents, which were checked when the file was read. Changes to them are not checked, and data sets store `text`, which
    /// does not change with them. To change a scene, change its text and read it with [`Scene::parse`].
    pub file: SceneFile,
}

impl Scene {
    /// Reads and checks a scene file.
    ///
    /// # Errors
    /// When the file cannot be read, is not TOML, has unknown keys, or has a value outside its limits.
    pub fn load(path: impl AsRef<Path>) -> Result<Scene, InputError> {
        Scene::read(path.as_ref(), "check the path")
    }

    fn read(path: &Path, remedy: &str) -> Result<Scene, InputError> {
        Scene::of_text(path, read_text(path, &TEXT_BYTES, "a readable scene file", remedy)?)
    }

    /// A scene that ships, by its name, or one from a file.
    ///
    /// ```
    /// use underbrush_sim::scene::Scene;
    ///
    /// assert_eq!(Scene::open("mixed")?.name, "mixed");
    /// # Ok::<(), underbrush_recording::InputError>(())
    /// ```
    ///
    /// # Errors
    /// When no scene of this name ships and there is no such file, and as [`Scene::load`].
    pub fn open(name_or_path: impl AsRef<Path>) -> Result<Scene, InputError> {
        Scene::open_in(Path::new(""), name_or_path.as_ref())
    }

    /// As [`Scene::open`], with paths relative to a folder.
    ///
    /// # Errors
    /// As [`Scene::open`].
    pub fn open_in(folder: &Path, name_or_path: &Path) -> Result<Scene, InputError> {
        let path = &folder.join(name_or_path);
        let name = name_or_path.to_string_lossy();
        match shipped_by_name().find(|(shipped, _)| *shipped == name) {
            // A folder of that name, such as a data set of the scene, does not hide it.
            Some((shipped, text)) if !path.is_file() => {
                Scene::of_text(Path::new(&format!("{shipped}.toml")), text.to_owned())
            }
            _ if path.extension().is_some() || path.exists() => {
                Scene::read(path, "check the path, or give the name of a scene that ships, such as mixed")
            }
            _ => {
                let names: Vec<&str> = shipped_by_name().map(|(name, _)| name).collect();
                let allowed = format!("{}, or the path of a scene file", names.join(", "));
                Err(InputError::new(path, "scene", name, allowed, "choose one of them"))
            }
        }
    }

    /// Parses and checks the text of a scene file. `path` appears in error messages and gives the scene its name.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse(path: impl AsRef<Path>, text: String) -> Result<Scene, InputError> {
        Scene::of_text(path.as_ref(), text)
    }

    // Not generic, so that the reader of scenes is compiled once and not in each crate that calls it.
    fn of_text(path: &Path, text: String) -> Result<Scene, InputError> {
        let file: SceneFile = parse_toml(path, &text, "scene", "the keys that `underbrush schema` lists")?;
        let name = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
        let scene = Scene {
            name,
            stream: file.stream.clone().unwrap_or_else(|| objects_hash(&text)),
            path: path.to_path_buf(),
            text,
            file,
        };
        scene.check()?;
        Ok(scene)
    }

    /// The scene with the constants of a file of materials, drawn from their ranges in each reach or else with their values.
    ///
    /// # Errors
    /// When the scene has a section `[materials]` already.
    pub fn with_materials(&self, file: &MaterialFile, draws: bool) -> Result<Scene, InputError> {
        if line_setting(&self.text, "materials").is_some() {
            let allowed = "a scene without this section, or no file of materials and nothing to randomize";
            let fault = self.fault("materials", "a section of its own", allowed);
            return Err(InputError { remedy: "remove one of the two".into(), ..fault });
        }
        Scene::parse(&self.path, format!("{}\n{}", self.text, file.section(draws)))
    }

    /// The file of its arm; `None` for the arm that ships.
    pub fn arm_path(&self) -> Option<PathBuf> {
        (self.file.arm != "cody").then(|| self.path.parent().unwrap_or(Path::new(".")).join(&self.file.arm))
    }

    /// Its arm as the arm's files have it, without the scale factors of the scene.
    ///
    /// # Errors
    /// When the arm's files are bad.
    pub fn load_arm(&self) -> Result<Arm, InputError> {
        let Some(path) = self.arm_path() else { return Arm::cody() };
        Arm::load(path).map_err(|error| error.named_in(&self.path, line_setting(&self.text, "arm")))
    }

    /// Hash of the file's text, hexadecimal BLAKE3.
    pub fn hash(&self) -> String {
        blake3::hash(self.text.as_bytes()).to_hex().to_string()
    }

    /// The height above which the arm is free of the table and of what covers it, m, world frame.
    pub fn floor_height_m(&self) -> f64 {
        let groups = self.file.objects.groups();
        let foam = groups.iter().filter(|(kind, _, group)| *kind == "foam_block" && group.count > 0);
        let heights = foam.flat_map(|(_, _, group)| group.quantities()).filter(|own| own.name == "height_m");
        self.file.workspace.table_height_m + heights.map(|own| own.draw.largest()).fold(0.0, f64::max)
    }

    fn check(&self) -> Result<(), InputError> {
        let file = &self.file;
        if !is_plain(&file.summary) {
            return Err(self.fault("summary", format!("{:?}", file.summary), PLAIN));
        }
        if file.summary.trim().is_empty() {
            let allowed = "a sentence that says what the scene shows";
            return Err(self.fault("summary", format!("{:?}", file.summary), allowed));
        }
        if file.arm.is_empty() {
            return Err(self.fault("arm", "\"\"", "cody, or the path of an arm file"));
        }
        if !is_plain(&self.name) {
            let found = format!("{:?}", self.name);
            return Err(InputError::new(&self.path, "file name", found, PLAIN, "rename the file"));
        }
        let workspace = &file.workspace;
        for (key, [low, high]) in [("workspace.x_m", workspace.x_m), ("workspace.y_m", workspace.y_m)] {
            if !(PLACE_M.hold(low) && PLACE_M.hold(high) && low < high) {
                let allowed = format!("two numbers from {}, the smaller first", PLACE_M);
                return Err(self.fault(key, format!("[{}, {}]", short(low), short(high)), allowed));
            }
        }
        self.check_numbers()?;
        self.check_steps()?;
        self.sensor_fault(file.sensor.fault())?;
        for (name, draw) in [("x_m", file.goals.x_m), ("y_m", file.goals.y_m), ("z_m", file.goals.z_m)] {
            self.check_range("goals", Limited { name, draw, limits: PLACE_M })?;
        }
        self.check_positions()?;
        self.check_cameras()?;
        for limited in file.materials.quantities() {
            self.check_range("materials", limited)?;
        }
        if let Some(kind) = file.passing.iter().flatten().find(|kind| !COLLIDING_KINDS.contains(&kind.as_str())) {
            return Err(self.fault("passing", format!("{kind:?}"), format!("one of {}", COLLIDING_KINDS.join(", "))));
        }
        self.check_objects()
    }

    /// Checks the goals that the scene lists.
    fn check_positions(&self) -> Result<(), InputError> {
        let Some(positions) = &self.file.goals.positions_m else { return Ok(()) };
        let place = "goals.positions_m";
        if !limits::GOALS.hold(positions.len() as f64) {
            return Err(self.fault(place, positions.len(), limits::GOALS.to_string()));
        }
        let outside = positions.iter().flatten().find(|coordinate| !PLACE_M.hold(**coordinate));
        self.refuse(outside.map(|own| (place.into(), short(*own), format!("coordinates from {PLACE_M}"))))
    }

    fn check_cameras(&self) -> Result<(), InputError> {
        let cameras = &self.file.cameras;
        for (number, camera) in cameras.iter().enumerate() {
            let is_taken = cameras[..number].iter().any(|other| other.name == camera.name);
            let taken = || ("name".into(), format!("{:?}", camera.name), "a name that no other camera has".into());
            let fault = camera.fault().or_else(|| is_taken.then(taken));
            self.refuse(fault.map(|(key, found, allowed)| (format!("cameras[{number}].{key}"), found, allowed)))?;
        }
        Ok(())
    }

    /// Checks that the arm has the links that carry cameras.
    pub(crate) fn check_links_of_cameras(&self, arm: &Arm) -> Result<(), InputError> {
        let names: Vec<&str> = arm.links.iter().map(|link| link.name.as_str()).collect();
        for (number, camera) in self.file.cameras.iter().enumerate() {
            if let Some(link) = camera.link.as_ref().filter(|link| !names.contains(&link.as_str())) {
                let allowed = format!("a link of the arm that is not joined rigidly to another: {}", names.join(", "));
                return Err(self.fault(&format!("cameras[{number}].link"), format!("{link:?}"), allowed));
            }
        }
        Ok(())
    }

    /// The categories of its objects, by name.
    pub fn categories(&self) -> BTreeMap<&'static str, Category> {
        let groups = self.file.objects.groups();
        groups.iter().map(|(_, _, group)| (group.category.name(), group.category)).collect()
    }

    /// Whether something in the scene may be judged to be of this name: a category of its objects, a built-in one, or `unknown`.
    pub fn has_verdict(&self, name: &str) -> bool {
        let built_in = Category::BUILT_IN.iter().any(|category| category.name() == name);
        built_in || name == "unknown" || self.categories().contains_key(name)
    }

    /// Checks the numbers that depend on no others.
    fn check_numbers(&self) -> Result<(), InputError> {
        let SceneFile { workspace, robot, goals, physics, .. } = &self.file;
        let sections = [
            ("workspace", workspace.numbers()),
            ("robot", robot.numbers()),
            ("goals", goals.numbers()),
            ("goals", goals.patience_s.map(|own_s| ("patience_s", own_s, limits::PATIENCE_S)).into_iter().collect()),
            ("physics", physics.numbers()),
        ];
        if let Some(name) = self.file.allowed_force_n.keys().find(|name| !self.has_verdict(name)) {
            let allowed = "leaf, trunk, block, outlier, a category of the scene's objects, or unknown";
            return Err(self.fault(&format!("allowed_force_n.{name}"), name, allowed));
        }
        let forces = self.file.allowed_force_n.iter();
        let forces = forces.map(|(name, own_n)| (format!("allowed_force_n.{name}"), *own_n, limits::ALLOWED_FORCE_N));
        let of_sections = sections.into_iter().flat_map(|(section, numbers)| {
            numbers.into_iter().map(move |(key, value, limits)| (format!("{section}.{key}"), value, limits))
        });
        self.refuse(first_outside(forces.chain(of_sections)))
    }

    /// Checks that a frame is a whole number of steps.
    fn check_steps(&self) -> Result<(), InputError> {
        let step_s = self.file.physics.step_s;
        let steps = FRAME_PERIOD_S / step_s;
        let allowed = "10 ms or a whole fraction of it (0.005, 0.0025, 0.002, 0.001 ... 0.0001)";
        let is_off = (steps - steps.round()).abs() > 1e-6;
        self.refuse(is_off.then(|| ("physics.step_s".into(), short(step_s), allowed.into())))
    }

    fn check_objects(&self) -> Result<(), InputError> {
        let mut objects = 0.0;
        let mut names: BTreeMap<i8, &str> = BTreeMap::new();
        for (kind, number, group) in self.file.objects.groups() {
            let place = format!("objects.{kind}[{number}]");
            objects += f64::from(group.count);
            if !limits::OBJECTS.hold(objects) {
                let allowed = format!("{} in all groups together", limits::OBJECTS);
                return Err(self.fault(&format!("{place}.count"), group.count, allowed));
            }
            let (code, name) = (group.category.code(), group.category.name());
            if let Some(other) = names.insert(code, name).filter(|other| *other != name) {
                let allowed =
                    format!("another name, because in data sets this one has the same code, {code}, as {other}");
                return Err(self.fault(&format!("{place}.category"), name, allowed));
            }
            let Placement { x_m, y_m, yaw_deg } = group.place;
            let places =
                [("place.x_m", x_m, PLACE_M), ("place.y_m", y_m, PLACE_M), ("place.yaw_deg", yaw_deg, YAW_DEG)];
            let places = places.into_iter();
            let places = places.filter_map(|(name, draw, limits)| Some(Limited { name, draw: draw?, limits }));
            for limited in group.quantities().into_iter().chain(places) {
                self.check_range(&place, limited)?;
            }
        }
        Ok(())
    }

    /// Turns a fault of the sensor options into an error about this file.
    pub(crate) fn sensor_fault(&self, fault: Option<OptionFault>) -> Result<(), InputError> {
        self.refuse(fault.map(|(key, found, allowed)| (format!("sensor.{key}"), found, allowed)))
    }

    /// Turns what is wrong with the file into an error, if anything is: field, found, allowed.
    fn refuse(&self, fault: Option<(String, String, String)>) -> Result<(), InputError> {
        fault.map_or(Ok(()), |(field, found, allowed)| Err(self.fault(&field, found, allowed)))
    }

    fn check_range(&self, place: &str, Limited { name, draw, limits }: Limited) -> Result<(), InputError> {
        self.refuse(draw.fault(limits).map(|(found, allowed)| (format!("{place}.{name}"), found, allowed)))
    }

    /// An error about a range at this place of the file from which nothing could be drawn.
    pub(crate) fn draw_fault(&self, place: &str, error: DrawError) -> InputError {
        self.fault(&format!("{place}.{}", error.name), error, "a range most of whose values are physically possible")
    }

    /// An error about this file, at the line that sets `field`.
    pub(crate) fn fault(&self, field: &str, found: impl ToString, allowed: impl Into<String>) -> InputError {
        let remedy = "change the value in the scene file";
        let fault = InputError::new(&self.path, field, found.to_string(), allowed, remedy);
        fault.at_line(line_setting(&self.text, field))
    }
}

/// The JSON Schema of scene files, for editors.
pub fn schema() -> schemars::Schema {
    schemars::schema_for!(SceneFile)
}

#[cfg(test)]
mod tests;
