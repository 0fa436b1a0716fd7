//! Finds the patches that may press in a step, among the pairs of shapes that are near each other.

use glam::{DVec2, DVec3};
use nalgebra::Vector3;
use rapier3d::parry::query::{ContactManifold, DefaultQueryDispatcher, PersistentQueryDispatcher};
use rapier3d::prelude::ColliderHandle;
use underbrush_recording::Pose as WorldPose;

use super::{ContactStep, PairKey, key};
use crate::contact::chord::Faces;
use crate::contact::law::{Law, NormalSpeeds, in_plane};
use crate::contact::patch::{Columns, Node};
use crate::contact::plane::{Pair, Plane};
use crate::contact::solver::ROWS;
use crate::dynamics::Tree;
use crate::geometry::parry_pose;
use crate::simulation::placed::{Mount, NEAR_M, PlacedLink, Scene};

/// A patch before the solution.
#[derive(Clone)]
pub(super) struct Candidate {
    pub(super) colliders: [ColliderHandle; 2],
    pub(super) bodies: PairKey,
    pub(super) links: [Option<PlacedLink>; 2],
    pub(super) body_poses: [WorldPose; 2],
    pub(super) plane: Plane,
    pub(super) law: Law,
    pub(super) nodes: (usize, usize),
    pub(super) center: DVec2,
    pub(super) radius_m: f64,
    pub(super) deflection: Vector3<f64>,
}

/// Buffers of one pair's detection.
#[derive(Clone)]
pub(super) struct Detection {
    manifold: ContactManifold<(), ()>,
    pub(super) faces: [Faces; 2],
}

impl Default for Detection {
    fn default() -> Self {
        Detection { manifold: ContactManifold::new(), faces: [Faces::default(), Faces::default()] }
    }
}

impl Detection {
    /// Finds the points where two shapes are nearest or overlap most, and returns whether there are any. Nothing of an
    /// earlier manifold is used.
    fn find(&mut self, pair: &Pair, near_m: f64) -> bool {
        let [first, second] = pair.poses_world.each_ref().map(parry_pose);
        self.manifold.clear();
        (self.manifold.local_n1, self.manifold.local_n2) = (DVec3::ZERO, DVec3::ZERO);
        let found = DefaultQueryDispatcher.contact_manifold_convex_convex(
            &first.inv_mul(&second),
            pair.shapes[0],
            pair.shapes[1],
            None,
            None,
            near_m,
            &mut self.manifold,
        );
        found.is_ok() && !self.manifold.points.is_empty()
    }
}

/// Two shapes that are near each other, of which at least one can move, as they lie when the step begins.
pub(super) struct Meeting<'a> {
    scene: &'a Scene,
    handles: [ColliderHandle; 2],
    bodies: PairKey,
    /// `None` for a link that cannot move.
    links: [Option<PlacedLink>; 2],
    body_poses: [WorldPose; 2],
    pub(super) pair: Pair<'a>,
    law: Law,
}

impl<'a> Meeting<'a> {
    pub(super) fn new(scene: &'a Scene, handles: [ColliderHandle; 2], mounts: [&Mount; 2], step_s: f64) -> Self {
        let links = mounts.map(|mount| mount.moves.then_some(mount.at));
        Meeting {
            scene,
            handles,
            bodies: handles.map(|handle| scene.body_of(handle).into_raw_parts()),
            links,
            body_poses: mounts.map(|mount| *scene.link_pose(mount.at)),
            pair: Pair {
                shapes: handles.map(|handle| scene.shape(handle)),
                poses_world: mounts.map(|mount| mount.pose_world),
            },
            law: Law { interface: mounts[0].surface.with(&mounts[1].surface), step_s, theta: scene.theta(&links) },
        }
    }

    /// The overlap beyond which a column at the origin of the plane may press in this step, m, if the overlap there is
    /// `overlap_m`; and the parting speed when the step begins.
    pub(super) fn closing_m(&self, plane: &Plane, overlap_m: f64) -> (f64, NormalSpeeds) {
        let before = self.speeds(plane, |tree, at| tree.coordinates()[at].velocity);
        let ahead_m = self.parted_m(plane)[0];
        // The speed of surfaces that stay in contact hardly changes. Surfaces that are about to meet may be accelerated
        // in this step, so their speed in it without contacts counts, too.
        let over_m = self.law.closing_m(before[0]) - ahead_m;
        if overlap_m > over_m {
            return (over_m, before);
        }
        let free = self.speeds(plane, |tree, at| tree.next()[at]);
        (self.law.closing_m(free[0]) - ahead_m, before)
    }

    /// How far the surfaces have parted at the origin of a plane since the step began, m, and turned, rad: trees move ahead
    /// before contacts are found.
    fn parted_m(&self, plane: &Plane) -> Vector3<f64> {
        self.speeds(plane, |tree, at| tree.ahead_s() * tree.coordinates()[at].velocity)
    }

    /// The parting speed at the origin of a plane and the angular velocities about its tangents.
    fn speeds(&self, plane: &Plane, velocity: impl Fn(&Tree, usize) -> f64) -> NormalSpeeds {
        let (mut linear, mut angular) = (DVec3::ZERO, DVec3::ZERO);
        for (link, sign) in self.links.iter().zip([1.0, -1.0]) {
            let Some(PlacedLink { slot, link }) = *link else { continue };
            let tree = &self.scene.placed(slot).tree;
            let [at_point, about] = tree.velocity_at(link, plane.origin_world, |at| velocity(tree, at));
            linear += at_point * sign;
            angular += about * sign;
        }
        Vector3::new(
            linear.dot(plane.normal_world),
            angular.dot(plane.tangents_world[0]),
            angular.dot(plane.tangents_world[1]),
        )
    }
}

impl ContactStep {
    /// The patch of a pair of shapes, if it may press.
    pub(super) fn candidate(
        &self,
        meeting: &Meeting,
        nodes: &mut Vec<Node>,
        detection: &mut Detection,
    ) -> Option<Candidate> {
        let &Meeting { handles, bodies, links, body_poses, ref pair, law, .. } = meeting;
        if !detection.find(pair, NEAR_M) {
            return None;
        }
        let Detection { manifold, faces } = detection;
        let kept = self.kept(&key(&handles));
        let known = kept.or_else(|| self.sibling(&bodies));
        let known_normal = known.map(|kept| body_poses[1].transform_vector(kept.normal));
        let mut plane = place(pair, manifold, known_normal, faces);
        let first_node = nodes.len();
        let mut press = |plane: &Plane, faces: &mut [Faces; 2]| {
            let columns = Columns::new(pair, plane, faces)?;
            let (over_m, before) = meeting.closing_m(plane, columns.overlap_m(DVec2::ZERO)?);
            columns.add_nodes(over_m, nodes);
            (nodes.len() > first_node).then_some(before)
        };
        let before = match press(&plane, faces) {
            Some(before) => before,
            // The manifold's points may lie beside the region in which the shapes overlap.
            None => {
                plane = meeting.common(plane.normal_world, faces)?.0;
                press(&plane, faces)?
            }
        };
        let parted_m = meeting.parted_m(&plane);
        for node in &mut nodes[first_node..] {
            node.overlap_m += node.parting(&parted_m);
        }
        let (center, radius_m) = law.center_and_radius(&nodes[first_node..], &before);
        let deflection = kept.map_or(Vector3::zeros(), |kept| {
            let deflection_world = body_poses[1].transform_vector(kept.deflection);
            Vector3::new(
                deflection_world.dot(plane.tangents_world[0]),
                deflection_world.dot(plane.tangents_world[1]),
                kept.deflection_about_normal,
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
            deflection,
        })
    }
}

impl Candidate {
    /// Writes the six speeds of one side for each generalized velocity. The columns of velocities that do not move the link
    /// stay as they are.
    pub(super) fn fill_columns(&self, tree: &Tree, link: usize, sign: f64, columns: &mut [[f64; ROWS]]) {
        let plane = &self.plane;
        let [first, second] = plane.tangents_world;
        let normal = plane.normal_world;
        let to_center = in_plane(&plane.tangents_world, self.center.x, self.center.y);
        for (at, [linear, angular]) in tree.motions(link, plane.origin_world) {
            let at_center = linear + angular.cross(to_center);
            columns[at] = [
                sign * linear.dot(normal),
                sign * angular.dot(first),
                sign * angular.dot(second),
                sign * at_center.dot(first),
                sign * at_center.dot(second),
                sign * self.radius_m * angular.dot(normal),
            ];
        }
    }
}

/// The tangent plane of a contact, in the middle of the manifold's points.
fn place(pair: &Pair, manifold: &ContactManifold<(), ()>, kept_normal: Option<DVec3>, faces: &mut [Faces; 2]) -> Plane {
    // The manifold's normal points from the first shape to the second.
    let found = -pair.poses_world[0].transform_vector(manifold.local_n1);
    let deepest = manifold.points.iter().map(|point| point.dist).fold(f64::INFINITY, f64::min);
    // The mean of the near-deepest points. It is inside the overlap whenever there is one.
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
        let overlap_m = Columns::new(pair, &plane, faces).and_then(|columns| columns.overlap_m(DVec2::ZERO));
        if overlap_m.is_some_and(|overlap| 0.0 < overlap && overlap < MAX_KEPT_OVERLAP_M) {
            return plane;
        }
    }
    let plane = pair.plane(origin, found);
    let mut presses = |plane: &Plane| {
        let overlap_m = Columns::new(pair, plane, faces).and_then(|columns| columns.overlap_m(DVec2::ZERO));
        overlap_m.is_some_and(|overlap| overlap > 0.0)
    };
    if deepest >= 0.0 || presses(&plane) {
        return plane;
    }
    // On a round face the manifold has only the corners of an inscribed square, so the deepest point of a tilted face
    // may be somewhere else.
    let deepest_points = [0, 1].into_iter().filter_map(|side| {
        let towards_other = if side == 0 { -found } else { found };
        let shape = pair.shapes[side].as_support_map()?;
        Some(shape.support_point(&parry_pose(&pair.poses_world[side]), towards_other))
    });
    let mut planes = deepest_points.map(|point| pair.plane(point, found));
    planes.find(presses).unwrap_or(plane)
}

/// A normal that changes by more than 120° in a step has flipped: the shapes overlap by more than half the thickness of
/// the thinner one, and the shortest way out is now on the other side. The shapes are then held to the side from which
/// they met.
const FLIPPED_COSINE: f64 = -0.5;

/// A normal is not kept if the overlap along it is larger than this, m: three times the thickness of a soft skin.
const MAX_KEPT_OVERLAP_M: f64 = 0.01;
