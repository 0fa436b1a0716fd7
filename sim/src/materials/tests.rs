#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use super::*;
use crate::object::{FRICTION, TABLE_FRICTION};
use crate::{ReachPlan, Scene};

const SCENE: &str = "summary = \"A test\"\n[goals]\ncount = 1\n[[objects.trunk]]\ncount = 2\n";

fn plan(materials: &str) -> ReachPlan {
    ReachPlan::new(Scene::parse("test.toml", format!("{SCENE}{materials}")).unwrap(), None, 3).unwrap()
}

/// Tests that the values of the file that ships are those that are used without it.
#[test]
fn the_file_has_the_values_in_use() {
    let arm = Arm::cody().unwrap();
    let value = |name: &str| MaterialFile::shipped().unwrap().constants[name].value;
    assert_eq!(value("skin_modulus_n_per_m3"), arm.skin.stiffness_n_per_m3);
    assert_eq!(Some(value("skin_thickness_m")), arm.skin.thickness_m);
    assert_eq!(value("skin_loss_time_s"), arm.skin.loss_time_s);
    assert_eq!(value("arm_friction"), arm.friction);
    assert_eq!([value("object_friction"), value("table_friction")], [FRICTION, TABLE_FRICTION]);
}

/// Tests that fixing the constants at their values changes nothing, and that drawing them changes neither the objects nor
/// the goals, is different for each reach, and stays within the ranges.
#[test]
fn draws_are_within_their_ranges_and_change_no_clutter() {
    let file = MaterialFile::shipped().unwrap();
    let drawn = plan(&file.section(true));
    let mut all = Vec::new();
    for reach in 0..20 {
        let (with, without) = (drawn.draw(reach).unwrap(), plan("").draw(reach).unwrap());
        assert_eq!(with.goals, without.goals);
        assert_eq!(with.objects[1].foot_world, without.objects[1].foot_world);
        for (name, value) in with.materials.values() {
            let [low, high] = file.constants[name].range;
            assert!((low..=high).contains(&value), "{name} = {value}");
        }
        all.push(with.materials.skin_modulus_n_per_m3.unwrap());
    }
    all.sort_by(f64::total_cmp);
    all.dedup();
    assert_eq!(all.len(), 20);
    let run = |materials: &str| plan(materials).run(0, &mut |_| {}).unwrap().frames;
    assert_eq!(run(&file.section(false)), run(""));
}

/// Tests that constants can be added to an arranged scene, and that a scene with a section of its own, even an empty one, is
/// refused with its line.
#[test]
fn constants_are_added_to_scenes_without_any() {
    let file = MaterialFile::shipped().unwrap();
    let own = plan("[materials]\n");
    let error = own.scene.with_materials(&file, true).unwrap_err();
    assert_eq!((error.field.as_str(), error.line), ("materials", Some(6)), "{error}");
    for plan in [plan(""), own] {
        let text = plan.draw(0).unwrap().arranged(&plan.scene, "arranged.toml".as_ref());
        let arranged = Scene::parse("arranged.toml", text).unwrap();
        assert_eq!(arranged.with_materials(&file, true).unwrap().file.materials.quantities().len(), CONSTANTS.len());
    }
}

/// Tests that a file is refused for an unknown constant, a range beyond the limits, and a value outside its range.
#[test]
fn bad_files_are_refused() {
    let table = |name: &str, rest: &str| format!("[{name}]\n{rest}\nsource = \"s\"\naffects = \"a\"\n");
    for (text, part) in [
        (table("skin_color", "value = 1\nrange = [0, 2]"), "skin_color"),
        (table("arm_friction", "value = 1.0\nrange = [0.5, 9.0]"), "values from 0 to 2"),
        (table("arm_friction", "value = 1.0\nrange = [0.2, 0.5]"), "within its range"),
        (table("arm_friction", "value = 1.0"), "missing field"),
    ] {
        let error = MaterialFile::parse("my.toml".as_ref(), &text).unwrap_err();
        assert!(error.to_string().contains(part), "{error}");
    }
}
