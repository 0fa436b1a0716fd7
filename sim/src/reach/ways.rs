//! Which goals of a reach have a way at all: the ceiling of what a controller can reach.

use underbrush_recording::InputError;

use super::plan::ReachPlan;
use crate::controller::mapped::arm_shapes::ArmShapes;
use crate::controller::mapped::planner::{NoWay, Planner};
use crate::controller::mapped::route::MARGIN_M;
use crate::seed::stream;

/// Postures that may be evaluated for a goal: four times as many as a controller's plan may take.
const BUDGET: usize = 4 * crate::controller::mapped::planner::BUDGET;

impl ReachPlan {
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
            let mut planner = Planner {
                arm: &self.arm,
                shapes: &shapes,
                obstacles: &obstacles,
                margin_m: MARGIN_M,
                forbidden: &[],
                budget: BUDGET,
                evaluations: 0,
            };
            planner.any_path(&start_rad, goal, &mut random).map(|_| ())
        };
        Ok(clutter.goals.iter().copied().map(way).collect())
    }
}
