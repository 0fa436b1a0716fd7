//! Finds the patches that may press in a step, among the pairs of shapes that are near each other.

use glam::{DVec2, DVec3};
use nalgebra::Vector3;
use rapier3d::prelude::ColliderHandle;
use underbrush_recording::Pose as WorldPose;

use super::{ContactStep, Kept, KeptPatch, PairKey, key};
use crate::contact::chord::Faces;
use crate::contact::law::{Law, NormalSpeeds};
use crate::contact::patch::Node;
use crate::contact::plane::{DepthSearch, Pair, Plane};
use crate::contact::settle::{KnownContact, settle};
use crate::contact::solver::ROWS;
use crate::dynamics::Tree;
use crate::simulation::mount::Mount;
use crate::simulation::placed::{PlacedLink, Scene};

/// A patch before the solution.
#[derive(Clone)]
pub(super) struct Candidate {
    pub(super) colliders: [ColliderHandle; 2],
    pub(super) bodies: PairKey,
    pub(super) links: [Option<PlacedLink>; 2],
    pub(super) body_poses: [WorldPose; 2],
    pub(super) plane: Plane,
    /// Where the next step begins to look for it.
    pub(super) next: KnownContact,
    pub(super) law: Law,
    pub(super) nodes: (usize, usize),
    pub(super) center: DVec2,
    pub(super) radius_m: f64,
    pub(super) deflection: Vector3<f64>,
}

/// Two shapes that are near each other, of which at least one can move, as they lie when the step begins.
pub(super) struct Meeting<'a> {
    scene: &'a Scene,
    colliders: [ColliderHandle; 2],
    bodies: PairKey,
    /// `None` for a link that cannot move.
    links: [Option<PlacedLink>; 2],
    body_poses: [WorldPose; 2],
    pub(super) pair: Pair<'a>,
    /// See [`Mount::near_m`].
    near_m: f64,
    law: Law,
}

impl<'a> Meeting<'a> {
    pub(super) fn new(scene: &'a Scene, colliders: [ColliderHandle; 2], mounts: [&Mount; 2], step_s: f64) -> Self {
        let links = mounts.map(|mount| mount.moves.then_some(mount.at));
        Meeting {
            scene,
            colliders,
            bodies: mounts.map(|Mount { at, .. }| scene.placed(at.slot).bodies[at.link].into_raw_parts()),
            links,
            body_poses: mounts.map(|mount| *scene.link_pose(mount.at)),
            pair: Pair {
                shapes: colliders.map(|collider| scene.shape(collider)),
                poses_world: mounts.map(|mount| mount.pose_world),
            },
            near_m: mounts[0].near_m(mounts[1]),
            law: Law { interface: mounts[0].surface.with(&mounts[1].surface), step_s, theta: scene.theta(&links) },
        }
    }

    /// The overlap beyond which a column may press along a normal in this step, m, where the shapes move as `motions` says and the
    /// overlap is `overlap_m`.
    pub(super) fn closing_m(&self, [before, ahead, free]: &Motions, normal_world: DVec3, overlap_m: f64) -> f64 {
        let closing_m =
            |[linear, _]: &[DVec3; 2]| self.law.closing_m(linear.dot(normal_world)) - ahead[0].dot(normal_world);
        // The speed of surfaces that stay in contact hardly changes. Surfaces that are about to meet may be accelerated
        // in this step, so their speed in it without contacts counts, too.
        let over_m = closing_m(before);
        if overlap_m > over_m { over_m } else { closing_m(free) }
    }

    /// How the shapes move at a point.
    #[inline(always)]
    pub(super) fn motions(&self, point_world: DVec3) -> Motions {
        let mut motions = Motions::default();
        for (link, sign) in self.links.iter().zip([1.0, -1.0]) {
            let Some(PlacedLink { slot, link }) = *link else { continue };
            let tree = self.scene.tree(slot);
            let own = tree.velocities_at(link, point_world, |at| {
                let velocity = tree.coordinates[at].velocity;
                [velocity, tree.ahead_s() * velocity, tree.next()[at]]
            });
            for ([linear, angular], own) in motions.iter_mut().zip(own) {
                *linear += own[0] * sign;
                *angular += own[1] * sign;
            }
        }
        motions
    }
}

/// How the first shape moves relative to the second at a point, world frame, each as a linear and an angular part: its velocity when
/// the step begins, m/s and rad/s; how far trees have moved ahead since then, m and rad; and its velocity if nothing touches.
type Motions = [[DVec3; 2]; 3];

/// Along the normal at the origin of a plane, and about its tangents.
fn speeds(plane: &Plane, [linear, angular]: [DVec3; 2]) -> NormalSpeeds {
    let [first, second] = plane.tangents_world;
    Vector3::new(linear.dot(plane.normal_world), angular.dot(first), angular.dot(second))
}

/// What a step finds out about a pair of shapes.
#[expect(clippy::large_enum_variant, reason = "one lives at a time")]
pub(super) enum Found {
    /// They may press on each other.
    Patch(Candidate),
    /// They do not: this unit direction from the second to the first, world frame, separates them.
    Apart(DVec3),
    /// Neither was found.
    Nothing,
}

impl ContactStep {
    /// The patch of a pair of shapes, if it may press. A contact of the last step is followed; any other pair is searched
    /// for its nearest points.
    pub(super) fn find(
        &self,
        meeting: &Meeting,
        nodes: &mut Vec<Node>,
        faces: &mut [Faces; 2],
        depth_search: &mut DepthSearch,
    ) -> Found {
        let body_pose = &meeting.body_poses[1];
        let mut apart_before = None;
        let deepest_m = |nodes: &[Node]| nodes.iter().map(|node| node.overlap_m).fold(0.0, f64::max);
        let kept = self.kept(&key(&meeting.colliders));
        if let Some(kept) = kept {
            let normal_world = body_pose.transform_vector(kept.normal);
            if meeting.are_apart(normal_world) {
                return Found::Apart(normal_world);
            }
            if let Some(patch) = &kept.patch {
                let origin_world = body_pose.transform_point(patch.origin);
                let region = Some((patch.outline, body_pose.transform_vector(patch.strip)));
                let known = KnownContact { origin_world, normal_world, region };
                let first_node = nodes.len();
                if let Some(candidate) = meeting.candidate(&known, Some(patch), nodes, faces)
                    && deepest_m(&nodes[first_node..]) < MAX_KEPT_OVERLAP_M
                {
                    return Found::Patch(candidate);
                }
                nodes.truncate(first_node);
            } else {
                apart_before = Some(normal_world);
            }
        }
        let nearest = meeting.pair.nearest(meeting.near_m, depth_search);
        let Some((nearest_world, middle_world)) = nearest else { return Found::Nothing };
        let sibling = self.sibling(&meeting.bodies).map(|kept| body_pose.transform_vector(kept.normal));
        let mut known = apart_before.into_iter().chain(sibling);
        let flipped = known.find(|known| known.dot(nearest_world) < FLIPPED_COSINE);
        if flipped.is_none() && meeting.are_apart(nearest_world) {
            return Found::Apart(nearest_world);
        }
        let Some(origin_world) = middle_world else { return Found::Nothing };
        let patch = kept.and_then(|kept| kept.patch.as_ref());
        let first_node = nodes.len();
        for normal_world in flipped.into_iter().chain([nearest_world]) {
            let known = KnownContact { origin_world, normal_world, region: None };
            if let Some(candidate) = meeting.candidate(&known, patch, nodes, faces) {
                if flipped != Some(normal_world)
                    || flipped == apart_before
                    || deepest_m(&nodes[first_node..]) < MAX_KEPT_OVERLAP_M
                {
                    return Found::Patch(candidate);
                }
                nodes.truncate(first_node);
            }
        }
        Found::Nothing
    }
}

impl Meeting<'_> {
    /// What is kept of a pair that a direction separates.
    pub(super) fn kept_apart(&self, normal_world: DVec3) -> Kept {
        Kept { bodies: self.bodies, normal: self.body_poses[1].inverse_transform_vector(normal_world), patch: None }
    }

    /// Whether no column along this direction can press in this step.
    fn are_apart(&self, normal_world: DVec3) -> bool {
        let farthest = |side, direction_world| self.pair.farthest(side, direction_world);
        let Some((lowest, highest)) = farthest(0, -normal_world).zip(farthest(1, normal_world)) else { return false };
        let gap_m = (lowest - highest).dot(normal_world);
        let stays_apart = |point| -gap_m <= self.closing_m(&self.motions(point), normal_world, -gap_m);
        gap_m > 0.0 && [lowest, highest].into_iter().all(stays_apart)
    }

    /// The patch of a contact that is roughly known, if it may press.
    fn candidate(
        &self,
        known: &KnownContact,
        kept: Option<&KeptPatch>,
        nodes: &mut Vec<Node>,
        faces: &mut [Faces; 2],
    ) -> Option<Candidate> {
        let &Meeting { colliders, bodies, links, body_poses, ref pair, law, .. } = self;
        let first_node = nodes.len();
        let mut before = NormalSpeeds::zeros();
        let (plane, next) = settle(
            pair,
            known,
            faces,
            |plane, overlap_m| {
                let motions = self.motions(plane.origin_world);
                before = speeds(plane, motions[0]);
                self.closing_m(&motions, plane.normal_world, overlap_m)
            },
            nodes,
        )?;
        // How far the surfaces have parted since the step began, m, and turned, rad: trees move ahead before contacts
        // are found.
        let parted_m = speeds(&plane, self.motions(plane.origin_world)[1]);
        for node in &mut nodes[first_node..] {
            node.overlap_m += node.parting(&parted_m);
        }
        let (center, radius_m) = law.center_and_radius(&nodes[first_node..], &before);
        let deflection = kept.map_or(Vector3::zeros(), |kept| {
            let deflection_world = body_poses[1].transform_vector(kept.deflection);
            let [first, second] = plane.tangents_world.map(|tangent| deflection_world.dot(tangent));
            Vector3::new(first, second, kept.deflection_about_normal)
        });
        let nodes = (first_node, nodes.len());
        Some(Candidate { colliders, bodies, links, body_poses, plane, next, law, nodes, center, radius_m, deflection })
    }
}

impl Candidate {
    /// Writes the six speeds of one side for each unknown of its tree, whose columns `places` gives. The columns of unknowns
    /// that do not move the link stay as they are.
    pub(super) fn fill_columns(
        &self,
        tree: &Tree,
        link: usize,
        sign: f64,
        places: &[Option<usize>],
        columns: &mut [[f64; ROWS]],
    ) {
        let plane = &self.plane;
        let [first, second] = plane.tangents_world;
        let normal = plane.normal_world;
        let to_center = plane.vector_world(self.center.x, self.center.y);
        for (at, [linear, angular]) in tree.motions(link, plane.origin_world) {
            let Some(place) = places[at] else { continue };
            let at_center = linear + angular.cross(to_center);
            columns[place] = [
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

/// A normal that changes by more than 120° in a step has flipped: the shapes overlap by more than half the thickness of
/// the thinner one, and the shortest way out is now on the other side. The shapes are then held to the side from which
/// they met.
const FLIPPED_COSINE: f64 = -0.5;

/// A normal is not kept if the overlap along it is larger than this, m: three times the thickness of a soft skin.
const MAX_KEPT_OVERLAP_M: f64 = 0.01;
