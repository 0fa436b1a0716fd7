//! A path in joint space, measured in the control steps that the arm needs for it.

use super::arm_shapes::between;

/// Corners of a path, and how many control steps it takes to get to each.
#[derive(Clone, Debug)]
pub(super) struct Path {
    corners: Vec<Vec<f64>>,
    steps: Vec<f64>,
}

impl Path {
    /// The path through these corners; `step_rad` is how far each joint moves in a control step. A path has at least one
    /// corner.
    pub(super) fn new(corners: Vec<Vec<f64>>, step_rad: &[f64]) -> Self {
        let mut steps = vec![0.0];
        let mut sum = 0.0;
        for pair in corners.windows(2) {
            let joints = pair[0].iter().zip(&pair[1]).zip(step_rad);
            sum += joints.map(|((from, to), step)| (to - from).abs() / step).fold(0.0, f64::max);
            steps.push(sum);
        }
        Path { corners, steps }
    }

    /// Its length, control steps.
    pub(super) fn length(&self) -> f64 {
        self.steps.last().copied().unwrap_or_default()
    }

    /// The posture after this many control steps, rad.
    pub(super) fn at(&self, steps: f64) -> Vec<f64> {
        let edge = self.steps.partition_point(|own| *own <= steps).clamp(1, self.corners.len().max(2) - 1);
        let (Some(from), Some(to)) = (self.corners.get(edge - 1), self.corners.get(edge)) else {
            return self.corners.last().cloned().unwrap_or_default();
        };
        let length = self.steps[edge] - self.steps[edge - 1];
        let share = if length > 0.0 { (steps - self.steps[edge - 1]) / length } else { 1.0 };
        between(from, to, share.clamp(0.0, 1.0))
    }
}
