use std::fs;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::super::Arm;
use super::super::cover::{Covered, NewPatch, cover};
use underbrush_recording::InputError;

/// Writes an arm of one joint whose link has these collision shapes, m.
fn arm_with(folder: &Path, shapes: &str) -> PathBuf {
    let urdf = format!(
        "<robot name=\"rod\"><link name=\"base\"/><link name=\"tip\"/><link name=\"rod\"><inertial><mass value=\"1\"/>\
         <inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>{shapes}</link>\
         <joint name=\"hinge\" type=\"revolute\"><parent link=\"base\"/><child link=\"rod\"/><axis xyz=\"0 0 1\"/>\
         <limit lower=\"-1\" upper=\"1\" effort=\"10\" velocity=\"1\"/></joint>\
         <joint name=\"end\" type=\"fixed\"><parent link=\"rod\"/><child link=\"tip\"/></joint></robot>"
    );
    let arm = "name = \"rod\"\nurdf = \"rod.urdf\"\nskin = \"rod.skin.toml\"\nbase_link = \"base\"\ntip_link = \"rod\"\n\
               friction = 0.3\n[[joint]]\nname = \"hinge\"\nstiffness_nm_per_rad = 10.0\ndamping_nm_s_per_rad = 1.0\n\
               model_stiffness_nm_per_rad = 10.0\ncontroller_limits_deg = [-50.0, 50.0]\nstart_deg = 0.0\n";
    for (name, text) in
        [("rod.urdf", urdf.as_str()), ("rod.toml", arm), ("rod.skin.toml", "stiffness_n_per_m3 = 3e7\n")]
    {
        fs::write(folder.join(name), text).unwrap();
    }
    folder.join("rod.toml")
}

fn shape(shape: &str, at: &str) -> String {
    format!("<collision><origin xyz=\"{at}\"/><geometry><{shape}/></geometry></collision>")
}

fn covered(shapes: &str, change: impl Fn(&mut NewPatch)) -> Result<Covered, InputError> {
    let folder = tempfile::tempdir().unwrap();
    let mut new = NewPatch { name: "rod".into(), link: "rod".into(), pitch_m: 0.01, prune: false, replace: false };
    change(&mut new);
    cover(&arm_with(folder.path(), shapes), &new)
}

fn places(arm: &Arm) -> Vec<(DVec3, DVec3)> {
    arm.skin.layout.patches[0].taxels.iter().map(|taxel| (taxel.position_link, taxel.normal_link)).collect()
}

/// Tests that a cylinder gets a grid on its side: 20 cm long and 5 cm thick, at a pitch of 1 cm, it has 20 rows of 15, the
/// rows from end to end.
#[test]
fn a_cylinder_gets_a_grid() {
    let covered = covered(&shape("cylinder radius=\"0.025\" length=\"0.2\"", "0 0 0.3"), |_| {}).unwrap();
    let grid = covered.arm.skin.layout.patches[0].grid.unwrap();
    assert_eq!((grid.rows, grid.columns, grid.wraps, covered.left_out), (20, 15, true, 0));
    for (place, normal) in places(&covered.arm) {
        assert!((place.truncate().length() - 0.025).abs() < 1e-9 && (0.2049..0.3951).contains(&place.z), "{place}");
        assert!(normal.abs_diff_eq((place / 0.025).with_z(0.0), 1e-6), "{normal}");
    }
    assert_eq!(covered.arm.skin_doubts(), [""; 0]);
}

/// Tests that a link that is rigidly joined to another stands for both.
#[test]
fn a_joined_link_stands_for_the_first() {
    let of =
        |name: &str| covered(&shape("sphere radius=\"0.025\"", "0 0 0.3"), |new| new.link = name.into()).unwrap().text;
    assert_eq!(of("tip"), of("rod"));
    assert!(of("tip").contains("link = \"rod\""));
}

/// Tests that a ball gets taxels all over: on its surface, facing out, at least 0.9 pitches apart, no place farther than one
/// pitch from all of them, and as many as squares of the pitch cover it, within a quarter.
#[test]
fn a_ball_gets_taxels_all_over() {
    let covered = covered(&shape("sphere radius=\"0.05\"", "0 0 0"), |_| {}).unwrap();
    let places = places(&covered.arm);
    for (number, (place, normal)) in places.iter().enumerate() {
        assert!((place.length() - 0.05).abs() < 2e-5 && normal.abs_diff_eq(*place / 0.05, 1e-3), "{place} {normal}");
        assert!(places[..number].iter().all(|(other, _)| other.distance(*place) > 0.009 - 3e-5));
    }
    for direction in [DVec3::X, DVec3::ONE.normalize(), DVec3::new(-0.3, 0.5, -0.8).normalize(), DVec3::NEG_Z] {
        assert!(places.iter().any(|(place, _)| place.distance(direction * 0.05) < 0.01), "nothing near {direction}");
    }
    let squares = 4.0 * std::f64::consts::PI * 0.05 * 0.05 / 1e-4;
    assert!((0.75..1.25).contains(&(places.len() as f64 / squares)), "{} {squares}", places.len());
}

/// Tests that taxels inside another shape are an error that lists all of them, that they are left out on demand, and that
/// none is left inside: a ball on the end of a box.
#[test]
fn taxels_that_cannot_be_touched_are_listed_or_left_out() {
    let shapes = shape("box size=\"0.04 0.04 0.2\"", "0 0 0") + &shape("sphere radius=\"0.05\"", "0 0 0.1");
    // Few enough that the error does not shorten the list.
    let error = covered(&shapes, |new| new.pitch_m = 0.02).unwrap_err();
    let count: usize = error.found.split_whitespace().next().unwrap().parse().unwrap();
    let list = error.found.split_once('(').unwrap().1.trim_end_matches(')');
    let listed = list.split(", ").map(|run| {
        let (first, last) = run.split_once('-').unwrap_or((run, run));
        last.parse::<usize>().unwrap() + 1 - first.parse::<usize>().unwrap()
    });
    assert!(count > 10 && listed.sum::<usize>() == count && error.remedy.contains("--prune"), "{error}");
    let covered = covered(&shapes, |new| new.prune = true).unwrap();
    let inside = |place: DVec3| {
        place.distance(DVec3::Z * 0.1) < 0.049 || place.truncate().abs().max_element() < 0.019 && place.z.abs() < 0.099
    };
    let within: Vec<_> = places(&covered.arm).into_iter().filter(|(place, _)| inside(*place)).collect();
    assert!(within.is_empty(), "{within:?}");
    assert_eq!(covered.arm.skin_doubts(), [""; 0]);
}

/// Tests that all faults of the options are in one error.
#[test]
fn faults_are_listed_at_once() {
    let error = covered(&shape("sphere radius=\"0.05\"", "0 0 0"), |new| {
        new.link = "arm".into();
        new.pitch_m = 2.0;
    });
    let error = error.unwrap_err().found;
    assert!(
        error.contains("no link \"arm\"") && error.contains("base, rod") && error.contains("a pitch of 2000 mm"),
        "{error}"
    );
}

/// Tests that a patch on top of another one is doubtful.
#[test]
fn a_patch_on_another_is_doubtful() {
    let folder = tempfile::tempdir().unwrap();
    let file = arm_with(folder.path(), &shape("cylinder radius=\"0.05\" length=\"0.2\"", "0 0 0"));
    let mut new = NewPatch { name: "one".into(), link: "rod".into(), pitch_m: 0.02, prune: false, replace: false };
    let made = cover(&file, &new).unwrap();
    assert!(made.arm.skin_doubts().is_empty());
    fs::write(made.path, made.text).unwrap();
    (new.name, new.pitch_m) = ("two".into(), 0.01);
    let doubts = cover(&file, &new).unwrap().arm.skin_doubts();
    assert_eq!(doubts, ["patch two: 620 of 620 taxels lie on those of patch one"]);
}

/// Tests that a pitch of nothing has one message, not one about the number of taxels, too.
#[test]
fn a_pitch_of_nothing_has_one_message() {
    let error = covered(&shape("sphere radius=\"0.05\"", "0 0 0"), |new| new.pitch_m = 0.0).unwrap_err();
    assert_eq!(error.found, "a pitch of 0 mm; it must be 0.1 to 500 mm");
}

/// Tests that a patch is replaced only on demand, in its place, and that the others stay, with the comments about them.
#[test]
fn a_patch_is_replaced_on_demand() {
    let folder = tempfile::tempdir().unwrap();
    let file = arm_with(folder.path(), &shape("sphere radius=\"0.05\"", "0 0 0"));
    let mut new = NewPatch { name: "one".into(), link: "rod".into(), pitch_m: 0.02, prune: false, replace: false };
    for name in ["one", "two"] {
        new.name = name.into();
        let made = cover(&file, &new).unwrap();
        fs::write(made.path, made.text).unwrap();
    }
    new.name = "one".into();
    assert!(cover(&file, &new).unwrap_err().found.contains("--force"));
    (new.pitch_m, new.replace) = (0.01, true);
    let skin = folder.path().join("rod.skin.toml");
    let text = fs::read_to_string(&skin).unwrap();
    let (before, second) = text.rsplit_once("[[patch]]").unwrap();
    fs::write(&skin, format!("{before}# About the second.\n[[patch]]{second}")).unwrap();
    let made = cover(&file, &new).unwrap();
    assert!(made.text.contains(&format!("\n]\n\n# About the second.\n[[patch]]{second}")), "{}", made.text);
    assert_eq!(made.text.matches("# Made by").count(), 2);
    let patches = made.arm.skin.layout.patches;
    let names: Vec<&str> = patches.iter().map(|patch| patch.name.as_str()).collect();
    assert_eq!(names, ["one", "two"]);
    assert!(patches[0].taxels.len() > 3 * patches[1].taxels.len());
}
