//! Everything that decides a reach: scene, arm, controller, seed.

use underbrush_recording::{InputError, Recording};

use super::{Observer, Reach};
use crate::arm::{Arm, ArmAtStart};
use crate::clutter::Clutter;
use crate::controller::{self, Controller, ControllerKind, Preset};
use crate::scene::Scene;
use crate::sensor::Sensor;
use crate::simulation::{Setup, Simulation};

/// Everything that decides a reach but its index.
#[derive(Clone, Debug)]
pub struct ReachPlan {
    /// The scene.
    pub scene: Scene,
    /// The arm.
    pub arm: Arm,
    /// The controller.
    pub controller: ControllerKind,
    /// The campaign's seed.
    pub seed: u64,
}

impl ReachPlan {
    /// A plan with the scene's own arm, as stiff as the scene says, and, unless another is named, its own controller.
    ///
    /// # Errors
    /// When the arm's files are bad or no controller has that name.
    pub fn new(scene: Scene, controller: Option<&str>, seed: u64) -> Result<ReachPlan, InputError> {
        let arm = match scene.file.arm.as_str() {
            "cody" => Arm::cody()?,
            path => Arm::load(scene.path.parent().unwrap_or(std::path::Path::new(".")).join(path))?,
        };
        ReachPlan::with_arm(scene, arm, controller, seed)
    }

    /// As [`ReachPlan::new`], with an arm that has already been read instead of the one that the scene names.
    ///
    /// # Errors
    /// When no controller has that name or the scene's sensor does not fit the arm's skin.
    pub fn with_arm(scene: Scene, mut arm: Arm, controller: Option<&str>, seed: u64) -> Result<ReachPlan, InputError> {
        arm.scale_stiffness(scene.file.robot.stiffness_scale);
        let name = controller.unwrap_or(&scene.file.controller);
        let Some(controller) = ControllerKind::from_name(name) else {
            let allowed = format!("one of {}", controller::NAMES.join(", "));
            return Err(scene.fault("controller", format!("`{name}`"), allowed));
        };
        scene.sensor_fault(scene.file.sensor.fault_on(&arm.skin.layout))?;
        Ok(ReachPlan {
            scene,
            arm,
            controller,
            seed,
        })
    }

    /// The controller's parameters.
    pub fn preset(&self) -> Preset {
        self.make_controller().preset().clone()
    }

    pub(super) fn make_controller(&self) -> Box<dyn Controller> {
        let hand_speed_scale = self.scene.file.robot.hand_speed_scale;
        self.controller.controller(&self.arm, hand_speed_scale)
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
            sensor: Sensor::new(&file.sensor, &self.arm.skin, self.seed, &self.scene.name, reach_index),
            physics: file.physics.options(),
            dormancy: file.physics.dormancy,
        }))
    }

    /// Runs reach number `reach_index`.
    ///
    /// # Errors
    /// When the scene is impossible for this draw; how the reach ends is data, never an error.
    pub fn run(&self, reach_index: u64, observer: &mut Observer) -> Result<Recording, InputError> {
        Ok(Reach::new(self, self.simulation(reach_index)?, reach_index).run(observer))
    }
}
