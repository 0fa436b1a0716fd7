//! One concrete draw of a scene from a seed: what is there, and where the arm is to go.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use rand_chacha::ChaCha8Rng;
use rapier3d::prelude::{Cuboid, Pose};
use underbrush_recording::{Category, InputError, ObjectRecord};

use crate::arm::ArmAtStart;
use crate::geometry::{Capsule, LaidFootprint, segment_distance};
use crate::object::{Footing, Footprint, Object, StandsOn};
use crate::scene::quantity::Quantity;
use crate::scene::{Placement, Scene};
use crate::seed::stream;

/// One drawn clutter with its goals.
#[derive(Debug)]
pub struct Clutter {
    /// The objects in the order in which they were placed.
    pub objects: Vec<Standing>,
    /// Goals for the tip, m, world frame.
    pub goals: Vec<DVec3>,
}

/// One object in its place.
#[derive(Debug)]
pub struct Standing {
    /// The object.
    pub object: Box<dyn Object>,
    /// Its foot, m, world frame.
    pub foot_world: DVec3,
    /// Its turn about the vertical, rad.
    pub yaw_rad: f64,
}

impl Standing {
    /// The object as ground truth in a recording.
    pub fn record(&self) -> ObjectRecord {
        let mut parameters: BTreeMap<String, f64> = self.object.parameters();
        parameters.insert("yaw_rad".into(), self.yaw_rad);
        ObjectRecord {
            kind: self.object.kind().into(),
            category: self.object.category(),
            position_world: self.foot_world,
            parameters,
        }
    }

    /// The object at rest as an upright box, and its pose in the world frame.
    pub fn outline(&self) -> (Cuboid, Pose) {
        let [x, y] = self.object.half_sizes_m();
        let half_height = self.object.height_m() / 2.0;
        let center = self.foot_world + DVec3::Z * half_height;
        (
            Cuboid::new(DVec3::new(x, y, half_height)),
            Pose::new(center, DVec3::Z * self.yaw_rad),
        )
    }

    /// The upright capsule around the object at rest.
    pub fn hull(&self) -> Capsule {
        let radius_m = match self.object.footprint() {
            Footprint::Disc(radius) => radius,
            Footprint::Rectangle(x, y) => x.hypot(y),
        };
        Capsule {
            start: self.foot_world,
            end: self.foot_world + DVec3::Z * self.object.height_m(),
            radius_m,
        }
    }

    fn laid(&self) -> LaidFootprint {
        LaidFootprint {
            footprint: self.object.footprint(),
            center: self.foot_world.truncate(),
            yaw_rad: self.yaw_rad,
        }
    }
}

/// Room kept between the arm's start posture and any object, m.
const START_CLEARANCE_M: f64 = 0.02;
/// Room kept between a leaf's foot and the edge of its block, m.
const BLOCK_MARGIN_M: f64 = 0.01;
/// Places tried for one object before all start again.
const PLACES: usize = 1000;
/// Starts before the scene is refused.
const ATTEMPTS: usize = 20;
/// Goals tried before the scene is refused.
const GOAL_TRIES: usize = 5000;
/// A goal is clear of trunks and rolls by this much, m: the flipper's half thickness and a hand's breadth.
const GOAL_CLEARANCE_M: f64 = 0.06;
/// A plant this near to the middle line of the moving arm is taken to be touched, m: the forearm's radius.
const TOUCH_DISTANCE_M: f64 = 0.046;
/// Distances behind the tip at which the forearm's skin begins, has its middle and ends, m (Cody: 0.29 to 0.45).
const FOREARM_BEHIND_TIP_M: [f64; 3] = [0.29, 0.37, 0.45];

impl Clutter {
    /// Draws the clutter of one reach.
    ///
    /// # Errors
    /// When the scene is impossible: a group has no room, leaves have no foam to stand in, or no goal leads through
    /// the clutter within the arm's reach.
    pub fn draw(scene: &Scene, arm: &ArmAtStart, seed: u64, reach_index: u64) -> Result<Clutter, InputError> {
        let mut for_objects = stream(seed, &scene.name, reach_index, "clutter");
        let mut for_goals = stream(seed, &scene.name, reach_index, "goals");
        let mut attempt = || {
            let objects = place_all(scene, arm, &mut for_objects)?;
            let goals = draw_goals(scene, arm, &objects, &mut for_goals)?;
            Ok(Clutter { objects, goals })
        };
        // Objects placed one by one can shut each other out where together they would fit, and a few that all stand
        // aside leave no way through them: then all start again.
        let mut drawn = attempt();
        for _ in 1..ATTEMPTS {
            if drawn.is_ok() {
                break;
            }
            drawn = attempt();
        }
        drawn
    }
}

/// Places every object of a scene.
fn place_all(scene: &Scene, arm: &ArmAtStart, random: &mut ChaCha8Rng) -> Result<Vec<Standing>, InputError> {
    let mut objects: Vec<Standing> = Vec::new();
    for (kind, number, group) in scene.file.objects.groups() {
        let field = format!("objects.{kind}[{number}]");
        for placed in 0..group.count() {
            let mut rejected = Rejections::default();
            let mut found = None;
            for _ in 0..PLACES {
                let Some((center, yaw_rad, footing)) =
                    propose(scene, group.place(), group.stands_on(), &objects, random)
                else {
                    rejected.no_foam += 1;
                    continue;
                };
                let object = group
                    .draw(random, &footing)
                    .map_err(|error| scene.fault(&field, error, "a range with a fair share of physical values"))?;
                let standing = Standing {
                    object,
                    foot_world: center.extend(footing.height_m),
                    yaw_rad,
                };
                if rejected.allows(&standing, &objects, arm) {
                    found = Some(standing);
                    break;
                }
            }
            objects.push(found.ok_or_else(|| {
                let allowed = format!("no more than there is room for; placed {placed}; {rejected}");
                scene.fault(&format!("{field}.count"), group.count(), allowed)
            })?);
        }
    }
    Ok(objects)
}

/// Why proposed places were refused, for the error text.
#[derive(Debug, Default)]
struct Rejections {
    no_foam: usize,
    overlap: usize,
    arm: usize,
}

impl Rejections {
    fn allows(&mut self, standing: &Standing, objects: &[Standing], arm: &ArmAtStart) -> bool {
        let laid = standing.laid();
        let blocked = objects
            .iter()
            .any(|other| !may_share_ground(standing, other) && laid.overlaps(&other.laid()));
        if blocked {
            self.overlap += 1;
            return false;
        }
        let hull = standing.hull();
        if arm.links.iter().any(|link| link.distance(&hull) < START_CLEARANCE_M) {
            self.arm += 1;
            return false;
        }
        true
    }
}

impl std::fmt::Display for Rejections {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "of {PLACES} places tried for the next one, {} overlapped another object, {} were too near the arm's start \
             and {} had no foam to stand in",
            self.overlap, self.arm, self.no_foam
        )
    }
}

/// Leaves stand in blocks, and trunks go through them to the table.
fn may_share_ground(a: &Standing, b: &Standing) -> bool {
    let pair = [a.object.category(), b.object.category()];
    pair.contains(&Category::Block) && (pair.contains(&Category::Leaf) || pair.contains(&Category::Trunk))
}

/// A place, a turn and what is underfoot; `None` where a leaf finds no foam.
fn propose(
    scene: &Scene,
    place: Option<&Placement>,
    stands_on: StandsOn,
    objects: &[Standing],
    random: &mut ChaCha8Rng,
) -> Option<(DVec2, f64, Footing)> {
    let workspace = &scene.file.workspace;
    let anywhere = (-f64::INFINITY, f64::INFINITY);
    let mut draw = |given: Option<&Quantity>, [low, high]: [f64; 2]| {
        let quantity = given.cloned().unwrap_or_else(|| Quantity::uniform(low, high));
        quantity.draw(random, anywhere).unwrap_or(low)
    };
    let yaw_rad = draw(place.and_then(|place| place.yaw_deg.as_ref()), [-180.0, 180.0]).to_radians();
    let x = draw(place.and_then(|place| place.x_m.as_ref()), workspace.x_m);
    let y = draw(place.and_then(|place| place.y_m.as_ref()), workspace.y_m);
    let center = DVec2::new(x, y);
    match stands_on {
        StandsOn::Table => {
            let footing = Footing {
                height_m: workspace.table_height_m,
                foam_modulus_pa: None,
            };
            Some((center, yaw_rad, footing))
        }
        StandsOn::Foam => objects.iter().find_map(|block| {
            let (modulus, height) = block.object.foam_top()?;
            let Footprint::Rectangle(half_x, half_y) = block.object.footprint() else {
                return None;
            };
            let local = DVec2::from_angle(-block.yaw_rad)
                .rotate(center - block.foot_world.truncate())
                .abs();
            let inside = local.x < half_x - BLOCK_MARGIN_M && local.y < half_y - BLOCK_MARGIN_M;
            let footing = Footing {
                height_m: block.foot_world.z + height,
                foam_modulus_pa: Some(modulus),
            };
            inside.then_some((center, yaw_rad, footing))
        }),
    }
}

/// Draws the goals one after the other so that the arm, on its way from the last one, passes through a plant.
fn draw_goals(
    scene: &Scene,
    arm: &ArmAtStart,
    objects: &[Standing],
    random: &mut ChaCha8Rng,
) -> Result<Vec<DVec3>, InputError> {
    let settings = &scene.file.goals;
    let plants: Vec<Capsule> = objects
        .iter()
        .filter(|object| object.object.category() != Category::Block)
        .map(Standing::hull)
        .collect();
    let rigid: Vec<Capsule> = objects
        .iter()
        .filter(|object| matches!(object.object.category(), Category::Trunk | Category::Outlier))
        .map(Standing::hull)
        .collect();
    let anywhere = (-5.0, 5.0);
    let mut from = arm.tip_world;
    let mut goals = Vec::new();
    for number in 0..settings.count {
        let mut too_far = 0;
        let goal = (0..GOAL_TRIES).find_map(|_| {
            let draw = |quantity: &Quantity, random: &mut ChaCha8Rng| quantity.draw(random, anywhere).ok();
            let goal = DVec3::new(
                draw(&settings.x_m, random)?,
                draw(&settings.y_m, random)?,
                draw(&settings.z_m, random)?,
            );
            if goal.distance(arm.shoulder_world) > 0.97 * arm.length_m {
                too_far += 1;
                return None;
            }
            let tip = Capsule {
                start: goal,
                end: goal,
                radius_m: GOAL_CLEARANCE_M,
            };
            let clear = rigid.iter().all(|object| object.distance(&tip) > 0.0);
            let wanted = plants.is_empty() || passes_through(&plants, from, goal, arm.shoulder_world);
            (clear && wanted).then_some(goal)
        });
        let goal = goal.ok_or_else(|| {
            let found = format!(
                "no goal number {} that leads through the clutter ({too_far} of {GOAL_TRIES} were out of the arm's reach)",
                number + 1
            );
            scene.fault("goals", found, "ranges of goals among the objects and within the arm's reach")
        })?;
        goals.push(goal);
        from = goal;
    }
    Ok(goals)
}

/// Whether the forearm, taken to point from the shoulder's side to the tip, comes upon a plant on the way.
///
/// The forearm and not the hand: its skin alone is classified, so an operator picks goals that bring it among plants.
fn passes_through(plants: &[Capsule], from: DVec3, goal: DVec3, shoulder: DVec3) -> bool {
    let behind = |tip: DVec3, distance: f64| tip + (shoulder - tip).normalize_or_zero() * distance;
    let sweeps = FOREARM_BEHIND_TIP_M.map(|distance| (behind(from, distance), behind(goal, distance)));
    let [nearest, .., farthest] = FOREARM_BEHIND_TIP_M;
    let at_goal = (behind(goal, nearest), behind(goal, farthest));
    plants.iter().any(|plant| {
        sweeps
            .iter()
            .chain([&at_goal])
            .any(|(a, b)| segment_distance(*a, *b, plant.start, plant.end) - plant.radius_m < TOUCH_DISTANCE_M)
    })
}
