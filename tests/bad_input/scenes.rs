//! Invalid scene files, and missing arms.

use std::path::Path;

use super::{Fault, assert_empty};
use crate::support::{scenes, underbrush};

const HEAD: &str = "summary = \"A scene\"\n\n";
const LEAF: &str = "[[objects.foam_block]]\ncount = 1\n\n[[objects.leaf]]\ncount = 2\n";

/// Demands that every command that reads scenes refuses this one with line and `parts`, and writes nothing.
#[track_caller]
fn refuses(text: &str, line: Option<usize>, parts: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let outputs = tempfile::tempdir().unwrap();
    let file = scenes::write(folder.path(), "bad.toml", text);
    let fault = Fault { file: &file, line, parts };
    let [set, recording, picture] = ["set", "reach.parquet", "reach.png"].map(|name| outputs.path().join(name));
    fault.check(&underbrush!["inspect", file]);
    fault.check(&underbrush!["reach", file, "--out", recording, "--picture", picture]);
    fault.check(&underbrush!["generate", file, "--reaches", "2", "--out", set]);
    assert_empty(outputs.path());
}

/// Tests that a misspelled key is an error and not a silent default, both at the top and in a group.
#[test]
fn unknown_key() {
    refuses(
        "summary = \"A scene\"\nsumary = 3\n",
        Some(2),
        &["unknown field `sumary`", "`summary`", "correct this line"],
    );
    let text = format!("{HEAD}{LEAF}heigth_m = 0.3\n");
    refuses(&text, Some(8), &["unknown field `heigth_m`", "`height_m`", "underbrush schema", "correct this line"]);
    refuses(&format!("{HEAD}[[objects.bush]]\ncount = 1\n"), Some(3), &["unknown field `bush`", "`leaf`"]);
}

/// Tests that an array with too many elements, and an array in place of a table, are refused.
#[test]
fn another_shape() {
    let group = format!("{HEAD}{LEAF}");
    for (text, line, parts) in [
        (
            format!("{group}width_m = {{ uniform = [0.02, 0.03, 0.04] }}\n"),
            8,
            ["an array of 3", "allowed: an array of 2"],
        ),
        (
            format!("{group}place.x_m = {{ normal = [0.5, 0.1, 0.2] }}\n"),
            8,
            ["an array of 3", "allowed: an array of 2"],
        ),
        (format!("{HEAD}goals = {{ positions_m = [[0.5, 0, -0.3, 0.2]] }}\n"), 3, ["goals", "allowed: an array of 3"]),
        (format!("{HEAD}physics = [0.001, 1.0]\n"), 3, ["scene, physics: found an array", "allowed: a table"]),
        (format!("{HEAD}passing = [[\"leaf\", \"leaf\", \"trunk\"]]\n"), 3, ["passing", "allowed: an array of 2"]),
        (format!("{HEAD}sensor = [\"ideal\"]\n"), 3, ["scene, sensor: found an array", "allowed: a table"]),
    ] {
        refuses(&text, Some(line), &parts);
    }
}

/// Tests that single and double brackets of headers in place of each other are named, and a header that is there twice.
#[test]
fn brackets_of_headers() {
    for (header, parts) in [
        ("[objects.leaf]", ["scene, objects.leaf: found a table", "each header has `[[…]]`"]),
        ("[[goals]]", ["scene, goals: found an array", "single brackets, `[…]`"]),
        ("[[materials]]", ["scene, materials: found an array", "single brackets, `[…]`"]),
    ] {
        refuses(&format!("{HEAD}{header}\n"), Some(3), &parts);
    }
    refuses(&format!("{HEAD}{LEAF}[objects.leaf]\n"), Some(8), &["found duplicate key", "double brackets, `[[…]]`"]);
}

/// Tests that a table of names as an array, too few numbers and the name of a category are refused with what is allowed.
#[test]
fn what_is_allowed_in_a_value() {
    for (value, parts) in [
        ("place = [0.6, -0.2]", ["found invalid length 2", "allowed: a table"]),
        ("place.x_m = { uniform = [0.6] }", ["found invalid length 1", "allowed: an array of length 2"]),
        ("category = \"Reed\"", ["found category \"Reed\"", "allowed: up to 24 lower-case letters"]),
    ] {
        refuses(&format!("{HEAD}{LEAF}{value}\n"), Some(8), &parts);
    }
}

/// Tests that a force cannot be allowed on a category that nothing in the scene can be.
#[test]
fn a_force_on_nothing() {
    let text = format!("{HEAD}allowed_force_n = {{ laef = 3 }}\n{LEAF}");
    refuses(&text, Some(3), &["allowed_force_n.laef: found laef", "leaf, trunk", "change the value"]);
    let named = format!("{HEAD}allowed_force_n = {{ fern = 3, unknown = 1 }}\n{LEAF}category = \"fern\"\n");
    let folder = tempfile::tempdir().unwrap();
    underbrush!["inspect", scenes::write(folder.path(), "good.toml", &named)].success();
}

/// Tests that text that is not TOML is refused with its line, and with how TOML is written.
#[test]
fn no_toml() {
    for value in ["", "mapped", "0,5", ".5"] {
        let text = format!("summary = \"A scene\"\ncontroller = {value}\n");
        let parts = ["scene, controller: found", "text is in quotes", "a decimal point", "correct this line"];
        refuses(&text, Some(2), &parts);
    }
}

/// Tests that a group of objects needs a count.
#[test]
fn missing_key() {
    let parts = ["missing field `count`", "underbrush schema", "correct this line"];
    refuses(&format!("{HEAD}[[objects.trunk]]\n"), Some(3), &parts);
}

/// Tests that a negative stiffness is refused.
#[test]
fn negative_rigidity() {
    let parts = ["objects.leaf[0].flexural_rigidity_n_m2: found -0.01", "allowed: values from 0.00001 to 10", "change"];
    refuses(&format!("{HEAD}{LEAF}flexural_rigidity_n_m2 = -0.01\n"), Some(8), &parts);
}

/// Tests that cameras without a usable name, place, direction, angle or size are refused, and so are two of one name and one on a
/// link that the arm does not have.
#[test]
fn bad_cameras() {
    let camera = |name: &str, further: &str| format!("[[cameras]]\nname = \"{name}\"\neye_m = [1, 0, 0]\n{further}\n");
    let at = "target_m = [0, 0, 0]";
    for (text, line, parts) in [
        (camera("a b", at), 4, ["cameras[0].name: found \"a b\"", "letters, digits, - and _"]),
        (camera("a", "target_m = [0, nan, 0]"), 6, ["cameras[0].target_m: found NaN", "numbers from -5 to 5 m"]),
        (camera("a", "target_m = [1, 0, 0]"), 6, ["cameras[0].target_m", "at least 1 mm from eye_m"]),
        (camera("a", &format!("{at}\nup = [2, 0, 0]")), 7, ["cameras[0].up", "another direction"]),
        (
            camera("a", &format!("{at}\nvertical_fov_deg = 180")),
            7,
            ["vertical_fov_deg: found 180", "allowed: 1 to 150 degrees"],
        ),
        (
            camera("a", &format!("{at}\nsize_px = [320, 2000]")),
            7,
            ["size_px: found 2000", "allowed: 64 to 1280 pixels"],
        ),
        (camera("a", &format!("{at}\nlink = \"thumb\"")), 7, ["cameras[0].link: found \"thumb\"", "forearm, wrist"]),
        (camera("a", at) + &camera("a", at), 8, ["cameras[1].name: found \"a\"", "no other camera"]),
    ] {
        refuses(&format!("{HEAD}{text}"), Some(line), &parts);
    }
}

/// Tests that NaN is refused as a value, in a range and as a standard deviation.
#[test]
fn not_a_number() {
    for (value, found) in [
        ("nan", "found NaN"),
        ("{ uniform = [nan, 0.3] }", "found { uniform = [NaN, 0.3] }"),
        ("{ uniform = [0.3, nan] }", "found { uniform = [0.3, NaN] }"),
        ("{ normal = [0.3, nan] }", "found { normal = [0.3, NaN] }"),
        ("inf", "found inf"),
    ] {
        let text = format!("{HEAD}{LEAF}height_m = {value}\n");
        refuses(&text, Some(8), &["objects.leaf[0].height_m", found, "allowed:", "change the value"]);
    }
    let text = format!("{HEAD}[physics]\nstep_s = nan\n");
    refuses(&text, Some(4), &["physics.step_s: found NaN", "0.0001 to 0.01 s"]);
    let text = format!("{HEAD}[sensor]\nnoise_n = nan\n");
    refuses(&text, Some(4), &["sensor.noise_n: found NaN", "0 (off), or 1e-6 to 1 N"]);
    let text = format!("{HEAD}[sensor]\nnoise_n = 0.01\n[sensor.fabric]\nnoise_n = nan\n");
    refuses(&text, Some(6), &["sensor.fabric.noise_n: found NaN", "0 (off), or 1e-6 to 1 N"]);
}

/// Tests that dead taxels are checked against the arm's skin.
#[test]
fn dead_taxels_that_are_not_there() {
    let text = format!("{HEAD}[sensor]\ndead_taxels = {{ forearm = [0, 384] }}\n");
    refuses(&text, Some(4), &["sensor.dead_taxels: found 384", "0 to 383 on forearm"]);
    let text = format!("{HEAD}[sensor]\ndead_taxels = {{ elbow = [0] }}\n");
    refuses(&text, Some(4), &["sensor.dead_taxels: found \"elbow\"", "forearm, flipper"]);
}

/// Tests that bounds in the wrong order are refused and not swapped silently.
#[test]
fn reversed_range() {
    let text = format!("{HEAD}{LEAF}height_m = {{ uniform = [0.4, 0.3] }}\n");
    let parts = ["objects.leaf[0].height_m", "found { uniform = [0.4, 0.3] }", "the lower bound first", "change"];
    refuses(&text, Some(8), &parts);
    let text = format!("{HEAD}[workspace]\nx_m = [0.8, 0.2]\n");
    refuses(&text, Some(4), &["workspace.x_m: found [0.8, 0.2]", "the smaller first", "change"]);
    let text = format!("{HEAD}[sensor]\nspurious_force_n = [0.1, 0.02]\n");
    refuses(&text, Some(4), &["sensor.spurious_force_n: found [0.1, 0.02]", "the smaller first"]);
}

/// Tests that a reach needs at least one goal, and that the error shows the line in `[goals]`, although groups of
/// objects also have a `count`.
#[test]
fn no_goals() {
    let text = format!("{HEAD}{LEAF}[goals]\ncount = 0\n");
    refuses(&text, Some(9), &["goals.count: found 0", "1 to 1000 goals", "change"]);
}

/// Tests that plants that could not stand, and plants whose blades would be in the foam, are refused at the line of what is
/// to be changed.
#[test]
fn plants_that_fall_over() {
    let plant = format!("{HEAD}[[objects.foam_block]]\ncount = 3\n\n[[objects.plant]]\ncount = 1\n");
    let parts = ["objects.plant[0].stem_rigidity_n_m2: found 0.001 gives no value from", "change the value"];
    refuses(&format!("{plant}stem_rigidity_n_m2 = 0.001\n"), Some(8), &parts);
    let parts = ["objects.plant[0].flexural_rigidity_n_m2: found 0.0002 gives no value from", "change the value"];
    refuses(
        &format!("{plant}petiole_m = 0.3\nblade_length_m = 0.1\nflexural_rigidity_n_m2 = 0.0002\n"),
        Some(10),
        &parts,
    );
    let parts = ["objects.plant[0].droop_deg: found 170 gives no value from -90 to 0", "change the value"];
    let text = format!("{plant}elevation_deg = 0\nblade_length_m = 0.5\ndroop_deg = 170\n");
    refuses(&text, Some(10), &parts);
}

/// Tests that two trunks in one place are refused with the reason, at the line of the second.
#[test]
fn overlapping_trunks() {
    let place = "place = { x_m = 0.6, y_m = -0.2 }";
    let text = format!("{HEAD}[[objects.trunk]]\ncount = 1\n{place}\n\n[[objects.trunk]]\ncount = 1\n{place}\n");
    refuses(&text, Some(8), &["objects.trunk[1].count", "1000 overlapped another object", "change"]);
}

/// Tests that more objects than there is room for, or than a scene may have, are refused, and that no data set is left
/// behind.
#[test]
fn more_trunks_than_room() {
    let text = format!("{HEAD}[[objects.trunk]]\ncount = 9000\n");
    refuses(&text, Some(4), &["objects.trunk[0].count: found 9000", "no more objects than there is room for;"]);
    let text = format!("{HEAD}[[objects.trunk]]\ncount = 10001\n");
    refuses(&text, Some(4), &["objects.trunk[0].count: found 10001", "0 to 10000 objects in all groups together"]);
}

/// Tests that a scene with leaves but without foam is refused with the reason.
#[test]
fn leaves_without_foam() {
    let text = format!("{HEAD}[[objects.leaf]]\ncount = 3\n");
    refuses(&text, Some(4), &["objects.leaf[0].count: found 3", "1000 had no foam to stand in"]);
}

/// Tests that goals out of reach of the arm are refused as such, also if there are plants elsewhere.
#[test]
fn goals_out_of_reach() {
    let text = format!("{HEAD}[goals]\nx_m = 4.0\n\n[[objects.trunk]]\ncount = 1\n");
    let parts = ["goals: found no goal number 1", "5000 are farther than the arm is long", "where the arm has room"];
    refuses(&text, None, &parts);
}

/// Tests that goals in reach but far from all plants are refused with the patch that does not meet any.
#[test]
fn goals_beside_the_plants() {
    let goal = "x_m = 0.5\ny_m = -0.2\nz_m = -0.25\n";
    let trunk = "[[objects.trunk]]\ncount = 1\nplace = { x_m = 0.5, y_m = 0.6 }\n";
    let text = format!("{HEAD}[goals]\n{goal}{trunk}");
    refuses(&text, None, &["goals: found no goal number 1", "on a straight way to 5000", "change"]);
    refuses(
        &text,
        None,
        &["its first patch, forearm of link forearm", "a first patch in the skin file that is farther from the base"],
    );
}

/// Tests that an unknown controller is refused with the names of all controllers.
#[test]
fn unknown_controller() {
    let text = format!("{HEAD}controller = \"clever\"\n");
    refuses(
        &text,
        Some(3),
        &[
            "controller: found unknown controller `clever`",
            "one of cody-2013, ijrr-foliage, blind",
            "correct this line",
        ],
    );
}

/// Tests that an empty summary and an empty path of an arm are refused.
#[test]
fn empty_texts() {
    let parts = ["summary: found \" \"", "a sentence that says what the scene shows", "change the value"];
    refuses(&format!("summary = \" \"\n\n{LEAF}"), Some(1), &parts);
    refuses(&format!("{HEAD}arm = \"\"\n"), Some(3), &["arm: found \"\"", "cody, or the path of an arm file"]);
}

/// Tests that a missing scene file is reported as such.
#[test]
fn missing_scene() {
    let outputs = tempfile::tempdir().unwrap();
    let (file, set) = (outputs.path().join("absent.toml"), outputs.path().join("set"));
    let parts = ["no such file", "check the path"];
    let fault = Fault { file: &file, line: None, parts: &parts };
    fault.check(&underbrush!["reach", file]);
    fault.check(&underbrush!["generate", file, "--reaches", "1", "--out", set]);
    let name = file.display().to_string();
    underbrush!["inspect", file].refused(&[
        &name,
        "no such file",
        "a scene or its name, arm, data set",
        "check the path",
    ]);
    assert_empty(outputs.path());
}

/// Tests that the path of an arm is relative to the scene file, and that a missing arm file is reported by its own
/// path, and the place that names it.
#[test]
fn missing_arm() {
    let folder = tempfile::tempdir().unwrap();
    let outputs = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "scene.toml", &format!("{HEAD}arm = \"no-arm.toml\"\n"));
    let (arm, set) = (folder.path().join("no-arm.toml"), outputs.path().join("set"));
    let place = format!("{}:{} names this file", scene.display(), HEAD.lines().count() + 1);
    let parts = ["no such file", "check the path", &place];
    let fault = Fault { file: &arm, line: None, parts: &parts };
    fault.check(&underbrush!["reach", scene]);
    fault.check(&underbrush!["generate", scene, "--reaches", "1", "--out", set]);
    assert_empty(outputs.path());
}

/// Tests that an arm file with a negative stiffness is refused with its line when a scene uses it.
#[test]
fn bad_arm() {
    let folder = tempfile::tempdir().unwrap();
    let cody = Path::new(env!("CARGO_MANIFEST_DIR")).join("sim/arms/cody");
    crate::support::copy_tree(&cody, folder.path());
    let file = folder.path().join("cody.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    let line = text.lines().position(|line| line.trim_start().starts_with("stiffness_nm_per_rad")).unwrap();
    let changed: Vec<&str> = text
        .lines()
        .enumerate()
        .map(|(number, old)| if number == line { "stiffness_nm_per_rad = -30.0" } else { old })
        .collect();
    std::fs::write(&file, changed.join("\n")).unwrap();
    let scene = scenes::write(folder.path(), "scene.toml", &format!("{HEAD}arm = \"cody.toml\"\n"));
    let parts = ["stiffness_nm_per_rad", "found -30", "allowed:", "change"];
    Fault { file: &file, line: Some(line + 1), parts: &parts }.check(&underbrush!["reach", scene]);
}
