//! One draw of a scene as the text of a scene file, which a person can edit.

use std::path::Path;

use toml::{Table, Value};

use super::{Clutter, PlacedObject};
use crate::scene::Scene;

impl Clutter {
    /// The text of a scene in which every object stands alone in its group, with the place and the values that were drawn
    /// for it, and the goals are listed. All else is that of `scene`, whose draw this clutter is, and so is the stream of
    /// random numbers: with the same seed and index of the reach the skin's noise is the same, too.
    ///
    /// `arm` is the path of the arm's file as the new file has to name it. It is not used for an arm that ships.
    ///
    /// ```
    /// use underbrush_sim::reach::ReachPlan;
    /// use underbrush_sim::scene::Scene;
    ///
    /// let plan = ReachPlan::new(Scene::open("trunk")?, None, 7)?;
    /// let drawn = plan.draw(0)?;
    /// let arranged = Scene::parse("arranged.toml", drawn.arranged(&plan.scene, "".as_ref()))?;
    /// // Whatever the seed, the trunks stand where they stood.
    /// let again = ReachPlan::new(arranged, None, 8)?.draw(3)?;
    /// assert_eq!(again.objects[0].foot_world, drawn.objects[0].foot_world);
    /// assert_eq!(again.goals, drawn.goals);
    /// # Ok::<(), underbrush_recording::InputError>(())
    /// ```
    pub fn arranged(&self, scene: &Scene, arm: &Path) -> String {
        let mut table: Table = toml::from_str(&scene.text).unwrap_or_default();
        table.insert("stream".into(), scene.stream.clone().into());
        if scene.file.arm != "cody" {
            table.insert("arm".into(), arm.to_string_lossy().into_owned().into());
        }
        let mut objects = Table::new();
        for placed in &self.objects {
            let groups = objects.entry(placed.object.kind()).or_insert_with(|| Value::Array(Vec::new()));
            if let Value::Array(groups) = groups {
                groups.push(placed.group().into());
            }
        }
        table.insert("objects".into(), objects.into());
        let materials: Table = self.materials.values().map(|(name, value)| (name.to_owned(), value.into())).collect();
        table.remove("materials");
        if !materials.is_empty() {
            table.insert("materials".into(), materials.into());
        }
        let mut goals = match table.remove("goals") {
            Some(Value::Table(goals)) => goals,
            _ => Table::new(),
        };
        goals.retain(|key, _| !["count", "x_m", "y_m", "z_m"].contains(&key));
        let positions = self.goals.iter().map(|goal| goal.to_array().to_vec());
        goals.insert("positions_m".into(), positions.collect::<Vec<_>>().into());
        table.insert("goals".into(), goals.into());
        // A table serializes: it was read from text, and its new keys and values are plain.
        toml::to_string(&table).unwrap_or_default()
    }
}

impl PlacedObject {
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
}

/// The angle in degrees that becomes this one when it is turned into radians.
fn degrees_of(angle_rad: f64) -> f64 {
    let near = angle_rad.to_degrees();
    let candidates = [near, near.next_up(), near.next_down(), near.next_up().next_up(), near.next_down().next_down()];
    candidates.into_iter().find(|degrees| degrees.to_radians() == angle_rad).unwrap_or(near)
}
