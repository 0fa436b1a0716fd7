//! One concrete draw of a scene from a seed: the objects in their places, and the goals.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};
use parry3d::shape::Cuboid;
use underbrush_recording::{Category, InputError, ObjectRecord, Pose, math};

use crate::arm::ArmAtStart;
use crate::geometry::{Capsule, Footprint, LaidFootprint};
use crate::materials::Materials;
use crate::object::{DrawnQuantities, Object};
use crate::scene::Scene;
use crate::seed::stream;

mod arranged;
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
        let mut parameters: BTreeMap<String, f64> = self.object.parameters();
        parameters.extend(materials.values().map(|(name, value)| (name.to_owned(), value)));
        parameters.insert("yaw_rad".into(), self.yaw_rad);
        ObjectRecord {
            kind: self.object.kind().into(),
            category: self.category,
            position_world: self.foot_world,
            parameters,
        }
    }

    /// The object at rest as an upright box, and its pose in the world frame.
    pub fn outline(&self) -> (Cuboid, Pose) {
        let [x, y] = self.object.half_sizes_m();
        let half_height = self.object.height_m() / 2.0;
        let center = self.foot_world + DVec3::Z * half_height;
        let pose = Pose::new(center, DQuat::from_scaled_axis(DVec3::Z * self.yaw_rad));
        (Cuboid::new(DVec3::new(x, y, half_height)), pose)
    }

    /// An upright capsule that contains the whole object at rest.
    pub fn bounding_capsule(&self) -> Capsule {
        let radius_m = match self.object.footprint() {
            Footprint::Disc(radius) => radius,
            Footprint::Rectangle(x, y) => math::hypot(x, y),
        };
        Capsule { start: self.foot_world, end: self.foot_world + DVec3::Z * self.object.height_m(), radius_m }
    }

    fn laid(&self) -> LaidFootprint {
        LaidFootprint { footprint: self.object.footprint(), center: self.foot_world.truncate(), yaw_rad: self.yaw_rad }
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
        let materials = scene.file.materials.draw(&mut stream("materials")).map_err(|error| {
            let field = format!("materials.{}", error.name);
            scene.fault(&field, error, "a range most of whose values are physically possible")
        })?;
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
}
