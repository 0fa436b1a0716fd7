//! Everything that decides a reach: scene, arm, controller, rules, seed.

use std::fmt;
use std::sync::Arc;

use underbrush_recording::{InputError, Recording};

use super::{Observer, Reach, ReachError, ReachRules, Stop};
use crate::arm::{Arm, ArmAtStart};
use crate::controller::mapped::arm_shapes::ArmShapes;
use crate::controller::mapped::planner::{BUDGET, NoWay, Planner};
use crate::controller::{Controller, ControllerKind, Preset};
use crate::seed::stream;
use crate::sensor::Sensor;
use crate::simulation::{Setup, Simulation};
use crate::{Clutter, Scene};

/// Everything that decides a reach except its index.
///
/// ```
/// use underbrush_sim::reach::ReachPlan;
/// use underbrush_sim::scene::Scene;
///
/// let text = "summary = \"A trunk\"\n[goals]\ncount = 1\n[[objects.trunk]]\ncount = 1\n";
/// let plan = ReachPlan::new(Scene::parse("trunk.toml", text.into())?, None, 1)?;
/// let recording = plan.run(0, &mut |_| {})?;
/// assert_eq!(recording.goals.len(), 1);
/// assert_eq!(recording.frames[1].time_s, 0.01);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ReachPlan {
    /// The scene.
    pub scene: Scene,
    /// The arm.
    pub arm: Arm,
    /// The controller.
    pub controller: PlannedController,
    /// Whether the controller is told the true category of what touches each taxel, which no robot knows.
    pub has_true_verdicts: bool,
    /// What ends an attempt at a goal.
    pub rules: ReachRules,
    /// The campaign's seed.
    pub seed: u64,
}

/// Postures that may be evaluated for a goal to find a way to it: four times as many as a controller's plan may take.
const WAYS_BUDGET: usize = 4 * BUDGET;

/// A function that makes a controller for an arm.
pub type MakeController = Arc<dyn Fn(&Arm) -> Box<dyn Controller> + Send + Sync>;

/// The controller of a plan. It is made afresh for every reach, because reaches run in parallel and a controller may keep
/// state.
#[derive(Clone)]
pub struct PlannedController {
    /// Which of the controllers that ship it is, with its parameters, or which of them is wrapped; `None` for a user's own.
    pub shipped: Option<(ControllerKind, Preset)>,
    make: MakeController,
}

impl fmt::Debug for PlannedController {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PlannedController").field("shipped", &self.shipped).finish_non_exhaustive()
    }
}

impl PlannedController {
    /// The parameters of a controller that ships, with the scale factors and the ground of a scene.
    pub fn preset_in(scene: &Scene, kind: ControllerKind) -> Preset {
        let (own, robot) = (kind.preset(), scene.file.robot);
        Preset {
            end_effector_step_m: own.end_effector_step_m * robot.hand_speed_scale,
            // Otherwise it would limit the speed.
            equilibrium_step_rad: own.equilibrium_step_rad.map(|step| step * robot.hand_speed_scale),
            force_limit_n: own.force_limit_n * robot.force_limit_scale,
            floor_height_m: scene.floor_height_m(),
            ..own
        }
    }

    /// The parameters of a controller that ships.
    pub fn preset(&self) -> Option<&Preset> {
        self.shipped.as_ref().map(|(_, preset)| preset)
    }

    /// A controller for one reach of this arm.
    pub fn make(&self, arm: &Arm) -> Box<dyn Controller> {
        (self.make)(arm)
    }
}

impl ReachPlan {
    /// A plan with the scene's own arm, at the stiffness that the scene asks for, and, unless `controller` names
    /// another, the scene's own controller. The rules are those that the controller was published with, and the scene's patience.
    ///
    /// # Errors
    /// When the arm's files are bad.
    pub fn new(scene: Scene, controller: Option<ControllerKind>, seed: u64) -> Result<ReachPlan, InputError> {
        ReachPlan::with_arm(scene, None, controller, seed)
    }

    /// As [`ReachPlan::new`]. An arm that was already read replaces the one that the scene names.
    ///
    /// # Errors
    /// When the arm's files are bad, the scene's sensor options do not fit the arm's skin, or the arm lacks a link that carries a camera.
    pub fn with_arm(
        scene: Scene,
        arm: Option<Arm>,
        controller: Option<ControllerKind>,
        seed: u64,
    ) -> Result<ReachPlan, InputError> {
        let mut arm = arm.map_or_else(|| scene.load_arm(), Ok)?;
        arm.scale_stiffness(scene.file.robot.stiffness_scale);
        scene.sensor_fault(scene.file.sensor.fault_on(&arm.skin.layout))?;
        scene.check_links_of_cameras(&arm)?;
        let kind = controller.unwrap_or(scene.file.controller);
        let preset = PlannedController::preset_in(&scene, kind);
        let mut rules = ReachRules::published_with(kind);
        rules.progress = scene.file.goals.progress.unwrap_or(rules.progress);
        rules = scene.file.goals.patience_s.map_or(rules, |patience_s| rules.watched_for(patience_s));
        let own = preset.clone();
        let make = Arc::new(move |arm: &Arm| kind.controller(own.clone(), arm));
        let controller = PlannedController { shipped: Some((kind, preset)), make };
        Ok(ReachPlan { scene, arm, controller, has_true_verdicts: false, rules, seed })
    }

    /// The same plan with a user's own controller, which `make` makes for the plan's arm at the start of every reach.
    /// Scale factors on the hand's speed and on the allowed force do not apply to it.
    pub fn with_controller(mut self, make: impl Fn(&Arm) -> Box<dyn Controller> + Send + Sync + 'static) -> ReachPlan {
        self.controller = PlannedController { shipped: None, make: Arc::new(make) };
        self
    }

    /// The same plan with its controller wrapped in another one. `wrap` makes the other one at the start of every
    /// reach.
    pub fn with_controller_within(
        mut self,
        wrap: impl Fn(Box<dyn Controller>) -> Box<dyn Controller> + Send + Sync + 'static,
    ) -> ReachPlan {
        let make = self.controller.make;
        self.controller.make = Arc::new(move |arm: &Arm| wrap(make(arm)));
        self
    }

    /// The controller's name, as in recordings.
    pub fn controller_name(&self) -> String {
        self.controller.make(&self.arm).name().to_string()
    }

    /// Draws the clutter of reach number `reach_index`.
    ///
    /// # Errors
    /// When the scene is impossible for this draw.
    pub fn draw(&self, reach_index: u64) -> Result<Clutter, InputError> {
        Clutter::draw(&self.scene, &ArmAtStart::of(&self.arm), self.seed, reach_index)
    }

    /// The simulation of reach number `reach_index` at its start.
    ///
    /// # Errors
    /// When the scene is impossible for this draw.
    pub fn simulation(&self, reach_index: u64) -> Result<Simulation, InputError> {
        let file = &self.scene.file;
        Ok(Simulation::new(Setup {
            arm: self.arm.clone(),
            clutter: self.draw(reach_index)?,
            sensor: Sensor::new(&file.sensor, &self.arm.skin, self.seed, &self.scene.stream, reach_index),
            physics: file.physics.options(),
            dormancy: file.physics.dormancy,
        }))
    }

    /// Runs reach number `reach_index`.
    ///
    /// # Errors
    /// [`ReachError`] when the scene is impossible for this draw, or the controller returns the wrong number of angles.
    /// How the reach ends is data, never an error.
    pub fn run(&self, reach_index: u64, observer: &mut Observer) -> Result<Recording, ReachError> {
        self.run_until(reach_index, observer, &|| false)
    }

    /// As [`ReachPlan::run`], but abandons the reach in the first frame in which `stop` returns true.
    ///
    /// # Errors
    /// As [`ReachPlan::run`], and [`ReachError::Stopped`].
    pub fn run_until(&self, reach_index: u64, observer: &mut Observer, stop: &Stop) -> Result<Recording, ReachError> {
        Reach::new(self, self.simulation(reach_index)?, reach_index, stop).run(observer)
    }

    /// For each goal of a reach, whether the whole arm has a way to it from its start posture, round all fixed obstacles
    /// and above the floor. The way from goal to goal exists if both have one. Found ways are certain; that there is none
    /// is as sure as a long search in vain.
    ///
    /// # Errors
    /// When the scene is impossible for this draw.
    pub fn ways(&self, reach_index: u64) -> Result<Vec<Result<(), NoWay>>, InputError> {
        let clutter = self.draw(reach_index)?;
        let shapes = ArmShapes::new(&self.arm, self.scene.floor_height_m());
        let (start_rad, obstacles) = (self.arm.start_posture_rad(), clutter.obstacles());
        let mut random = stream(self.seed, &self.scene.stream, reach_index, "ways");
        let way = |goal| {
            let mut planner = Planner::new(&self.arm, &shapes, &obstacles, WAYS_BUDGET);
            planner.any_path(&start_rad, goal, &mut random).map(|_| ())
        };
        Ok(clutter.goals.iter().copied().map(way).collect())
    }
}
