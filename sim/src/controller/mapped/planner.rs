//! A way for the whole arm round obstacles, in joint space: straight to a posture at the goal if that is free, and
//! otherwise by RRT-connect (Kuffner and LaValle, ICRA 2000), with shortcuts.
//!
//! All random numbers come from one stream, and all work is counted in postures that are evaluated, never in time, so a
//! plan is the same on every machine.

use std::f64::consts::PI;

use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::arm_shapes::{ArmShapes, between, distance_rad, largest_change_rad};
use crate::arm::{Arm, Joint};
use crate::geometry::Capsule;

/// Postures that a plan may evaluate. At [`EVALUATION_S`] this is 0.2 s.
pub const BUDGET: usize = 40_000;
/// The price of an evaluated posture, s: forward kinematics and distances take 3 to 5 µs on one core.
pub const EVALUATION_S: f64 = 5e-6;

/// Postures at the goal that are enough, and starts of the search for them.
const GOAL_POSTURES: usize = 16;
const GOAL_STARTS: usize = 120;
/// Evaluations that a search for a posture at the goal counts for: about as many iterations.
const SEARCH_EVALUATIONS: usize = 12;
/// Straight ways that are enough to choose the shortest from.
const STRAIGHT_WAYS: usize = 3;
/// Longest edge of a tree, rad. Choice: half a radian moves the hand by a fifth of the workspace.
const EDGE_RAD: f64 = 0.5;
/// Where the arm is this close to an obstacle, postures that are checked are so far apart, m. The arm then cuts at most
/// half as deep into the margin between two of them.
const STRIDE_M: f64 = 0.005;
/// Attempts to cut a corner of a path.
const SHORTCUTS: usize = 100;

/// A ball of postures that a plan avoids.
#[derive(Clone, Debug)]
pub struct ForbiddenPostures {
    /// Its middle, rad.
    pub center_rad: Vec<f64>,
    /// Largest difference of any joint from the middle, rad.
    pub radius_rad: f64,
}

/// Why there is no way.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoWay {
    /// The arm cannot be at the goal, obstacles or not.
    #[error("the goal is out of reach")]
    OutOfReach,
    /// No posture at the goal is free.
    #[error("no posture at the goal is free")]
    NoFreePosture,
    /// The arm is not free where it starts.
    #[error("the arm is wedged")]
    Wedged,
    /// None was found within the budget.
    #[error("no way was found")]
    NotFound,
}

/// What a plan must be free of.
pub struct Planner<'a> {
    /// The arm.
    pub arm: &'a Arm,
    /// Its shapes.
    pub shapes: &'a ArmShapes,
    /// Obstacles, world frame.
    pub obstacles: &'a [Capsule],
    /// How far the arm stays from them, m.
    pub margin_m: f64,
    /// Postures to avoid.
    pub forbidden: &'a [ForbiddenPostures],
    /// Postures that may be evaluated.
    pub budget: usize,
    /// Postures evaluated so far.
    pub evaluations: usize,
}

/// A tree of postures, each with the index of the one before it.
#[derive(Default)]
struct Tree {
    postures: Vec<Vec<f64>>,
    before: Vec<Option<usize>>,
}

impl Tree {
    fn add(&mut self, posture_rad: Vec<f64>, before: Option<usize>) -> usize {
        self.postures.push(posture_rad);
        self.before.push(before);
        self.postures.len() - 1
    }

    fn nearest(&self, posture_rad: &[f64]) -> usize {
        let distance = |own: &Vec<f64>| distance_rad(own, posture_rad);
        let nearest = (0..self.postures.len())
            .map(|index| (index, distance(&self.postures[index])))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.map_or(0, |(index, _)| index)
    }

    /// The postures from this one back to the root.
    fn to_root(&self, mut index: usize) -> Vec<Vec<f64>> {
        let mut path = vec![self.postures[index].clone()];
        while let Some(before) = self.before[index] {
            path.push(self.postures[before].clone());
            index = before;
        }
        path
    }
}

impl Planner<'_> {
    /// Whether the arm is free in a posture.
    pub fn is_free(&mut self, posture_rad: &[f64]) -> bool {
        self.free_share(posture_rad, &vec![0.0; posture_rad.len()]).is_some()
    }

    fn free_share(&mut self, posture_rad: &[f64], change_rad: &[f64]) -> Option<f64> {
        self.evaluations += 1;
        let is_forbidden =
            |ball: &ForbiddenPostures| largest_change_rad(&ball.center_rad, posture_rad) < ball.radius_rad;
        if self.forbidden.iter().any(is_forbidden) {
            return None;
        }
        let link_poses = self.arm.forward_kinematics(posture_rad);
        self.shapes.free_share(&link_poses, change_rad, self.obstacles, self.margin_m)
    }

    /// Whether the straight way from a free posture to another one is free.
    pub fn is_free_between(&mut self, from_rad: &[f64], to_rad: &[f64]) -> bool {
        let change: Vec<f64> = from_rad.iter().zip(to_rad).map(|(from, to)| to - from).collect();
        let stride = (STRIDE_M / self.shapes.moved_m(&change).max(f64::MIN_POSITIVE)).min(1.0);
        // Balls of forbidden postures have no distance; a tenth of a radian finds them.
        let longest = 0.1 / largest_change_rad(from_rad, to_rad).max(0.1);
        let mut share = 0.0;
        while share < 1.0 {
            let Some(free) = self.free_share(&between(from_rad, to_rad, share), &change) else {
                return false;
            };
            let step = free.max(stride);
            share += if self.forbidden.is_empty() { step } else { step.min(longest) };
        }
        self.is_free(to_rad)
    }

    /// A path from a posture to one with the end effector at the goal, m, world frame: its corners, with both ends.
    ///
    /// # Errors
    /// [`NoWay`].
    pub fn plan(&mut self, start_rad: &[f64], goal: DVec3, random: &mut ChaCha8Rng) -> Result<Vec<Vec<f64>>, NoWay> {
        let path = self.any_path(start_rad, goal, random)?;
        Ok(self.shortened(path, random))
    }

    /// As [`Planner::plan`], but the path may have needless corners. It is found sooner.
    ///
    /// # Errors
    /// [`NoWay`].
    pub fn any_path(
        &mut self,
        start_rad: &[f64],
        goal: DVec3,
        random: &mut ChaCha8Rng,
    ) -> Result<Vec<Vec<f64>>, NoWay> {
        if !self.is_free(start_rad) {
            return Err(NoWay::Wedged);
        }
        let (postures, straight) = self.goal_postures(start_rad, goal, random)?;
        let shortest = |postures: Vec<Vec<f64>>| {
            let length = |posture: &Vec<f64>| largest_change_rad(start_rad, posture);
            postures.into_iter().min_by(|a, b| length(a).total_cmp(&length(b)))
        };
        if let Some(end) = shortest(straight) {
            return Ok(vec![start_rad.to_vec(), end]);
        }
        self.connect(start_rad, postures, random).ok_or(NoWay::NotFound)
    }

    /// Free postures at the goal, and those of them to which a straight way is free.
    #[allow(clippy::type_complexity, reason = "two lists of postures")]
    fn goal_postures(
        &mut self,
        start_rad: &[f64],
        goal: DVec3,
        random: &mut ChaCha8Rng,
    ) -> Result<(Vec<Vec<f64>>, Vec<Vec<f64>>), NoWay> {
        let (mut free, mut straight): (Vec<Vec<f64>>, Vec<Vec<f64>>) = (Vec::new(), Vec::new());
        let mut is_reached = false;
        for number in 0..GOAL_STARTS {
            // From the arm's own posture, then from ones near it, then from anywhere.
            let from_rad = match number {
                0 => start_rad.to_vec(),
                _ if number <= GOAL_STARTS / 3 => {
                    between(start_rad, &self.anywhere(random), 0.5 * random.random::<f64>())
                }
                _ => self.anywhere(random),
            };
            self.evaluations += SEARCH_EVALUATIONS;
            let Some(posture) = self.arm.posture_at(goal, &from_rad) else { continue };
            is_reached = true;
            let is_new = free.iter().all(|own| largest_change_rad(own, &posture) > 0.02);
            if !is_new || !self.is_free(&posture) {
                continue;
            }
            if self.is_free_between(start_rad, &posture) {
                straight.push(posture.clone());
            }
            free.push(posture);
            if straight.len() >= STRAIGHT_WAYS || free.len() >= GOAL_POSTURES {
                break;
            }
        }
        match (free.is_empty(), is_reached) {
            (false, _) => Ok((free, straight)),
            (true, true) => Err(NoWay::NoFreePosture),
            (true, false) => Err(NoWay::OutOfReach),
        }
    }

    /// A posture anywhere within the joints' limits.
    fn anywhere(&self, random: &mut ChaCha8Rng) -> Vec<f64> {
        let draw = |joint: &Joint| {
            // A joint without limits turns all round.
            let [low, high] = joint.controller_limits_rad.map(|limit| limit.clamp(-PI, PI));
            low + (high - low) * random.random::<f64>()
        };
        self.arm.joints.iter().map(draw).collect()
    }

    /// A path from the start to one of the ends by RRT-connect; `None` if the budget ends first.
    fn connect(&mut self, start_rad: &[f64], ends: Vec<Vec<f64>>, random: &mut ChaCha8Rng) -> Option<Vec<Vec<f64>>> {
        let mut trees = [Tree::default(), Tree::default()];
        trees[0].add(start_rad.to_vec(), None);
        for end in ends {
            trees[1].add(end, None);
        }
        let mut growing = 0;
        while self.evaluations < self.budget {
            let target = self.anywhere(random);
            if let (_, Some(tip)) = self.extend(&mut trees[growing], &target) {
                let target = trees[growing].postures[tip].clone();
                let other = &mut trees[1 - growing];
                loop {
                    let (is_there, added) = self.extend(other, &target);
                    let Some(last) = added else { break };
                    if is_there {
                        let mut sides = [trees[growing].to_root(tip), trees[1 - growing].to_root(last)];
                        if growing == 1 {
                            sides.swap(0, 1);
                        }
                        let [from_start, to_end] = sides;
                        // The meeting point is in both.
                        return Some(from_start.into_iter().rev().chain(to_end.into_iter().skip(1)).collect());
                    }
                }
            }
            growing = 1 - growing;
        }
        None
    }

    /// Grows a tree by one edge towards a posture: whether it arrives, and the new posture if the edge is free.
    fn extend(&mut self, tree: &mut Tree, target_rad: &[f64]) -> (bool, Option<usize>) {
        let near = tree.nearest(target_rad);
        let length = largest_change_rad(&tree.postures[near], target_rad);
        let is_there = length <= EDGE_RAD;
        let posture = match is_there {
            true => target_rad.to_vec(),
            false => between(&tree.postures[near], target_rad, EDGE_RAD / length),
        };
        if !self.is_free_between(&tree.postures[near], &posture) {
            return (false, None);
        }
        (is_there, Some(tree.add(posture, Some(near))))
    }

    /// The path with corners cut: two random points on different edges are joined if that is shorter and free.
    fn shortened(&mut self, mut path: Vec<Vec<f64>>, random: &mut ChaCha8Rng) -> Vec<Vec<f64>> {
        // The time that a motion takes; of motions that take the same time, the one that moves the other joints less.
        let time = |from: &[f64], to: &[f64]| largest_change_rad(from, to) + 0.1 * distance_rad(from, to);
        let length = |path: &[Vec<f64>]| path.windows(2).map(|pair| time(&pair[0], &pair[1])).sum::<f64>();
        for _ in 0..SHORTCUTS {
            if path.len() < 3 || self.evaluations >= self.budget {
                break;
            }
            let edges = path.len() - 1;
            let mut draw = || ((random.random::<f64>() * edges as f64) as usize, random.random::<f64>());
            let (mut first, mut second) = (draw(), draw());
            if first.0 > second.0 {
                std::mem::swap(&mut first, &mut second);
            }
            if first.0 == second.0 {
                continue;
            }
            let at = |(edge, share): (usize, f64)| between(&path[edge], &path[edge + 1], share);
            let (leave, join) = (at(first), at(second));
            let mut old = vec![leave.clone()];
            old.extend_from_slice(&path[first.0 + 1..=second.0]);
            old.push(join.clone());
            if time(&leave, &join) + 1e-6 < length(&old) && self.is_free_between(&leave, &join) {
                path.splice(first.0 + 1..=second.0, [leave, join]);
            }
        }
        path
    }
}
