//! The Rapier scene: bodies, shapes, collision groups and the broad phase. Each body is a link of a joint tree.
//!
//! The bodies are fixed or kinematic. [`crate::dynamics`] moves the trees, which have the poses: only the boxes of the shapes are told to
//! the broad phase. The scene finds the pairs of shapes that may
//! come near each other as long as no shape moves farther than a certain distance, its room. As soon as one has moved
//! farther, or will do so in this step, the pairs are found anew. So no pair is missed, however fast the shapes are.

use std::collections::BTreeSet;

use glam::{DMat3, DVec3};
use rapier3d::geometry::{BroadPhasePairEvent, ColliderPair};
use rapier3d::prelude::*;
use serde::{Deserialize, Serialize};
use underbrush_recording::Pose as WorldPose;

pub(super) use super::mount::PlacedLink;
use super::mount::{FOAM, Mount, NEAR_M, ROOM_M, ROOTED, excess_m, gaps_m, object_groups};
use crate::contact::surface::Surface;
use crate::dynamics::{Link, Tree};
use crate::geometry::{from_parry, parry_pose};
use crate::object::structure::CollisionGroup;
use crate::physics::Theta;

/// A shape to be added.
pub struct Solid {
    /// The link that carries it.
    pub link: usize,
    /// The shape, in its place on the link.
    pub shape: ColliderBuilder,
    /// What it collides with.
    pub groups: InteractionGroups,
    /// Its surface.
    pub surface: Surface,
    /// The part of the tree that it belongs to. Shapes of one part do not meet, and those in the group of roots do not meet
    /// part 0, which carries the others.
    pub part: u16,
}

/// A tree, and the bodies of its links.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Placed {
    /// The tree.
    pub tree: Tree,
    /// One for each link.
    pub bodies: Vec<RigidBodyHandle>,
}

/// The pairs of shapes whose boxes Rapier's broad phase has found to overlap. They are no part of a saved state, because what is
/// made of them does not depend on their past.
#[derive(Clone, Default)]
struct Finder {
    broad_phase: BroadPhaseBvh,
    boxed: BTreeSet<[(u32, u32); 2]>,
    /// Shapes that the broad phase has to forget, because they were removed or because they now meet others.
    forgotten: Vec<ColliderHandle>,
}

impl Finder {
    /// Finds the pairs, given a box for each shape.
    fn find(
        &mut self,
        bodies: &RigidBodySet,
        colliders: &ColliderSet,
        boxes: impl Iterator<Item = (ColliderHandle, Aabb)>,
    ) {
        let Finder { broad_phase, boxed, forgotten } = self;
        let (options, mut events) = (IntegrationParameters::default(), Vec::new());
        if !forgotten.is_empty() {
            // This comes first, because new shapes may have their indices.
            broad_phase.update(&options, colliders, bodies, &[], forgotten, &mut events);
            let is_forgotten = |shape| forgotten.iter().any(|own| own.into_raw_parts() == shape);
            boxed.retain(|pair| !pair.iter().any(|shape| is_forgotten(*shape)));
            forgotten.clear();
        }
        for (collider, bounds) in boxes {
            broad_phase.set_aabb(&options, collider, bounds);
        }
        broad_phase.update(&options, colliders, bodies, &[], &[], &mut events);
        let raw = |pair: ColliderPair| [pair.collider1, pair.collider2].map(ColliderHandle::into_raw_parts);
        for event in events {
            match event {
                BroadPhasePairEvent::AddPair(pair) => boxed.insert(raw(pair)),
                BroadPhasePairEvent::DeletePair(pair) => boxed.remove(&raw(pair)),
            };
        }
    }
}

/// Trees, shapes, and the pairs of shapes that are near each other.
#[derive(Clone, Default, Serialize, Deserialize)]
pub(super) struct Scene {
    bodies: RigidBodySet,
    colliders: ColliderSet,
    #[serde(skip)]
    finder: Finder,
    placed: Vec<Option<Placed>>,
    /// Indexed by the index in the collider's handle.
    mounts: Vec<Option<Mount>>,
    /// Pairs of kinds that pass through each other, in either order.
    pub(super) passing: Vec<[Option<usize>; 2]>,
    /// Pairs of links of one tree that pass through each other, in either order.
    pub(super) passing_links: Vec<[PlacedLink; 2]>,
    /// The pairs of shapes that may collide, sorted. At least one shape of each can move.
    pairs: Vec<[ColliderHandle; 2]>,
    /// Whether shapes were added or removed since the pairs were found.
    is_changed: bool,
}

/// The extent of a shape along the axes of the world, m.
fn extent(shape: &dyn Shape, mount: &Mount) -> [DVec3; 2] {
    let extent = shape.compute_aabb(&parry_pose(&mount.pose_world));
    [extent.mins, extent.maxs]
}

/// Whether these two are a pair, in either order.
fn is_pair<T: PartialEq>([one, other]: &[T; 2], two: [T; 2]) -> bool {
    [&two[0], &two[1]] == [one, other] || [&two[1], &two[0]] == [one, other]
}

fn index(collider: ColliderHandle) -> usize {
    collider.into_raw_parts().0 as usize
}

/// Writes the poses of links into `poses`, world frame.
pub(super) fn read_poses(links: &[Link], poses: &mut Vec<WorldPose>) {
    poses.clear();
    poses.extend(links.iter().map(|link| link.pose_world));
}

impl Scene {
    pub(super) fn insert(&mut self, tree: Tree, solids: Vec<Solid>) -> usize {
        let free = self.placed.iter().position(Option::is_none);
        let slot = free.unwrap_or_else(|| {
            self.placed.push(None);
            self.placed.len() - 1
        });
        let bodies = tree.links().iter().enumerate().map(|(link, own)| {
            let kind = if tree.moves(link) { RigidBodyType::KinematicPositionBased } else { RigidBodyType::Fixed };
            self.bodies.insert(RigidBodyBuilder::new(kind).pose(parry_pose(&own.pose_world)).can_sleep(false))
        });
        let bodies: Vec<RigidBodyHandle> = bodies.collect();
        let types = ActiveCollisionTypes::KINEMATIC_KINEMATIC | ActiveCollisionTypes::KINEMATIC_FIXED;
        for Solid { link, shape, groups, surface, part } in solids {
            let shape = shape.density(0.0).collision_groups(groups).active_collision_types(types);
            let collider = self.colliders.insert_with_parent(shape, bodies[link], &mut self.bodies);
            let inserted = &self.colliders[collider];
            let mut mount = Mount {
                at: PlacedLink { slot, link },
                surface,
                part,
                kind: None,
                is_root: groups.memberships == ROOTED,
                is_foam: groups.memberships == FOAM,
                built_extent: [DVec3::ZERO; 2],
                moves: tree.moves(link),
                pose_link: inserted.position_wrt_parent().map_or(WorldPose::IDENTITY, from_parry),
                bounds: inserted.shape().compute_local_aabb(),
                found_center: DVec3::ZERO,
                found_axes: DMat3::IDENTITY,
                found_extent: [DVec3::ZERO; 2],
                way_m: 0.0,
                found_way_m: 0.0,
                pose_world: WorldPose::IDENTITY,
                axes_world: DMat3::IDENTITY,
            };
            mount.place(&tree.links()[link].pose_world);
            mount.built_extent = extent(inserted.shape(), &mount);
            let index = index(collider);
            if self.mounts.len() <= index {
                self.mounts.resize(index + 1, None);
            }
            self.mounts[index] = Some(mount);
        }
        self.placed[slot] = Some(Placed { tree, bodies });
        self.is_changed = true;
        slot
    }

    /// Names the kind of each link of a tree.
    pub(super) fn name_kinds(&mut self, slot: usize, kind: impl Fn(usize) -> Option<usize>) {
        for mount in self.mounts.iter_mut().flatten().filter(|mount| mount.at.slot == slot) {
            mount.kind = kind(mount.at.link);
        }
    }

    pub(super) fn remove(&mut self, slot: usize) {
        let Some(placed) = self.placed[slot].take() else { return };
        for body in placed.bodies {
            for collider in self.bodies[body].colliders() {
                self.mounts[index(*collider)] = None;
                self.finder.forgotten.push(*collider);
            }
            self.bodies.remove(
                body,
                &mut IslandManager::new(),
                &mut self.colliders,
                &mut ImpulseJointSet::new(),
                &mut MultibodyJointSet::new(),
                &mut SoftBodySet::new(),
                true,
            );
        }
        self.is_changed = true;
    }

    /// A tree with the bodies of its links.
    ///
    /// # Panics
    /// If the slot is empty.
    pub(super) fn placed(&self, slot: usize) -> &Placed {
        self.placed[slot].as_ref().expect("the slots that are handed out are taken")
    }

    /// A tree.
    ///
    /// # Panics
    /// If the slot is empty.
    pub(super) fn tree(&self, slot: usize) -> &Tree {
        &self.placed(slot).tree
    }

    /// A tree, to change it.
    ///
    /// # Panics
    /// If the slot is empty.
    pub(super) fn tree_mut(&mut self, slot: usize) -> &mut Tree {
        &mut self.placed[slot].as_mut().expect("the slots that are handed out are taken").tree
    }

    /// The trees by slot; `None` for an empty slot.
    pub(super) fn slots(&self) -> &[Option<Placed>] {
        &self.placed
    }

    /// The trees that can move.
    pub(super) fn trees_mut(&mut self) -> impl Iterator<Item = &mut Tree> {
        self.placed.iter_mut().flatten().map(|placed| &mut placed.tree).filter(|tree| !tree.coordinates.is_empty())
    }

    /// Lets roots slide, and what hangs on those that come out collide with everything.
    pub(super) fn pull_roots(&mut self) {
        for (slot, placed) in self.placed.iter_mut().enumerate() {
            let Some(Placed { tree, .. }) = placed else { continue };
            while let Some(root) = tree.pull_roots() {
                for (handle, collider) in self.colliders.iter_mut() {
                    let mount = self.mounts[index(handle)].as_mut().filter(|mount| mount.at.slot == slot);
                    if let Some(mount) = mount.filter(|mount| tree.is_carried_by(mount.at.link, root)) {
                        collider.set_collision_groups(object_groups(CollisionGroup::Standing));
                        mount.is_root = false;
                        self.finder.forgotten.push(handle);
                    }
                }
                self.is_changed = true;
            }
        }
    }

    /// Where a shape is.
    ///
    /// # Panics
    /// If it was removed.
    pub(super) fn mount(&self, collider: ColliderHandle) -> &Mount {
        self.mounts[index(collider)].as_ref().expect("a shape has a mount until it is removed")
    }

    pub(super) fn shape(&self, collider: ColliderHandle) -> &dyn Shape {
        self.colliders[collider].shape()
    }

    pub(super) fn groups(&self, collider: ColliderHandle) -> InteractionGroups {
        self.colliders[collider].collision_groups()
    }

    /// The shapes of a body.
    pub(super) fn colliders_of(&self, body: RigidBodyHandle) -> &[ColliderHandle] {
        self.bodies[body].colliders()
    }

    /// The shapes of a tree, in the order of its links.
    pub(super) fn colliders_in(&self, slot: usize) -> impl Iterator<Item = ColliderHandle> + '_ {
        self.placed(slot).bodies.iter().flat_map(|body| self.colliders_of(*body).iter().copied())
    }

    /// The rule of the tree that damps more, of those that the links belong to.
    pub(super) fn theta(&self, links: &[Option<PlacedLink>; 2]) -> Theta {
        links.iter().flatten().map(|link| self.tree(link.slot).theta()).fold(Theta::MIDPOINT, Theta::or_more)
    }

    /// The pose of a link, world frame.
    pub(super) fn link_pose(&self, at: PlacedLink) -> &WorldPose {
        &self.tree(at.slot).links()[at.link].pose_world
    }

    /// The present pose of a shape, world frame.
    pub(super) fn collider_pose(&self, collider: ColliderHandle) -> WorldPose {
        let mount = self.mount(collider);
        *self.link_pose(mount.at) * mount.pose_link
    }

    /// Moves the shapes with their links, and finds the pairs anew if a shape has left its room. The step must have been prepared.
    pub(super) fn find_pairs(&mut self) {
        let mut has_left = false;
        for mount in self.mounts.iter_mut().flatten().filter(|mount| mount.moves) {
            if let Some(placed) = &self.placed[mount.at.slot] {
                mount.place(&placed.tree.links()[mount.at.link].pose_world);
                mount.way_m = placed.tree.way_m(mount.at.link, mount.center(), mount.bounds.half_extents().length());
            }
            has_left |= mount.has_left_its_room();
        }
        if has_left || self.is_changed {
            self.update();
        }
    }

    /// Runs the broad phase. It gets boxes that overlap if two shapes may meet before one of them has left its room.
    fn update(&mut self) {
        for (handle, collider) in self.colliders.iter() {
            if let Some(mount) = &mut self.mounts[index(handle)] {
                (mount.found_center, mount.found_axes) = (mount.center(), mount.axes_world);
                mount.found_way_m = mount.way_m;
                mount.found_extent = extent(collider.shape(), mount);
            }
        }
        let boxes = self.colliders.iter().filter_map(|(handle, _)| {
            let mount = self.mounts[index(handle)].as_ref()?;
            let [low, high] = mount.found_extent;
            let margin_m = ROOM_M + 0.5 * NEAR_M + excess_m(mount.found_way_m);
            Some((handle, Aabb::new(low - margin_m, high + margin_m)))
        });
        self.finder.find(&self.bodies, &self.colliders, boxes);
        let handles =
            |pair: &[(u32, u32); 2]| pair.map(|(index, generation)| ColliderHandle::from_raw_parts(index, generation));
        let mut pairs = std::mem::take(&mut self.pairs);
        pairs.clear();
        // The set is sorted.
        pairs.extend(self.finder.boxed.iter().map(handles).filter(|pair| self.may_meet(pair)));
        self.pairs = pairs;
        self.is_changed = false;
    }

    /// Whether a pair of shapes may meet before one of them has left its room. The broad phase has compared their groups; its own
    /// boxes may be larger.
    fn may_meet(&self, pair: &[ColliderHandle; 2]) -> bool {
        let [first, second] = pair.map(|collider| self.mount(collider));
        let within_m = 2.0 * ROOM_M + NEAR_M + excess_m(first.found_way_m) + excess_m(second.found_way_m);
        self.may_touch(first, second) && gaps_m(&first.found_extent, &second.found_extent).max_element() <= within_m
    }

    /// Whether shapes whose groups collide may touch: they belong to different parts or trees, and do not pass through each
    /// other.
    fn may_touch(&self, first: &Mount, second: &Mount) -> bool {
        !first.belongs_to(second)
            && !first.stands_in(second)
            && !second.stands_in(first)
            && !self.passing.iter().any(|pair| is_pair(pair, [first.kind, second.kind]))
            && !self.passing_links.iter().any(|pair| is_pair(pair, [first.at, second.at]))
    }

    /// The pairs of shapes that are near each other in the step, sorted, and where their shapes are. No other pair can have a
    /// contact.
    pub(super) fn near_pairs(&self) -> impl Iterator<Item = ([ColliderHandle; 2], [&Mount; 2])> {
        let pairs = self.pairs.iter().map(|pair| (*pair, pair.map(|collider| self.mount(collider))));
        pairs.filter(|(_, [first, second])| first.distance_at_least_m(second) <= first.near_m(second))
    }
}

#[cfg(test)]
mod tests;
