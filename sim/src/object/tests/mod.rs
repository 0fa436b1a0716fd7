//! Tests of the list of objects, and of what it takes to add one: the wand is one file and one entry of that list.

pub mod wand;

use std::collections::BTreeMap;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use underbrush_recording::{Body, BodyOwner};

use super::trunk::Trunk;
use super::{Footing, Group};
use crate::reach::ReachPlan;
use crate::scene::{Objects, Scene};

/// The keys of all kinds of objects: each is a property of the schema.
fn kinds() -> Vec<String> {
    let schema = schemars::schema_for!(Objects);
    let properties = schema.get("properties").unwrap().as_object().unwrap();
    properties.keys().cloned().collect()
}

/// A group of every kind with default values.
fn one_of_each() -> Objects {
    let text: String = kinds().iter().map(|kind| format!("[[{kind}]]\ncount = 1\n")).collect();
    toml::from_str(&text).unwrap()
}

/// Tests that the categories of all objects in the list can be told apart by name and by code in one data set.
#[test]
fn no_two_categories_share_a_name_or_a_code() {
    let objects = one_of_each();
    let groups = objects.groups();
    assert_eq!(groups.len(), kinds().len());
    let (mut names, mut codes) = (BTreeMap::new(), BTreeMap::new());
    for (_, _, group) in groups {
        let category = group.category;
        assert_eq!(*names.entry(category.name()).or_insert(category), category);
        assert_eq!(*codes.entry(category.code()).or_insert(category), category);
    }
}

/// Tests that an added object with a category of its own is read from a scene file, placed, simulated, touched and
/// recorded with its category, and that the arm moves it.
#[test]
fn an_added_object_goes_through_a_reach() {
    let text = "summary = \"Wands\"\n[goals]\ncount = 4\nretries = 0\npatience_s = 1.0\n\
                [[objects.foam_block]]\ncount = 4\n[[objects.wand]]\ncount = 20\nheight_m = 0.5\n";
    let plan = ReachPlan::new(Scene::parse("wands.toml", text.into()).unwrap(), None, 0).unwrap();
    let (mut felt, mut moved) = (0, 0);
    for reach in 0..3 {
        let recording = plan.run(reach, &mut |_| {}).unwrap();
        assert_eq!(recording.further_categories(), [wand::CATEGORY]);
        let is_wand = |index: u16| recording.objects[usize::from(index)].category == wand::CATEGORY;
        let wands = recording.objects.iter().filter(|object| object.kind == "wand");
        assert_eq!(wands.clone().count(), 20);
        assert!(
            wands.into_iter().all(|object| object.category == wand::CATEGORY && object.parameters["height_m"] == 0.5)
        );
        let taxels = recording.frames.iter().flat_map(|frame| &frame.taxels);
        let pressed = taxels.filter(|taxel| taxel.true_normal_force_n > 0.0);
        felt += pressed.filter_map(|taxel| taxel.object).filter(|object| is_wand(*object)).count();
        let own = |body: &&Body| matches!(body.owner, BodyOwner::Object(index) if is_wand(index));
        moved += recording.bodies.iter().filter(own).filter(|body| !body.track.is_empty()).count();
    }
    assert!(felt > 0 && moved > 0, "{felt} taxels felt a wand, {moved} wands moved");
}

/// Tests that a drawn object has the kind of its group.
#[test]
fn drawn_objects_are_what_their_group_says() {
    let mut random = crate::seed::stream(0, "objects", 0, "clutter");
    let footing = super::Footing { height_m: 0.0, foam_modulus_pa: Some(5.0e4) };
    for (kind, _, group) in one_of_each().groups() {
        let (object, _) = group.draw(&mut random, &footing).unwrap();
        assert_eq!(object.kind(), kind);
        assert_eq!(object.structure(9.81).bodies[0].joint, None, "{kind} begins with what is fixed to the ground");
    }
}

/// Tests that a trunk is as high as it says: those lower than their radius are drawn again, or refused if there are no
/// others.
#[test]
fn trunks_are_not_lower_than_their_radius() {
    let footing = Footing { height_m: 0.0, foam_modulus_pa: None };
    let mut random = ChaCha8Rng::seed_from_u64(0);
    let mut draw = |diameter_m: &str| {
        let text = format!("count = 1\ndiameter_m = {diameter_m}\nheight_m = {{ uniform = [0.05, 0.1] }}\n");
        let group: Group<Trunk> = toml::from_str(&text).unwrap();
        group.0.draw(&mut random, &footing).map(|(trunk, _)| trunk.parameters())
    };
    for _ in 0..30 {
        let own = draw("{ uniform = [0.05, 0.3] }").unwrap();
        assert!(own["height_m"] >= own["diameter_m"] / 2.0, "{own:?}");
    }
    assert!(draw("0.3").is_err());
}
