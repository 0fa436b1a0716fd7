//! One concrete draw of a scene from a seed: the objects in their places, and the goals. It can be written as a scene file, which
//! a person can edit.

use std::collections::BTreeMap;
use std::path::Path;

use glam::{DQuat, DVec3};
use parry3d::shape::Cuboid;
use toml::{Table, Value};
use underbrush_recording::{Category, InputError, ObjectRecord, Pose, math};

use crate::arm::ArmAtStart;
use crate::arm::new::relative;
use crate::geometry::{Capsule, Footprint, LaidFootprint};
use crate::materials::Materials;
use crate::object::{DrawnQuantities, Object};
use crate::scene::Scene;
use crate::seed::stream;

mod goals;
mod place;
#[cfg(test)]
mod tests;

/// The drawn objects of one reach and its goals.
///
/// ```
/// use underbrush_sim::reach::ReachPlan;
/// use underbrush_sim::scene::Scene;
///
/// let text = "summary = \"Trunks\"\n[[objects.trunk]]\ncount = 3\n";
/// let plan = ReachPlan::new(Scene::parse("trunks.toml", text.into())?, None, 5)?;
/// let clutter = plan.draw(0)?;
/// assert!(clutter.objects.iter().all(|placed| placed.object.kind() == "trunk"));
/// assert_eq!((clutter.objects.len(), clutter.goals.len()), (3, 4));
/// # Ok::<(), underbrush_recording::InputError>(())
/// ```
#[derive(Debug, Default)]
pub struct Clutter {
    /// The objects in the order in which they were placed.
    pub objects: Vec<PlacedObject>,
    /// Goals for the end effector, m, world frame.
    pub goals: Vec<DVec3>,
    /// Constants that replace those of arm and objects.
    pub materials: Materials,
    /// Pairs of kinds that pass through each other; see [`crate::scene::SceneFile::passing`].
    pub passing: Vec<[String; 2]>,
}

/// An object in its place.
#[derive(Debug)]
pub struct PlacedObject {
    /// The object.
    pub object: Box<dyn Object>,
    /// Its ground-truth category.
    pub category: Category,
    /// Its foot, m, world frame.
    pub foot_world: DVec3,
    /// Its rotation about the vertical, rad.
    pub yaw_rad: f64,
    /// The object whose foam it stands in, if it does not stand on the table.
    pub stands_on: Option<usize>,
    /// What was drawn for it, in the order of its kind's declarations.
    pub drawn: DrawnQuantities,
}

impl PlacedObject {
    /// The object as ground truth in a recording, with the constants of its contacts that the scene sets or draws.
    fn record(&self, materials: &Materials) -> ObjectRecord {
        let mut parameters = self.object.parameters();
        parameters.extend(materials.values());
        parameters.insert("yaw_rad", self.yaw_rad);
        ObjectRecord {
            kind: self.object.kind().into(),
            category: self.category,
            position_world: self.foot_world,
            parameters: parameters.into_iter().map(|(name, value)| (name.to_owned(), value)).collect(),
        }
    }

    /// The object at rest as an upright box, and its pose in the world frame.
    pub fn outline(&self) -> (Cuboid, Pose) {
        let [x, y] = self.object.half_sizes_m();
        let half_height = self.object.size().1 / 2.0;
        let center = self.foot_world + DVec3::Z * half_height;
        let pose = Pose::new(center, DQuat::from_scaled_axis(DVec3::Z * self.yaw_rad));
        (Cuboid::new(DVec3::new(x, y, half_height)), pose)
    }

    /// An upright capsule that contains the whole object at rest.
    pub fn bounding_capsule(&self) -> Capsule {
        let (footprint, height_m) = self.object.size();
        let radius_m = match footprint {
            Footprint::Disc(radius) => radius,
            Footprint::Rectangle(x, y) => math::hypot(x, y),
        };
        Capsule { start: self.foot_world, end: self.foot_world + DVec3::Z * height_m, radius_m }
    }

    /// The object as a group of a scene file.
    fn group(&self) -> Table {
        let place = [("x_m", self.foot_world.x), ("y_m", self.foot_world.y), ("yaw_deg", degrees_of(self.yaw_rad))];
        let table = |values: &[(&str, f64)]| -> Table {
            values.iter().map(|(key, value)| ((*key).to_owned(), Value::Float(*value))).collect()
        };
        let mut group = table(&self.drawn);
        group.insert("count".into(), 1.into());
        group.insert("category".into(), self.category.name().into());
        group.insert("place".into(), table(&place).into());
        group
    }

    fn laid(&self) -> LaidFootprint {
        LaidFootprint { footprint: self.object.size().0, center: self.foot_world.truncate(), yaw_rad: self.yaw_rad }
    }
}

/// Number of attempts before the scene is refused.
const ATTEMPTS: usize = 20;

impl Clutter {
    /// The objects as ground truth in a recording.
    pub fn records(&self) -> Vec<ObjectRecord> {
        self.objects.iter().map(|placed| placed.record(&self.materials)).collect()
    }

    /// Draws the clutter of one reach.
    ///
    /// # Errors
    /// When the scene is impossible: a group has no room, leaves have no foam to stand in, or there is no goal that leads
    /// through the clutter and at which the arm has room.
    pub fn draw(scene: &Scene, arm: &ArmAtStart, seed: u64, reach_index: u64) -> Result<Clutter, InputError> {
        let stream = |purpose: &str| stream(seed, &scene.stream, reach_index, purpose);
        let (mut for_objects, mut for_goals) = (stream("clutter"), stream("goals"));
        let mut for_postures = stream("postures");
        let materials = scene.file.materials.draw(&mut stream("materials"));
        let materials = materials.map_err(|error| scene.draw_fault("materials", error))?;
        let mut attempt = || {
            let objects = place::place_all(scene, arm, &mut for_objects)?;
            let goals = goals::draw_goals(scene, arm, &objects, &mut for_goals, &mut for_postures)?;
            Ok(Clutter { objects, goals, materials, passing: scene.file.passing.clone() })
        };
        // Objects that are placed one by one can block each other although all would fit, and a few objects that all
        // stand to one side leave no goals beyond them. Then everything is drawn again.
        (1..ATTEMPTS).find_map(|_| attempt().ok()).map_or_else(attempt, Ok)
    }

    /// The fixed obstacles as upright capsules, m, world frame.
    pub fn obstacles(&self) -> Vec<Capsule> {
        let obstacles = self.objects.iter().filter(|placed| placed.object.is_obstacle());
        let upright = |placed: &PlacedObject| {
            let around = placed.bounding_capsule();
            // The bounding capsule ends in half a ball above the object.
            Capsule { end: around.end - DVec3::Z * around.radius_m, ..around }
        };
        obstacles.map(upright).collect()
    }

    /// The text of a scene file at `place`, in which every object stands alone in its group, with the place and the values that
    /// were drawn for it, and the goals are listed. All else is that of `scene`, whose draw this clutter is, and so is the stream of
    /// random numbers: with the same seed and index of the reach the skin's noise is the same, too.
    ///
    /// If `scene` names its arm by a relative path, the text names it by the path from the folder of `place`, which must be there.
    ///
    /// ```
    /// use std::path::Path;
    ///
    /// use underbrush_sim::reach::ReachPlan;
    /// use underbrush_sim::scene::Scene;
    ///
    /// let plan = ReachPlan::new(Scene::open("trunk")?, None, 7)?;
    /// let drawn = plan.draw(0)?;
    /// let place = Path::new("arranged.toml");
    /// let arranged = Scene::parse(place, drawn.arranged(&plan.scene, place))?;
    /// // Whatever the seed, the trunks stand where they stood.
    /// let again = ReachPlan::new(arranged, None, 8)?.draw(3)?;
    /// assert_eq!(again.objects[0].foot_world, drawn.objects[0].foot_world);
    /// assert_eq!(again.goals, drawn.goals);
    /// # Ok::<(), underbrush_recording::InputError>(())
    /// ```
    pub fn arranged(&self, scene: &Scene, place: &Path) -> String {
        let mut table: Table = toml::from_str(&scene.text).unwrap_or_default();
        table.insert("stream".into(), scene.stream.clone().into());
        if let Some(arm) = scene.arm_path().filter(|_| Path::new(&scene.file.arm).is_relative()) {
            table.insert("arm".into(), relative(place, &arm).into());
        }
        let mut objects: BTreeMap<&str, Vec<Table>> = BTreeMap::new();
        for placed in &self.objects {
            objects.entry(placed.object.kind()).or_default().push(placed.group());
        }
        table.insert("objects".into(), objects.into());
        let materials: Table = self.materials.values().map(|(name, value)| (name.to_owned(), value.into())).collect();
        table.remove("materials");
        if !materials.is_empty() {
            table.insert("materials".into(), materials.into());
        }
        let goals = table.remove("goals");
        let mut goals = goals.and_then(|goals| goals.as_table().cloned()).unwrap_or_default();
        goals.retain(|key, _| !["count", "x_m", "y_m", "z_m"].contains(&key));
        let positions = self.goals.iter().map(|goal| goal.to_array().to_vec());
        goals.insert("positions_m".into(), positions.collect::<Vec<_>>().into());
        table.insert("goals".into(), goals.into());
        // A table serializes: it was read from text, and its new keys and values are plain.
        toml::to_string(&table).unwrap_or_default()
    }
}

/// The angle in degrees that becomes this one when it is turned into radians.
fn degrees_of(angle_rad: f64) -> f64 {
    let near = angle_rad.to_degrees();
    let candidates = [near, near.next_up(), near.next_down(), near.next_up().next_up(), near.next_down().next_down()];
    candidates.into_iter().find(|degrees| degrees.to_radians() == angle_rad).unwrap_or(near)
}
