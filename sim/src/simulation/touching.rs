//! Contacts between the engine's bodies, added to a step that the engine made without any.
//!
//! The engine finds which shapes are near each other, but its own solver presses on none of them: no collider is in a solver
//! group. Before its step the poses, Jacobians and velocities of every articulated body are copied. After it, the patches of
//! the shapes that overlap are made from those poses, [`crate::contact::solver`] finds the velocities with contacts, and these
//! replace the engine's, with positions to match.

use glam::DVec3;
use nalgebra::{DMatrix, Vector3};
use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};
use underbrush_recording::Pose as WorldPose;

use crate::contact::law::{Law, NormalSpeeds, center_of_pressure, in_plane};
use crate::contact::patch::{Node, Pair, Plane};
use crate::contact::solver::{Convergence, ROWS, Solver, Stop};
use crate::contact::surface::Surface;
use crate::geometry::from_parry;

/// What two shapes did to each other in one step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    /// The shapes.
    pub(super) colliders: [ColliderHandle; 2],
    /// Centre of pressure when the step began, in the frames of the two bodies, m.
    pub(super) position_body: [DVec3; 2],
    /// Unit normal, world frame: the first body is pushed along it.
    pub(super) normal_world: DVec3,
    /// Normal impulse on the first body, N s.
    pub(super) normal_impulse: f64,
    /// Impulse on the first body with friction, N s, world frame.
    pub(super) impulse_world: DVec3,
    /// Moment of the friction on the first body about the normal, N m s, world frame.
    pub(super) moment_world: DVec3,
    /// Largest overlap of the undeformed shapes at the end of the step, m.
    pub(super) overlap_m: f64,
    /// Distance of the farthest part of the patch from its centre of pressure, m.
    pub(super) radius_m: f64,
    /// Velocity of the first surface against the second at the end of the step, in the tangent plane, m/s, world frame.
    pub(super) slip_world: DVec3,
}

/// An end stop of a joint, on both sides.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(super) struct JointStop {
    pub(super) joint: MultibodyJointHandle,
    /// The free axis in the engine's layout of six.
    pub(super) axis: usize,
    /// Lower and upper limit, rad.
    pub(super) limits_rad: [f64; 2],
    pub(super) stiffness_nm_per_rad: f64,
    pub(super) loss_time_s: f64,
}

/// Two colliders, as raw handles, which can be sorted.
type PairKey = [(u32, u32); 2];

/// What a pair of shapes in contact keeps from step to step, in the frame of the second body.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Kept {
    /// The bodies.
    bodies: PairKey,
    /// The contact's normal.
    normal: DVec3,
    /// Elastic displacement of the contact along its surface, m.
    stuck: DVec3,
    /// The same about the normal, times the patch's radius, m.
    stuck_about_normal: f64,
}

/// The state and the buffers of the contacts of one engine.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct Touching {
    /// The surfaces of the colliders, by the index in their handle.
    surfaces: Vec<Option<Surface>>,
    pub(super) stops: Vec<JointStop>,
    /// Sorted by pair.
    kept: Vec<(PairKey, Kept)>,
    /// The contacts of the last step.
    #[serde(skip)]
    pub(super) touches: Vec<Touch>,
    /// How the last step was solved.
    #[serde(skip)]
    pub(super) convergence: Convergence,
    #[serde(skip)]
    scratch: Scratch,
}

/// Buffers, kept so that a step allocates nothing.
#[derive(Clone, Default)]
struct Scratch {
    bodies: Vec<Copied>,
    /// How many of them are of this step.
    count: usize,
    pairs: Vec<[ColliderHandle; 2]>,
    candidates: Vec<Candidate>,
    nodes: Vec<Node>,
    patches_of_body: Vec<usize>,
    order: Vec<usize>,
    block_of_body: Vec<usize>,
    mass: DMatrix<f64>,
    displacement: Vec<f64>,
    kept: Vec<(PairKey, Kept)>,
    solver: Solver,
}

/// What the engine's step overwrites of an articulated body.
#[derive(Clone)]
struct Copied {
    index: MultibodyIndex,
    velocity: Vec<f64>,
    poses: Vec<Pose>,
    centers_of_mass: Vec<DVec3>,
    jacobians: Vec<Jacobian<f64>>,
}

/// A link of a copied body.
#[derive(Clone, Copy, Debug)]
struct LinkOf {
    body: usize,
    link: usize,
}

/// A patch before the solution.
#[derive(Clone)]
struct Candidate {
    colliders: [ColliderHandle; 2],
    bodies: PairKey,
    links: [Option<LinkOf>; 2],
    body_poses: [WorldPose; 2],
    plane: Plane,
    law: Law,
    nodes: (usize, usize),
    center: glam::DVec2,
    radius_m: f64,
    stuck: Vector3<f64>,
}

/// The part of an engine that contacts work on.
pub(super) struct Parts<'a> {
    pub(super) bodies: &'a mut RigidBodySet,
    pub(super) colliders: &'a ColliderSet,
    pub(super) joints: &'a mut MultibodyJointSet,
    pub(super) narrow_phase: &'a NarrowPhase,
    pub(super) step_s: f64,
}

impl Touching {
    /// Gives a collider its surface.
    pub(super) fn set_surface(&mut self, collider: ColliderHandle, surface: Surface) {
        let index = collider.into_raw_parts().0 as usize;
        if self.surfaces.len() <= index {
            self.surfaces.resize(index + 1, None);
        }
        self.surfaces[index] = Some(surface);
    }

    fn surface(&self, collider: ColliderHandle) -> Option<Surface> {
        *self.surfaces.get(collider.into_raw_parts().0 as usize)?
    }

    /// Copies what the engine's step overwrites.
    pub(super) fn before_step(&mut self, bodies: &RigidBodySet, joints: &MultibodyJointSet) {
        let scratch = &mut self.scratch;
        scratch.count = 0;
        for multibody in joints.multibodies() {
            let root = multibody.root().rigid_body_handle();
            let Some(index) = joints.rigid_body_link(root).map(|link| link.multibody) else {
                continue;
            };
            if multibody.ndofs() == 0 {
                continue;
            }
            if scratch.count == scratch.bodies.len() {
                scratch.bodies.push(Copied {
                    index,
                    velocity: Vec::new(),
                    poses: Vec::new(),
                    centers_of_mass: Vec::new(),
                    jacobians: Vec::new(),
                });
            }
            let copied = &mut scratch.bodies[scratch.count];
            scratch.count += 1;
            copied.copy(index, multibody, bodies);
        }
    }

    /// Replaces the velocities and positions at the end of the engine's step by those with contacts.
    pub(super) fn after_step(&mut self, parts: &mut Parts) {
        self.touches.clear();
        self.convergence = Convergence::default();
        self.find_pairs(parts);
        self.find_patches(parts);
        if self.choose_blocks(parts) {
            self.fill_solver(parts);
            self.convergence = self.scratch.solver.solve();
            self.apply(parts);
        }
        self.keep();
    }

    /// Pairs of shapes that the engine found near each other, in an order that does not depend on its own.
    fn find_pairs(&mut self, parts: &Parts) {
        let pairs = &mut self.scratch.pairs;
        pairs.clear();
        let near = parts.narrow_phase.contact_pairs();
        pairs.extend(
            near.filter(|pair| pair.manifolds().iter().any(|manifold| !manifold.points.is_empty()))
                .map(|pair| [pair.collider1, pair.collider2]),
        );
        pairs.sort_unstable_by_key(key);
    }

    /// The patches of those pairs that may press on each other in this step.
    fn find_patches(&mut self, parts: &Parts) {
        let mut scratch = std::mem::take(&mut self.scratch);
        scratch.candidates.clear();
        scratch.nodes.clear();
        for colliders in &scratch.pairs {
            let candidate = self.candidate(*colliders, &scratch.bodies[..scratch.count], &mut scratch.nodes, parts);
            scratch.candidates.extend(candidate);
        }
        self.scratch = scratch;
    }

    fn candidate(
        &self,
        handles: [ColliderHandle; 2],
        copies: &[Copied],
        nodes: &mut Vec<Node>,
        parts: &Parts,
    ) -> Option<Candidate> {
        let colliders = handles.map(|handle| &parts.colliders[handle]);
        let links = colliders.map(|collider| link_of(collider, copies, parts));
        if links.iter().all(Option::is_none) {
            return None;
        }
        let [first, second] = [0, 1].map(|side| body_pose(colliders[side], links[side], copies, parts));
        let body_poses = [first?, second?];
        let shape_poses = [0, 1].map(|side| {
            let on_body = colliders[side].position_wrt_parent();
            on_body.map_or(body_poses[side], |pose| body_poses[side] * from_parry(pose))
        });
        let pair = Pair {
            shapes: colliders.map(|collider| collider.shape()),
            poses_world: shape_poses,
        };
        let found = parts.narrow_phase.contact_pair(handles[0], handles[1])?;
        let manifold = found.manifolds().iter().find(|manifold| !manifold.points.is_empty())?;
        let kept = self.kept(&key(&handles));
        let bodies = [colliders[0].parent()?, colliders[1].parent()?].map(|body| body.into_raw_parts());
        let known = kept.or_else(|| self.sibling(&bodies));
        let plane = place(
            &pair,
            manifold,
            known.map(|kept| body_poses[1].transform_vector(kept.normal)),
        );
        let interface = self.surface(handles[0])?.with(&self.surface(handles[1])?);
        let law = Law {
            stiffness_n_per_m3: interface.stiffness_n_per_m3,
            loss_time_s: interface.loss_time_s,
            friction: interface.friction,
            step_s: parts.step_s,
        };
        let overlap_m = pair.overlap_m(&plane)?;
        let before = relative_speeds(&plane, links, copies, |body, index| copies[body].velocity[index]);
        // Where surfaces stay in contact their speed hardly changes. A surface that is about to arrive may be accelerated.
        let mut over_m = law.closing_m(before[0]);
        if overlap_m <= over_m {
            let free = relative_speeds(&plane, links, copies, |body, index| {
                let multibody = parts.joints.get_multibody(copies[body].index);
                multibody.map_or(0.0, |multibody| multibody.generalized_velocity()[index])
            });
            over_m = law.closing_m(free[0]);
        }
        let first_node = nodes.len();
        pair.nodes(&plane, over_m, nodes);
        if nodes.len() == first_node {
            return None;
        }
        let (center, radius_m) = law.center_and_radius(&nodes[first_node..], &before);
        let stuck = kept.map_or(Vector3::zeros(), |kept| {
            let stuck_world = body_poses[1].transform_vector(kept.stuck);
            Vector3::new(
                stuck_world.dot(plane.tangents_world[0]),
                stuck_world.dot(plane.tangents_world[1]),
                kept.stuck_about_normal,
            )
        });
        Some(Candidate {
            colliders: handles,
            bodies,
            links,
            body_poses,
            plane,
            law,
            nodes: (first_node, nodes.len()),
            center,
            radius_m,
            stuck,
        })
    }

    fn kept(&self, key: &PairKey) -> Option<&Kept> {
        let at = self.kept.binary_search_by(|(other, _)| other.cmp(key)).ok()?;
        Some(&self.kept[at].1)
    }

    /// What another pair of shapes of the same two bodies keeps. A blade between two shapes of
    /// one link must not be pushed towards one by the other.
    fn sibling(&self, bodies: &PairKey) -> Option<&Kept> {
        let mut kept = self.kept.iter().map(|(_, kept)| kept);
        kept.find(|kept| kept.bodies == *bodies)
    }

    /// Gives every articulated body that something may touch, or that is near an end stop, a block of the solver. The more
    /// it touches, the later its block. Returns whether there are any.
    fn choose_blocks(&mut self, parts: &Parts) -> bool {
        let scratch = &mut self.scratch;
        scratch.solver.start(parts.step_s);
        scratch.patches_of_body.clear();
        scratch.patches_of_body.resize(scratch.count, 0);
        for link in scratch
            .candidates
            .iter()
            .flat_map(|candidate| candidate.links.iter().flatten())
        {
            scratch.patches_of_body[link.body] += 1;
        }
        for stop in &self.stops {
            if let Some(body) = body_of_joint(stop.joint, &scratch.bodies[..scratch.count], parts) {
                scratch.patches_of_body[body] += usize::from(is_near(stop, parts));
            }
        }
        scratch.order.clear();
        let counts = &scratch.patches_of_body;
        scratch
            .order
            .extend((0..scratch.count).filter(|body| counts[*body] > 0));
        scratch.order.sort_by_key(|body| counts[*body]);
        scratch.block_of_body.clear();
        scratch.block_of_body.resize(scratch.count, usize::MAX);
        for body in &scratch.order {
            let copied = &scratch.bodies[*body];
            let Some(multibody) = parts.joints.get_multibody(copied.index) else {
                continue;
            };
            mass_matrix(multibody, &mut scratch.mass);
            let mass = &scratch.mass;
            scratch.block_of_body[*body] = scratch.solver.add_block(
                copied.velocity.iter().copied(),
                multibody.generalized_velocity().iter().copied(),
                |row, column| mass[(row, column)],
            );
        }
        !scratch.order.is_empty()
    }

    fn fill_solver(&mut self, parts: &Parts) {
        let scratch = &mut self.scratch;
        for candidate in &scratch.candidates {
            let nodes = &scratch.nodes[candidate.nodes.0..candidate.nodes.1];
            let patch = scratch.solver.add_patch(candidate.law, nodes, candidate.stuck);
            for (side, link) in candidate.links.iter().enumerate() {
                let Some(link) = link else { continue };
                let copied = &scratch.bodies[link.body];
                let sign = if side == 0 { 1.0 } else { -1.0 };
                let columns = candidate.columns(copied, link.link, sign);
                scratch
                    .solver
                    .add_side(patch, side, scratch.block_of_body[link.body], columns);
            }
        }
        for stop in &self.stops {
            let Some(body) = body_of_joint(stop.joint, &scratch.bodies[..scratch.count], parts) else {
                continue;
            };
            let Some((multibody, link)) = parts.joints.get(stop.joint) else {
                continue;
            };
            let Some(link) = multibody.link(link) else { continue };
            if !is_near(stop, parts) {
                continue;
            }
            let index = scratch.solver.offset(scratch.block_of_body[body]) + link.assembly_id();
            // The engine has moved on to the end of its step.
            let angle = link.joint.coords()[stop.axis] - parts.step_s * multibody.joint_velocity(link)[0];
            for (sign, overlap_rad) in [(1.0, stop.limits_rad[0] - angle), (-1.0, angle - stop.limits_rad[1])] {
                scratch.solver.add_stop(Stop {
                    index,
                    sign,
                    overlap_rad,
                    stiffness_nm_per_rad: stop.stiffness_nm_per_rad,
                    loss_time_s: stop.loss_time_s,
                });
            }
        }
    }

    /// Writes velocities and positions into the engine, and what happened into [`Touching::touches`].
    fn apply(&mut self, parts: &mut Parts) {
        let scratch = &mut self.scratch;
        for body in &scratch.order {
            let block = scratch.block_of_body[*body];
            scratch.displacement.clear();
            scratch
                .displacement
                .extend(scratch.solver.change(block).map(|change| change * parts.step_s));
            if scratch.displacement.iter().all(|part| *part == 0.0) {
                continue;
            }
            let Some(multibody) = parts.joints.get_multibody_mut(scratch.bodies[*body].index) else {
                continue;
            };
            let mut velocities = multibody.generalized_velocity_mut();
            for (velocity, solved) in velocities.iter_mut().zip(scratch.solver.velocity(block)) {
                *velocity = *solved;
            }
            multibody.apply_displacements(&scratch.displacement);
            multibody.forward_kinematics(parts.bodies, false);
            for link in multibody.links().filter(|link| !link.is_root()) {
                // Unlike `update_rigid_bodies`, this also moves the colliders, from the next step on.
                parts.bodies[link.rigid_body_handle()].set_position(*link.local_to_world(), false);
            }
        }
        for (patch, candidate) in scratch.candidates.iter().enumerate() {
            let solved = scratch.solver.solved(patch);
            let normal_impulse = solved.normal_impulse[0];
            if normal_impulse <= 0.0 {
                continue;
            }
            let plane = &candidate.plane;
            let at = center_of_pressure(&solved.normal_impulse);
            let position_world = plane.origin_world + in_plane(&plane.tangents_world, at.x, at.y);
            let tangential = |parts: &Vector3<f64>| in_plane(&plane.tangents_world, parts[0], parts[1]);
            let nodes = &scratch.nodes[candidate.nodes.0..candidate.nodes.1];
            let overlaps = nodes.iter().map(|node| {
                let speeds = &solved.normal_speeds;
                node.overlap_m - parts.step_s * (speeds[0] + node.place.y * speeds[1] - node.place.x * speeds[2])
            });
            self.touches.push(Touch {
                colliders: candidate.colliders,
                position_body: candidate
                    .body_poses
                    .map(|pose| pose.inverse_transform_point(position_world)),
                normal_world: plane.normal_world,
                normal_impulse,
                impulse_world: plane.normal_world * normal_impulse + tangential(&solved.friction_impulse),
                moment_world: plane.normal_world * (candidate.radius_m * solved.friction_impulse[2]),
                overlap_m: overlaps.fold(f64::NEG_INFINITY, f64::max),
                radius_m: nodes.iter().map(|node| node.place.distance(at)).fold(0.0, f64::max),
                slip_world: tangential(&solved.slip_speeds),
            });
        }
    }

    /// Keeps what the pairs need in the next step.
    fn keep(&mut self) {
        let scratch = &mut self.scratch;
        scratch.kept.clear();
        let solved = !scratch.order.is_empty();
        for (patch, candidate) in scratch.candidates.iter().enumerate() {
            let to_body = |vector| candidate.body_poses[1].inverse_transform_vector(vector);
            let result = solved.then(|| scratch.solver.solved(patch));
            let stuck = result
                .filter(|result| result.normal_impulse[0] > 0.0)
                .map(|result| result.stuck_m);
            let stuck = stuck.unwrap_or_default();
            scratch.kept.push((
                key(&candidate.colliders),
                Kept {
                    bodies: candidate.bodies,
                    normal: to_body(candidate.plane.normal_world),
                    stuck: to_body(in_plane(&candidate.plane.tangents_world, stuck[0], stuck[1])),
                    stuck_about_normal: stuck[2],
                },
            ));
        }
        std::mem::swap(&mut self.kept, &mut scratch.kept);
    }
}

impl Copied {
    fn copy(&mut self, index: MultibodyIndex, multibody: &Multibody, bodies: &RigidBodySet) {
        self.index = index;
        self.velocity.clear();
        self.velocity.extend(multibody.generalized_velocity().iter());
        self.poses.clear();
        self.centers_of_mass.clear();
        for (number, link) in multibody.links().enumerate() {
            let pose = *link.local_to_world();
            let mass = &bodies[link.rigid_body_handle()].mass_properties().local_mprops;
            self.poses.push(pose);
            self.centers_of_mass.push(pose.transform_point(mass.local_com));
            let jacobian = multibody.body_jacobian(number);
            match self.jacobians.get_mut(number) {
                Some(own) if own.ncols() == jacobian.ncols() => own.copy_from(jacobian),
                Some(own) => *own = jacobian.clone(),
                None => self.jacobians.push(jacobian.clone()),
            }
        }
    }

    /// Linear velocity at `point_world` and angular velocity of a link, world frame, for each generalized velocity.
    fn motion_of(&self, link: usize, point_world: DVec3) -> impl Iterator<Item = [DVec3; 2]> + '_ {
        let arm = point_world - self.centers_of_mass[link];
        self.jacobians[link].column_iter().map(move |column| {
            let linear = DVec3::new(column[0], column[1], column[2]);
            let angular = DVec3::new(column[3], column[4], column[5]);
            [linear + angular.cross(arm), angular]
        })
    }
}

impl Candidate {
    /// The six speeds of one side for each generalized velocity.
    fn columns<'a>(&'a self, copied: &'a Copied, link: usize, sign: f64) -> impl Iterator<Item = [f64; ROWS]> + 'a {
        let plane = &self.plane;
        let [first, second] = plane.tangents_world;
        let normal = plane.normal_world;
        let to_center = in_plane(&plane.tangents_world, self.center.x, self.center.y);
        copied
            .motion_of(link, plane.origin_world)
            .map(move |[linear, angular]| {
                let at_center = linear + angular.cross(to_center);
                [
                    sign * linear.dot(normal),
                    sign * angular.dot(first),
                    sign * angular.dot(second),
                    sign * at_center.dot(first),
                    sign * at_center.dot(second),
                    sign * self.radius_m * angular.dot(normal),
                ]
            })
    }
}

/// The tangent plane of a contact, in the middle of the engine's points.
fn place(pair: &Pair, manifold: &ContactManifold, kept_normal: Option<DVec3>) -> Plane {
    // The engine's normal points from the first shape to the second.
    let found = -manifold.data.normal;
    let deepest = manifold
        .points
        .iter()
        .map(|point| point.dist)
        .fold(f64::INFINITY, f64::min);
    // The middle of the points, of which those that are deep count: the shapes overlap there if they overlap at all.
    let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
    for point in &manifold.points {
        let weight = (1e-3 - (point.dist - deepest)).max(0.0);
        let [first, second] = pair.poses_world;
        let middle = 0.5 * (first.transform_point(point.local_p1) + second.transform_point(point.local_p2));
        sum += middle * weight;
        weights += weight;
    }
    let origin = sum / weights;
    if let Some(kept) = kept_normal
        && kept.dot(found) < FLIPPED_COSINE
    {
        let plane = pair.plane(origin, kept);
        if pair
            .overlap_m(&plane)
            .is_some_and(|overlap| 0.0 < overlap && overlap < MAX_KEPT_OVERLAP_M)
        {
            return plane;
        }
    }
    pair.plane(origin, found)
}

/// A normal that changes by more than 120° in a step has flipped: the shapes overlap by more than half of the thinner one, and
/// the shortest way out is now on the other side. The shapes are then held to the side from which they met.
const FLIPPED_COSINE: f64 = -0.5;

/// A normal is not kept where the overlap along it is larger, m: three times the thickness of a soft skin.
const MAX_KEPT_OVERLAP_M: f64 = 0.01;

fn key(colliders: &[ColliderHandle; 2]) -> PairKey {
    colliders.map(ColliderHandle::into_raw_parts)
}

/// The link of a copied body that carries a collider; `None` for one that cannot move.
fn link_of(collider: &Collider, copies: &[Copied], parts: &Parts) -> Option<LinkOf> {
    let link = parts.joints.rigid_body_link(collider.parent()?)?;
    let body = copies.iter().position(|copied| copied.index == link.multibody)?;
    (link.id > 0).then_some(LinkOf { body, link: link.id })
}

/// The pose of a collider's body when the step began, world frame.
fn body_pose(collider: &Collider, link: Option<LinkOf>, copies: &[Copied], parts: &Parts) -> Option<WorldPose> {
    Some(match link {
        Some(LinkOf { body, link }) => from_parry(&copies[body].poses[link]),
        None => from_parry(parts.bodies[collider.parent()?].position()),
    })
}

/// The parting speed at the origin of a plane and the angular velocities about its tangents.
fn relative_speeds(
    plane: &Plane,
    links: [Option<LinkOf>; 2],
    copies: &[Copied],
    velocity: impl Fn(usize, usize) -> f64,
) -> NormalSpeeds {
    let (mut linear, mut angular) = (DVec3::ZERO, DVec3::ZERO);
    for (link, sign) in links.iter().zip([1.0, -1.0]) {
        let Some(LinkOf { body, link }) = link else { continue };
        let motion = copies[*body].motion_of(*link, plane.origin_world);
        for (index, [at_point, about]) in motion.enumerate() {
            let speed = sign * velocity(*body, index);
            linear += at_point * speed;
            angular += about * speed;
        }
    }
    Vector3::new(
        linear.dot(plane.normal_world),
        angular.dot(plane.tangents_world[0]),
        angular.dot(plane.tangents_world[1]),
    )
}

fn body_of_joint(joint: MultibodyJointHandle, copies: &[Copied], parts: &Parts) -> Option<usize> {
    let (multibody, _) = parts.joints.get(joint)?;
    let root = multibody.root().rigid_body_handle();
    let index = parts.joints.rigid_body_link(root)?.multibody;
    copies.iter().position(|copied| copied.index == index)
}

/// Whether a joint may reach its stop within this step.
fn is_near(stop: &JointStop, parts: &Parts) -> bool {
    let Some((multibody, link)) = parts.joints.get(stop.joint) else {
        return false;
    };
    let Some(link) = multibody.link(link) else { return false };
    let angle = link.joint.coords()[stop.axis];
    angle < stop.limits_rad[0] + NEAR_STOP_RAD || angle > stop.limits_rad[1] - NEAR_STOP_RAD
}

/// A joint this close to a limit may reach it within a step of 10 ms, at 5 rad/s, rad.
const NEAR_STOP_RAD: f64 = 0.05;

/// M = P⁻¹ L U, from the factors that the engine keeps.
fn mass_matrix(multibody: &Multibody, mass: &mut DMatrix<f64>) {
    let factors = multibody.inv_augmented_mass();
    let packed = factors.lu_internal();
    let size = multibody.ndofs();
    if mass.nrows() != size {
        *mass = DMatrix::zeros(size, size);
    }
    for column in 0..size {
        for row in 0..size {
            // L has ones on its diagonal.
            let mut sum = if row <= column { packed[(row, column)] } else { 0.0 };
            for inner in 0..row.min(column + 1) {
                sum += packed[(row, inner)] * packed[(inner, column)];
            }
            mass[(row, column)] = sum;
        }
    }
    factors.p().inv_permute_rows(mass);
}
