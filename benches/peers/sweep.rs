//! A fixed motion that drags the forearm through leaves on a grid: the scene of the bench `foliage` and of the
//! comparison with another engine.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use underbrush_recording::{Category, FRAME_PERIOD_S};
use underbrush_sim::arm::{Arm, ArmAtStart};
use underbrush_sim::clutter::{Clutter, PlacedObject};
use underbrush_sim::object::Footing;
use underbrush_sim::physics::PhysicsOptions;
use underbrush_sim::range::{Draw, YAW_DEG};
use underbrush_sim::scene::Scene;
use underbrush_sim::seed::stream;
use underbrush_sim::sensor::{Sensor, SensorOptions};
use underbrush_sim::simulation::{FrameReport, Setup, Simulation};

/// Equilibrium angles at the start, degrees: upper arm hanging, forearm forward at half the leaves' height, rotated
/// inward.
const START_DEG: [f64; 7] = [10.0, 12.0, -35.0, 75.0, 0.0, 0.0, 0.0];
/// The change of those angles, degrees: shoulder and upper arm carry the forearm outward. Choice: it then meets about
/// ten leaves, as in a reach of `scenes/leaf.toml`.
const SWEEP_DEG: [f64; 7] = [0.0, 15.0, 35.0, 0.0, 0.0, 0.0, 0.0];
/// Time there and back, s: the end effector moves at up to 0.25 m/s, as fast as the slower preset allows.
pub const DURATION_S: f64 = 6.0;

/// Distance of neighbouring leaves, m: as dense as the forty of `scenes/leaf.toml` in its 0.55 m × 0.80 m.
const SPACING_M: f64 = 0.105;
/// The foam's top, m, world frame, and its modulus, Pa (wet floral foam): the defaults of scene files.
const FOAM_TOP_M: f64 = -0.50;
/// The grid's middle, m, world frame: in the middle of the region that the forearm and the hand pass through.
const CENTER_WORLD: DVec2 = DVec2::new(0.32, -0.33);
/// Clearance between the arm at its start and a leaf, m.
const CLEARANCE_M: f64 = 0.02;

/// The leaves have the defaults of scene files.
const SCENE: &str = r#"
summary = "Leaves on a grid for a fixed sweep of the arm"
[[objects.foam_block]]
count = 1
[[objects.leaf]]
count = 1
"#;

/// The arm, the leaves and the motion.
pub struct Sweep {
    /// Cody's arm, which starts in the posture at the start of the sweep.
    pub arm: Arm,
    /// The leaves, those nearest to the sweep first.
    pub clutter: Clutter,
}

impl Sweep {
    /// The sweep through `leaves` leaves, drawn from the seed `layout`. A smaller number takes the first of the same
    /// leaves, so those near the arm are always the same.
    pub fn new(leaves: usize, layout: u64) -> Self {
        let mut arm = Arm::cody().expect("Cody's files are sound");
        for (joint, degrees) in arm.joints.iter_mut().zip(START_DEG) {
            joint.start_rad = degrees.to_radians();
        }
        let links = ArmAtStart::of(&arm).links;
        let scene = Scene::parse("sweep.toml", SCENE.into()).expect("the scene is sound");
        let mut random = stream(layout, "sweep", 0, "clutter");
        let (block, _) = scene.file.objects.foam_block[0]
            .0
            .draw(&mut random, &Footing { height_m: 0.0, foam_modulus_pa: None })
            .expect("the block is sound");
        let footing =
            Footing { height_m: FOAM_TOP_M, foam_modulus_pa: block.foam_top().map(|(modulus_pa, _)| modulus_pa) };
        let leaf = &scene.file.objects.leaf[0].0;
        let yaw_deg = Draw::Uniform(-180.0, 180.0);
        let mut objects = Vec::new();
        for foot in grid() {
            if objects.len() == leaves {
                break;
            }
            let (object, drawn) = leaf.draw(&mut random, &footing).expect("the leaf stands");
            let placed = PlacedObject {
                object,
                drawn,
                stands_on: None,
                category: Category::LEAF,
                foot_world: foot.extend(FOAM_TOP_M),
                yaw_rad: yaw_deg.draw(&mut random, YAW_DEG).expect("an angle").to_radians(),
            };
            let capsule = placed.bounding_capsule();
            if links.iter().all(|link| link.distance(&capsule) > CLEARANCE_M) {
                objects.push(placed);
            }
        }
        Sweep { arm, clutter: Clutter { objects, ..Clutter::default() } }
    }

    /// The simulation at the start of the sweep.
    pub fn simulation(self, physics: PhysicsOptions, dormancy: bool) -> Simulation {
        Simulation::new(Setup {
            sensor: Sensor::new(&SensorOptions::default(), &self.arm.skin, 0, "sweep", 0),
            arm: self.arm,
            clutter: self.clutter,
            physics,
            dormancy,
        })
    }

    /// Number of frames.
    pub fn frames() -> usize {
        (DURATION_S / FRAME_PERIOD_S).round() as usize
    }

    /// Equilibrium angles of an arm during one frame, rad: out and back as half a cosine each.
    pub fn equilibrium_rad(arm: &Arm, frame: usize) -> Vec<f64> {
        let phase = frame as f64 / Sweep::frames() as f64;
        let share = (1.0 - (TAU * phase).cos()) / 2.0;
        let start = arm.start_posture_rad();
        start.iter().zip(SWEEP_DEG).map(|(start, sweep)| start + share * sweep.to_radians()).collect()
    }

    /// Runs the whole motion; `look` sees the report of each frame.
    pub fn run(simulation: &mut Simulation, mut look: impl FnMut(&FrameReport)) {
        for frame in 0..Sweep::frames() {
            let equilibrium_rad = Sweep::equilibrium_rad(simulation.arm(), frame);
            look(simulation.step(&equilibrium_rad));
        }
    }
}

/// The 33 × 33 points of a square grid, those nearest to the sweep's middle first.
fn grid() -> Vec<DVec2> {
    let half = 16_i32;
    let mut points: Vec<(i32, i32)> = (-half..=half).flat_map(|i| (-half..=half).map(move |j| (i, j))).collect();
    points.sort_by_key(|(i, j)| (i * i + j * j, *i, *j));
    points.into_iter().map(|(i, j)| CENTER_WORLD + DVec2::new(f64::from(i), f64::from(j)) * SPACING_M).collect()
}

/// Sum of the contact forces on each link in the reported frame, N, world frame.
#[allow(dead_code, reason = "the bench looks at no forces")]
pub fn force_on_links(report: &FrameReport) -> Vec<DVec3> {
    let mut forces = vec![DVec3::ZERO; report.link_pose_world.len()];
    for contact in &report.contacts {
        forces[contact.link] += contact.force_world;
    }
    forces
}
