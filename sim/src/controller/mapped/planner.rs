//! A way for the whole arm round obstacles, in joint space: straight to a posture at the goal if that is free, and
//! otherwise by RRT-connect (Kuffner and LaValle, ICRA 2000), with shortcuts.
//!
//! All random numbers come from one stream, and all work is counted in postures that are evaluated, never in time, so a
//! plan is the same on every machine.

use std::slice::from_ref;

use glam::DVec3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use super::arm_shapes::{ArmShapes, between, distance_rad, largest_change_rad};
use super::tree::Tree;
use crate::arm::Arm;
use crate::geometry::Capsule;

/// Postures that a plan may evaluate. At [`EVALUATION_S`] this is 0.2 s.
pub const BUDGET: usize = 40_000;
/// The price of an evaluated posture, s: forward kinematics and distances take 1.2 to 1.3 µs on a core of a server. Choice: four times as
/// much, for the computer of a robot.
pub const EVALUATION_S: f64 = 5e-6;

/// Postures at the goal that are enough, and starts of the search for them.
const GOAL_POSTURES: usize = 16;
const GOAL_STARTS: usize = 120;
/// Evaluations that a search for a posture at the goal counts for: about as many iterations.
const SEARCH_EVALUATIONS: usize = 12;
/// Other ways are tried as long as fewer postures than this were evaluated, which is 50 ms at [`EVALUATION_S`]. Choice: a way that
/// is shorter by a tenth saves some 400 ms.
const TRIES: usize = 10_000;
/// How often a posture at the goal is drawn in at most, and the share of the largest change of a joint that is left each time.
const DRAWN_IN: (usize, f64) = (8, 0.85);
/// A posture that is drawn in counts if it makes the way shorter by this share.
const SHORTER: f64 = 0.01;
/// Longest edge of a tree, rad. Choice: half a radian moves the hand by a fifth of the workspace.
const EDGE_RAD: f64 = 0.5;
/// Postures that are drawn in a row without one that a shorter way could lead through.
const DRAWS: usize = 2000;
/// Where the arm is this close to an obstacle, postures that are checked are so far apart, m. The arm then cuts at most
/// half as deep into the margin between two of them.
const STRIDE_M: f64 = 0.005;
/// Attempts to cut a corner of a path, before and after its end is drawn in.
const SHORTCUTS: usize = 40;

/// How far a way stays from obstacles, m: more than the arm strays from it.
pub(super) const MARGIN_M: f64 = 0.005;

/// Postures of an arm, rad: the corners of a path with both of its ends, or any others.
pub type Postures = Vec<Vec<f64>>;

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

/// The length of a path, rad: the sum of the largest change of any joint on each edge, so the time that it takes at equal speeds.
pub fn length_rad(path: &[Vec<f64>]) -> f64 {
    path.windows(2).map(|pair| largest_change_rad(&pair[0], &pair[1])).sum()
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

impl<'a> Planner<'a> {
    /// The usual margin, nothing forbidden, and no posture evaluated yet.
    pub fn new(arm: &'a Arm, shapes: &'a ArmShapes, obstacles: &'a [Capsule], budget: usize) -> Self {
        Planner { arm, shapes, obstacles, margin_m: MARGIN_M, forbidden: &[], budget, evaluations: 0 }
    }

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
        self.shapes.free_share(&self.arm.forward_kinematics(posture_rad), change_rad, self.obstacles, self.margin_m)
    }

    /// Whether the straight way from a free posture to another one is free.
    pub fn is_free_between(&mut self, from_rad: &[f64], to_rad: &[f64]) -> bool {
        let change: Vec<f64> = from_rad.iter().zip(to_rad).map(|(from, to)| to - from).collect();
        let stride = (STRIDE_M / self.shapes.moved_m(&change).max(f64::MIN_POSITIVE)).min(1.0);
        // Balls of forbidden postures have no distance; a tenth of a radian finds them.
        let longest = 0.1 / largest_change_rad(from_rad, to_rad).max(0.1);
        let mut share = 0.0;
        while share < 1.0 {
            let Some(free) = self.free_share(&between(from_rad, to_rad, share), &change) else { return false };
            let step = free.max(stride);
            share += if self.forbidden.is_empty() { step } else { step.min(longest) };
        }
        self.is_free(to_rad)
    }

    /// A path from a posture to one with the end effector at the goal, m, world frame: its corners, with both ends. It is the
    /// shortest of several.
    ///
    /// # Errors
    /// [`NoWay`].
    pub fn plan(&mut self, start_rad: &[f64], goal: DVec3, random: &mut ChaCha8Rng) -> Result<Postures, NoWay> {
        let (ends, straight) = self.goal_postures(start_rad, goal, GOAL_POSTURES, random)?;
        let change_rad = |end: &Vec<f64>| largest_change_rad(start_rad, end);
        if let Some(end) = straight.into_iter().min_by(|a, b| change_rad(a).total_cmp(&change_rad(b))) {
            return Ok(vec![start_rad.to_vec(), self.drawn_in(start_rad, end, goal)]);
        }
        let budget = self.budget;
        let mut shortest: Option<Postures> = None;
        while shortest.is_none() || self.evaluations < self.budget {
            let length = shortest.as_deref().map(length_rad);
            let Some(path) = self.connect(start_rad, &ends, length, random) else { break };
            let path = self.shortened(path, goal, random);
            if length.is_none_or(|length| length_rad(&path) < length) {
                shortest = Some(path);
            }
            self.budget = budget.min(TRIES);
        }
        self.budget = budget;
        shortest.ok_or(NoWay::NotFound)
    }

    /// As [`Planner::plan`], but the first path that is found, which may have needless corners.
    ///
    /// # Errors
    /// [`NoWay`].
    pub fn any_path(&mut self, start_rad: &[f64], goal: DVec3, random: &mut ChaCha8Rng) -> Result<Postures, NoWay> {
        let (ends, straight) = self.goal_postures(start_rad, goal, 1, random)?;
        match straight.into_iter().next() {
            Some(end) => Ok(vec![start_rad.to_vec(), end]),
            None => self.connect(start_rad, &ends, None, random).ok_or(NoWay::NotFound),
        }
    }

    /// Free postures at the goal, and those of them to which a straight way from the start is free, of which `enough` are enough.
    fn goal_postures(
        &mut self,
        start_rad: &[f64],
        goal: DVec3,
        enough: usize,
        random: &mut ChaCha8Rng,
    ) -> Result<(Postures, Postures), NoWay> {
        if !self.is_free(start_rad) {
            return Err(NoWay::Wedged);
        }
        let (mut free, mut straight): (Postures, Postures) = (Vec::new(), Vec::new());
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
            if straight.len() >= enough || free.len() >= GOAL_POSTURES {
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
        self.arm.joints.iter().map(|joint| joint.at_share(random.random::<f64>())).collect()
    }

    /// A posture at the goal that is nearer to `from_rad` than `end`: the joints that change most are held back, and inverse
    /// kinematics leads from there to the goal again. Ends when that makes the way no shorter, or it is not free.
    fn drawn_in(&mut self, from_rad: &[f64], mut end: Vec<f64>, goal: DVec3) -> Vec<f64> {
        for _ in 0..DRAWN_IN.0 {
            let longest = largest_change_rad(from_rad, &end);
            let left = DRAWN_IN.1 * longest;
            let held: Vec<f64> =
                from_rad.iter().zip(&end).map(|(from, to)| from + (to - from).max(-left).min(left)).collect();
            self.evaluations += SEARCH_EVALUATIONS;
            let Some(other) = self.arm.posture_at(goal, &held) else { break };
            if largest_change_rad(from_rad, &other) > (1.0 - SHORTER) * longest
                || !self.is_free_between(from_rad, &other)
            {
                break;
            }
            end = other;
        }
        end
    }

    /// A path from the start to one of the ends by RRT-connect; `None` if the budget ends first. If it is to be shorter than
    /// `length_rad`, only postures are drawn through which a shorter path could lead.
    fn connect(
        &mut self,
        start_rad: &[f64],
        ends: &[Vec<f64>],
        length_rad: Option<f64>,
        random: &mut ChaCha8Rng,
    ) -> Option<Postures> {
        let mut trees = [(); 2].map(|()| Tree::new(start_rad.len()));
        trees[0].add(start_rad, None);
        for end in ends {
            trees[1].add(end, None);
        }
        let is_near = |posture: &[f64]| {
            length_rad.is_none_or(|length| {
                let left = length - largest_change_rad(start_rad, posture);
                ends.iter().any(|end| largest_change_rad(posture, end) < left)
            })
        };
        let mut growing = 0;
        while self.evaluations < self.budget {
            let target = (0..DRAWS).map(|_| self.anywhere(random)).find(|posture| is_near(posture))?;
            if let (_, Some(tip)) = self.extend(&mut trees[growing], &target) {
                let target = trees[growing].posture(tip).to_vec();
                let other = &mut trees[1 - growing];
                loop {
                    let (is_there, added) = self.extend(other, &target);
                    let Some(last) = added else { break };
                    if is_there {
                        let met = if growing == 0 { [tip, last] } else { [last, tip] };
                        let [from_start, to_end] = [0, 1].map(|side| trees[side].to_root(met[side]));
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
        let near_rad = tree.posture(near);
        let length = largest_change_rad(near_rad, target_rad);
        let is_there = length <= EDGE_RAD;
        let posture = if is_there { target_rad.to_vec() } else { between(near_rad, target_rad, EDGE_RAD / length) };
        if !self.is_free_between(near_rad, &posture) {
            return (false, None);
        }
        (is_there, Some(tree.add(&posture, Some(near))))
    }

    /// The path with corners cut, and its end drawn in.
    fn shortened(&mut self, path: Postures, goal: DVec3, random: &mut ChaCha8Rng) -> Postures {
        let mut path = self.cut(path, random);
        if let [.., from, end] = &mut path[..] {
            *end = self.drawn_in(from, std::mem::take(end), goal);
        }
        self.cut(path, random)
    }

    /// The path with corners cut: two random points on different edges are joined if that is shorter and free.
    fn cut(&mut self, mut path: Postures, random: &mut ChaCha8Rng) -> Postures {
        // The time that a motion takes; of motions that take the same time, the one that moves the other joints less.
        let time = |from: &[f64], to: &[f64]| largest_change_rad(from, to) + 0.1 * distance_rad(from, to);
        let length = |path: &[Vec<f64>]| path.windows(2).map(|pair| time(&pair[0], &pair[1])).sum::<f64>();
        for _ in 0..SHORTCUTS {
            if path.len() < 3 || self.evaluations >= self.budget {
                break;
            }
            let edges = path.len() - 1;
            let mut draw = || ((random.random::<f64>() * edges as f64) as usize, random.random::<f64>());
            let mut ends = [draw(), draw()];
            ends.sort_by_key(|(edge, _)| *edge);
            let [first, second] = ends;
            if first.0 == second.0 {
                continue;
            }
            let at = |(edge, share): (usize, f64)| between(&path[edge], &path[edge + 1], share);
            let (leave, join) = (at(first), at(second));
            let old = [from_ref(&leave), &path[first.0 + 1..=second.0], from_ref(&join)].concat();
            if time(&leave, &join) + 1e-6 < length(&old) && self.is_free_between(&leave, &join) {
                path.splice(first.0 + 1..=second.0, [leave, join]);
            }
        }
        path
    }
}
