//! Articulated bodies in generalized coordinates: the arm, and every object that moves.
//!
//! A [`Tree`] is a tree of rigid links on revolute, prismatic and free joints with springs, dampers and armatures. It is
//! made from an arm or from an object's [`crate::object::structure::Structure`]. A step is one of the θ-method: the
//! velocity u_θ = (1 − θ) u₀ + θ u₁ moves the tree from the start to the end of the step, and springs and dampers act as
//! they do at θ of the way. θ = ½ is the implicit midpoint rule, which is of second order and keeps the energy of
//! springs. A larger θ damps what the step does not resolve; [`Theta::of_phase`] says which trees need it. A step has
//! four parts:
//!
//! 1. [`Tree::begin`] moves a tree with θ = ½ ahead to the middle of the step. Poses, masses and contacts are those
//!    there. Other trees may move fast and are thin, so they stay.
//! 2. [`Tree::prepare`] finds u_θ if nothing touches the tree, and the mass matrix of the step, which includes springs
//!    and dampers.
//! 3. Contacts may change u_θ ([`crate::contact::solver`]).
//! 4. [`Tree::advance`] moves the tree to the end of the step.
//!
//! The equations are those of Featherstone, *Rigid Body Dynamics Algorithms* (2008): recursive Newton-Euler (table 5.1),
//! composite rigid bodies (table 6.2), and the factorization LᵀL that keeps the sparsity of a tree (table 6.3). All
//! vectors are in the axes of the world, and moments are about one point near the tree.

use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};
use underbrush_recording::Pose;

use crate::object::structure::{Axis, Drag, Grip, Spring};
use crate::physics::Theta;
use spatial::Spatial;

mod build;
mod factor;
mod forces;
mod motion;
mod spatial;
#[cfg(test)]
mod tests;

/// An end stop of a degree of freedom, on both sides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EndStop {
    /// Lower and upper limit, rad.
    pub limits_rad: [f64; 2],
    /// Stiffness, N m/rad.
    pub stiffness_nm_per_rad: f64,
    /// Loss time, s.
    pub loss_time_s: f64,
}

/// A degree of freedom: a displacement along or about an axis.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Coordinate {
    /// The link that it moves.
    pub link: usize,
    /// Whether it is a rotation.
    pub turns: bool,
    /// Unit axis in the frame of the joint.
    pub axis_joint: DVec3,
    /// Its spring, damper and armature.
    pub spring: Spring,
    /// Its end stop.
    pub stop: Option<EndStop>,
    /// Displacement, m or rad. Of a joint with three rotations it is the integral of the velocity.
    pub position: f64,
    /// Velocity, m/s or rad/s.
    pub velocity: f64,
    /// Displacement of the dashpot of the relaxing branch, m or rad.
    pub dashpot: f64,
    /// The coordinate before it on the way from the root.
    before: Option<usize>,
    /// Unit axis in the world frame.
    axis_world: DVec3,
}

impl Coordinate {
    /// At rest at 0, without an end stop, and yet of no link.
    pub fn new(Axis { direction, turns }: Axis, spring: Spring) -> Self {
        Coordinate { turns, axis_joint: direction, axis_world: direction, spring, ..Coordinate::default() }
    }
}

/// A rigid body of a tree.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Link {
    /// The link that carries it; the ground carries itself.
    pub parent: usize,
    /// Pose of the joint's frame in the frame of the parent. The link's own frame is there while the joint is at 0.
    pub joint_parent: Pose,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Centre of mass, m, frame of the link.
    pub center_of_mass_link: DVec3,
    /// Inertia about the centre of mass, kg m², axes of the link's frame.
    pub inertia_link: DMat3,
    /// What the air's drag acts on.
    pub drag: Option<Drag>,
    /// Pose in the world frame.
    pub pose_world: Pose,
    /// Its first coordinate, and the one after its last.
    coordinates: (usize, usize),
    /// The last coordinate that moves it: its own, or one of a link nearer to the root.
    last: Option<usize>,
    /// Whether its joint has three rotations, and the rotation of such a joint.
    is_ball: bool,
    turn: DQuat,
}

impl Link {
    /// A link without mass, and yet in no tree.
    pub fn new(parent: usize, joint_parent: Pose) -> Self {
        Link {
            parent,
            joint_parent,
            mass_kg: 0.0,
            center_of_mass_link: DVec3::ZERO,
            inertia_link: DMat3::ZERO,
            drag: None,
            pose_world: Pose::IDENTITY,
            coordinates: (0, 0),
            last: None,
            is_ball: false,
            turn: DQuat::IDENTITY,
        }
    }
}

/// A tree of links. Link 0 is the ground, which does not move.
///
/// ```
/// use glam::DVec3;
/// use underbrush_recording::Pose;
/// use underbrush_sim::dynamics::Tree;
/// use underbrush_sim::object::Object;
/// use underbrush_sim::object::foam_block::FoamBlock;
/// use underbrush_sim::physics::Theta;
///
/// // The top of a foam block is pressed with 1 N for 40 s, until its foam has relaxed.
/// let block = FoamBlock { height_m: 0.08, wet: true, modulus_pa: 5.0e4, stands_free: false };
/// let mut tree = Tree::of_structure(&block.structure(9.81), Pose::IDENTITY);
/// for _ in 0..8000 {
///     let top = tree.links()[1].pose_world.position;
///     tree.push(1, DVec3::Z * -1.0, top, DVec3::ZERO);
///     tree.begin(0.005, Theta::EULER);
///     tree.prepare(0.0);
///     tree.advance();
/// }
/// let spring = tree.coordinates[0].spring;
/// assert!((tree.coordinates[0].position * spring.stiffness + 1.0).abs() < 1e-3);
/// ```
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Tree {
    links: Vec<Link>,
    /// The degrees of freedom, from the ground on. After positions are set, call [`Tree::place`].
    pub coordinates: Vec<Coordinate>,
    /// Whether gravity acts on it.
    pub weighs: bool,
    /// Generalized forces of the next step, N or N m.
    pushes: Vec<f64>,
    /// The inertia that each coordinate moves in the posture of the first step, kg or kg m².
    inertia: Vec<f64>,
    /// The links that are roots in foam, and what holds them.
    grips: Vec<(usize, Grip)>,
    #[serde(skip)]
    scratch: Scratch,
}

/// What a step computes. It is made anew in each step.
#[derive(Clone, Debug, Default)]
struct Scratch {
    /// Length of the step, s, its θ, and how far the tree was moved ahead, s.
    step_s: f64,
    theta: Theta,
    ahead_s: f64,
    /// Motions of the links' coordinates per unit of velocity, in the order of the coordinates.
    axes: Vec<Spatial>,
    /// Velocities of the links at the start of the step, and at u_θ once that is found; and bias accelerations.
    velocities: Vec<Spatial>,
    accelerations: Vec<Spatial>,
    /// Bias forces and inertias of the links, later of all that they carry.
    forces: Vec<Spatial>,
    inertias: Vec<spatial::Inertia>,
    /// The mass matrix of the step: the lower triangle by rows.
    mass: Vec<f64>,
    factor: Vec<f64>,
    acceleration: Vec<f64>,
    motion: Vec<f64>,
    /// The velocities u_θ that move the tree in the step.
    next: Vec<f64>,
}

impl Tree {
    /// The links, the ground first.
    pub fn links(&self) -> &[Link] {
        &self.links
    }

    /// The degrees of freedom of the joint that carries a link.
    pub fn coordinates_of(&self, link: usize) -> &[Coordinate] {
        let (first, end) = self.links[link].coordinates;
        &self.coordinates[first..end]
    }

    /// Whether a link can move.
    pub fn moves(&self, link: usize) -> bool {
        self.links[link].last.is_some()
    }

    /// The velocities u_θ of the step that was prepared, one for each coordinate.
    pub fn next(&self) -> &[f64] {
        &self.scratch.next
    }

    /// How far a ball around a point of a link may move in the step that was prepared, m, if nothing touches the tree.
    pub fn way_m(&self, link: usize, center_world: DVec3, radius_m: f64) -> f64 {
        let Spatial { angular, linear } = self.scratch.velocities[link];
        let velocity = linear + angular.cross(center_world - self.about());
        self.scratch.step_s * (velocity.length() + angular.length() * radius_m)
    }

    /// The generalized accelerations of the step that was prepared, rad/s² or m/s².
    pub fn acceleration(&self) -> &[f64] {
        &self.scratch.acceleration
    }

    /// The coordinates that move a link, from its own towards the ground.
    pub fn path(&self, link: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(self.links[link].last, |at| self.coordinates[*at].before)
    }

    /// The coordinates that move a link, from its own towards the ground, each with the velocity of the point of the link
    /// at `point_world` and the angular velocity per unit of the coordinate's velocity, world frame.
    pub fn motions(&self, link: usize, point_world: DVec3) -> impl Iterator<Item = (usize, [DVec3; 2])> + '_ {
        self.path(link).map(move |at| {
            let Coordinate { link, turns, axis_world, .. } = self.coordinates[at];
            let motion = match turns {
                true => [axis_world.cross(point_world - self.links[link].pose_world.position), axis_world],
                false => [axis_world, DVec3::ZERO],
            };
            (at, motion)
        })
    }

    /// Velocity of the point of a link at `point_world`, m/s, and angular velocity, rad/s, world frame, at each of the
    /// velocities that `velocities` returns for a coordinate.
    #[inline(always)]
    pub fn velocities_at<const N: usize>(
        &self,
        link: usize,
        point_world: DVec3,
        velocities: impl Fn(usize) -> [f64; N],
    ) -> [[DVec3; 2]; N] {
        let mut sums = [[DVec3::ZERO; 2]; N];
        for (at, [linear, angular]) in self.motions(link, point_world) {
            for (sum, speed) in sums.iter_mut().zip(velocities(at)) {
                sum[0] += linear * speed;
                sum[1] += angular * speed;
            }
        }
        sums
    }

    /// Centre of mass of a link, m, world frame.
    pub fn center_of_mass_world(&self, link: usize) -> DVec3 {
        let link = &self.links[link];
        link.pose_world.transform_point(link.center_of_mass_link)
    }

    /// Adds a force (N) on a link at a point (m), and a moment (N m), world frame, for the next step.
    pub fn push(&mut self, link: usize, force_world: DVec3, point_world: DVec3, moment_world: DVec3) {
        let mut pushes = std::mem::take(&mut self.pushes);
        for (at, [linear, angular]) in self.motions(link, point_world) {
            pushes[at] += linear.dot(force_world) + angular.dot(moment_world);
        }
        self.pushes = pushes;
    }
}
