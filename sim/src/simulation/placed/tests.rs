//! Tests of which shapes are pairs.

use super::*;
use crate::dynamics::Coordinate;
use crate::object::structure::{Axis, Spring};

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

/// Prepares a step, and returns the pairs of shapes by their slots.
fn pairs(scene: &mut Scene) -> Vec<[usize; 2]> {
    for tree in scene.trees_mut() {
        tree.begin(0.005, Theta::EULER);
        tree.prepare(0.0);
    }
    scene.find_pairs();
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
