//! Tests of which shapes are pairs.

use rapier3d::parry::query::distance;

use super::*;
use crate::dynamics::Coordinate;
use crate::object::structure::{Axis, Spring};
use crate::{Observed, ReachPlan, Scene as SceneFile};

/// Adds a ball of 5 cm radius at this place, m, which can move along x, and returns its slot.
fn add_ball(scene: &mut Scene, x_m: f64) -> usize {
    let mut link = Link::new(0, WorldPose::from_position(DVec3::X * x_m));
    link.mass_kg = 1.0;
    let mut tree = Tree::new(WorldPose::IDENTITY, false);
    tree.add(link, [Coordinate::new(Axis::along(DVec3::X), Spring::elastic(0.0, 0.0))]);
    let (shape, groups) = (ColliderBuilder::ball(0.05), InteractionGroups::all());
    scene.insert(tree, vec![Solid { link: 1, shape, groups, surface: Surface::hard(0.3), part: 0 }])
}

/// Two balls that overlap, and the slot of the second one.
fn two_balls() -> (Scene, usize) {
    let mut scene = Scene::default();
    add_ball(&mut scene, 0.0);
    let second = add_ball(&mut scene, 0.08);
    assert_eq!(pairs(&mut scene), [[0, 1]]);
    (scene, second)
}

/// Prepares a step, as the engine does, and finds the pairs.
fn prepare(scene: &mut Scene) {
    for tree in scene.trees_mut() {
        let theta = tree.own_theta(0.005);
        tree.begin(0.005, theta);
        tree.prepare(9.81);
    }
    scene.find_pairs();
}

/// Prepares a step, and returns the pairs of shapes by their slots.
fn pairs(scene: &mut Scene) -> Vec<[usize; 2]> {
    prepare(scene);
    let slots = scene.pairs.iter().map(|pair| pair.map(|shape| scene.mount(shape).at.slot));
    slots.map(|[one, other]| [one.min(other), one.max(other)]).collect()
}

/// Tests that a shape that was removed is in no pair.
#[test]
fn a_removed_shape_is_in_no_pair() {
    let (mut scene, second) = two_balls();
    scene.remove(second);
    assert!(pairs(&mut scene).is_empty());
}

/// Tests that a shape that gets the index of a removed one in its place is in one pair.
#[test]
fn a_shape_in_the_place_of_a_removed_one_is_in_one_pair() {
    let (mut scene, second) = two_balls();
    let indices = |scene: &Scene, slot: usize| scene.colliders_in(slot).map(index).collect::<Vec<usize>>();
    let before = indices(&scene, second);
    scene.remove(second);
    let third = add_ball(&mut scene, 0.08);
    assert_eq!(indices(&scene, third), before);
    assert_eq!(pairs(&mut scene), [[0, 1]]);
}

/// Tests that the broad phase has no pair of shapes that have left each other.
#[test]
fn shapes_that_left_each_other_are_no_pair() {
    let (mut scene, second) = two_balls();
    let tree = scene.tree_mut(second);
    tree.coordinates[0].position = 1.0;
    tree.place();
    pairs(&mut scene);
    assert!(scene.finder.boxed.is_empty(), "{:?}", scene.finder.boxed);
}

/// The pairs of shapes that may touch and that parry finds less than [`NEAR_M`] apart in the poses of the trees, and how many of
/// them overlap. No box of the scene counts.
fn near_by_parry(scene: &Scene) -> (BTreeSet<[usize; 2]>, usize) {
    let shapes: Vec<ColliderHandle> = scene.colliders.iter().map(|(handle, _)| handle).collect();
    let (mut near, mut overlapping) = (BTreeSet::new(), 0);
    for (place, own) in shapes.iter().enumerate() {
        let own_pose = parry_pose(&scene.collider_pose(*own));
        for other in &shapes[place + 1..] {
            let mounts = [scene.mount(*own), scene.mount(*other)];
            if !scene.groups(*own).test(scene.groups(*other))
                || !mounts.iter().any(|mount| mount.moves)
                || !scene.may_touch(mounts[0], mounts[1])
            {
                continue;
            }
            let other_pose = parry_pose(&scene.collider_pose(*other));
            let apart_m = distance(&own_pose, scene.shape(*own), &other_pose, scene.shape(*other)).unwrap();
            if apart_m.distance < NEAR_M {
                near.insert([index(*own), index(*other)]);
                overlapping += usize::from(apart_m.distance == 0.0);
            }
        }
    }
    (near, overlapping)
}

/// Tests that steps of two whole reaches, one in every tenth frame, look at all shapes that parry finds near each other. The audit
/// of lost contacts sees only pairs that a step looks at.
#[test]
fn a_step_looks_at_all_shapes_that_are_near_each_other() {
    for path in ["leaf.toml", "mixed.toml"] {
        let text = crate::scene::shipped(path).unwrap();
        let plan = ReachPlan::new(SceneFile::parse(path, text.into()).unwrap(), None, 77).unwrap();
        let (mut near, mut overlapping) = (0, 0);
        let mut observer = |observed: Observed| {
            let frame = observed.simulation.report().frame;
            if !frame.is_multiple_of(10) {
                return;
            }
            let mut scene = observed.simulation.state.world.engine.scene.clone();
            prepare(&mut scene);
            let looked_at = scene.near_pairs().map(|(pair, _)| pair.map(index));
            let looked_at: BTreeSet<[usize; 2]> =
                looked_at.map(|[one, other]| [one.min(other), one.max(other)]).collect();
            let (found, deep) = near_by_parry(&scene);
            let overlooked: Vec<_> = found.difference(&looked_at).collect();
            assert!(overlooked.is_empty(), "{path}, frame {frame}: {overlooked:?}");
            near += found.len();
            overlapping += deep;
        };
        plan.run(0, &mut observer).unwrap();
        assert!(overlapping > 100, "{path}: {near} near, {overlapping} overlapping");
    }
}
