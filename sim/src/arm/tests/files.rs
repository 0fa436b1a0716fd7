use std::fs;
use std::path::Path;

use proptest::prelude::*;

use super::super::new::{NewArm, new_files};
use super::super::skin_file::read_layout;
use super::super::source::Source;
use super::super::{Arm, file};
use super::{altered_cody, cody_file};

#[test]
fn cody_from_disk_is_cody() {
    // Tests that a user's files are read like the embedded ones.
    let folder = tempfile::tempdir().unwrap();
    for name in ["cody.toml", "cody.urdf", "cody.skin.toml"] {
        fs::write(folder.path().join(name), cody_file(Path::new(name)).unwrap()).unwrap();
    }
    let loaded = Arm::load(folder.path().join("cody.toml")).unwrap();
    let embedded = Arm::cody().unwrap();
    assert_eq!(format!("{loaded:?}"), format!("{embedded:?}"));
    fs::remove_file(folder.path().join("cody.urdf")).unwrap();
    let error = Arm::load(folder.path().join("cody.toml")).unwrap_err();
    assert!(error.file.ends_with("cody.urdf") && error.field == "file", "{error}");
}

#[test]
fn bad_values_are_refused_with_their_place() {
    // Tests that every kind of bad value gives an error that names one of the arm's files and the field. Each case
    // holds the file, the original text, its replacement, a part of the error's field, and a part of its text.
    #[rustfmt::skip]
    let cases = [
        ("cody.toml", "name = \"cody\"\n", "name = \"cody\"\ncolour = 1\n", "TOML", "colour"),
        ("cody.toml", "stiffness_nm_per_rad = 20.0", "stiffness_nm_per_rad = -20.0", "shoulder_flexion.stiffness", "-20"),
        ("cody.toml", "stiffness_nm_per_rad = 50.0", "stiffness_nm_per_rad = nan", "shoulder_abduction.stiffness", "NaN"),
        ("cody.toml", "damping_nm_s_per_rad = 5.73", "damping_nm_s_per_rad = -1.0", "damping", "-1"),
        ("cody.toml", "damping_nm_s_per_rad = 5.73", "damping_nm_s_per_rad = inf", "damping", "inf"),
        ("cody.toml", "model_stiffness_nm_per_rad = 3.2", "model_stiffness_nm_per_rad = 0.0", "model_stiffness", "0"),
        ("cody.toml", "[-47.61, 120.0]", "[120.0, -47.61]", "controller_limits_deg", "smaller first"),
        ("cody.toml", "[-47.61, 120.0]", "[-47.61, 130.0]", "controller_limits_deg", "within the URDF"),
        ("cody.toml", "start_deg = 122.0", "start_deg = 150.0", "elbow_flexion.start_deg", "150"),
        ("cody.toml", "friction = 0.3", "friction = -0.3", "friction", "-0.3"),
        ("cody.toml", "name = \"wrist_yaw\"", "name = \"wrist_roll\"", "joint[6].name", "wrist_roll"),
        ("cody.toml", "name = \"wrist_yaw\"", "name = \"wrist_pitch\"", "joint[6].name", "wrist_pitch"),
        ("cody.toml", "tip_link = \"flipper_tip\"", "tip_link = \"hand\"", "tip_link", "hand"),
        ("cody.toml", "tip_link = \"flipper_tip\"", "tip_link = \"forearm\"", "tip_link", "flipper, flipper_tip"),
        ("cody.toml", "tip_link = \"flipper_tip\"", "tip_link = \"torso\"", "tip_link", "the last moving link"),
        ("cody.toml", "base_link = \"torso\"", "base_link = \"pelvis\"", "base_link", "torso, upper_arm"),
        ("cody.toml", "base_link = \"torso\"", "base_link = \"flipper\"", "link flipper", "no moving joint"),
        ("cody.toml", "link = \"flipper\"", "link = \"paddle\"", "hull[0].link", "paddle"),
        ("cody.toml", "urdf = \"cody.urdf\"", "urdf = \"other.urdf\"", "file", "no such file"),
        ("cody.toml", "points_m = [\n", "points_m = []\nother = [\n", "TOML", "other"),
        ("cody.urdf", "<mass value=\"2.0036\"/>", "<mass value=\"-1\"/>", "link shoulder, inertial.mass", "-1"),
        ("cody.urdf", "<mass value=\"2.0036\"/>", "<mass value=\"0\"/>", "link shoulder, inertial", "no mass"),
        ("cody.urdf", "ixx=\"0.003056\"", "ixx=\"-0.003056\"", "link shoulder, inertial.inertia", "principal moments"),
        ("cody.urdf", "ixx=\"0.003056\"", "ixx=\"0.3\"", "link shoulder, inertial.inertia", "sum of the other two"),
        ("cody.toml", "friction = 0.3", "friction = 0.3\n[[inertia]]\nlink = \"elbow\"\nentries_kg_m2 = [3, 0, 0, 1, 0, 1]", "inertia[0].entries_kg_m2", "sum of the other two"),
        ("cody.toml", "friction = 0.3", "friction = 0.3\n[[inertia]]\nlink = \"paddle\"\nentries_kg_m2 = [1, 0, 0, 1, 0, 1]", "inertia[0].link", "paddle"),
        ("cody.urdf", "ixx=\"0.003056\"", "ixx=\"nan\"", "link shoulder, inertial.inertia", "NaN"),
        ("cody.urdf", "<axis xyz=\"0 -1 0\"/>", "<axis xyz=\"0 0 0\"/>", "joint shoulder_flexion, axis", "not all zero"),
        ("cody.urdf", "lower=\"-0.8310\"", "lower=\"3\"", "joint shoulder_flexion, limit", "lower below upper"),
        ("cody.urdf", "effort=\"40\"", "effort=\"0\"", "joint shoulder_flexion, limit.effort", "0.001 to 100000 N m"),
        ("cody.urdf", "velocity=\"0.87266\"", "velocity=\"nan\"", "joint shoulder_flexion, limit.velocity", "NaN"),
        ("cody.urdf", "xyz=\"0 -0.18493 0\"", "xyz=\"0 inf 0\"", "joint shoulder_abduction, origin", "inf"),
        ("cody.urdf", "xyz=\"0 -0.18493 0\"", "xyz=\"0 one 0 0\"", "joint shoulder_abduction, origin.xyz", "3 numbers"),
        ("cody.urdf", "<mass value=\"2.0036\"/>", "<mass value=\"heavy\"/>", "link shoulder, inertial.mass.value", "heavy"),
        ("cody.urdf", "<mass value=\"2.0036\"/>", "<mass/>", "link shoulder, inertial.mass.value", "no attribute"),
        ("cody.urdf", "<mass value=\"2.0036\"/>", "", "link shoulder, inertial", "no <mass>"),
        ("cody.urdf", "<mass value=\"2.0036\"/>", "<mass value=\"2\"/><mass value=\"3\"/>", "link shoulder, inertial", "2 <mass>"),
        ("cody.urdf", "<sphere radius=\"0.06\"/>", "<sphere radius=\"0.06\"/><box size=\"1 1 1\"/>", "link shoulder, collision.geometry", "2 <box>"),
        ("cody.urdf", "<sphere radius=\"0.06\"/>", "<ball radius=\"0.06\"/>", "link shoulder, collision.geometry", "no <box>"),
        ("cody.urdf", "<parent link=\"wrist\"/>", "", "joint wrist_yaw", "no <parent>"),
        ("cody.urdf", "type=\"revolute\"", "type=\"prismatic\"", "joint shoulder_flexion, type", "prismatic"),
        ("cody.urdf", "type=\"revolute\"", "type=\"rotary\"", "joint shoulder_flexion, type", "rotary"),
        ("cody.urdf", "<child link=\"elbow\"/>", "<child link=\"knee\"/>", "joint elbow_flexion, child", "knee"),
        ("cody.urdf", "<child link=\"elbow\"/>", "<child link=\"wrist\"/>", "child", "another joint"),
        ("cody.urdf", "<child link=\"flipper_tip\"/>", "<child link=\"torso\"/>", "link torso", "loop"),
        ("cody.urdf", "<parent link=\"wrist\"/>", "<parent link=\"forearm\"/>", "joint wrist_yaw, parent", "wrist_pitch and wrist_yaw"),
        ("cody.urdf", "<sphere radius=\"0.06\"/>", "<sphere radius=\"0\"/>", "link shoulder, collision", "sizes of"),
        ("cody.urdf", "<sphere radius=\"0.06\"/>", "<mesh filename=\"a.stl\"/>", "link shoulder, collision", "hull"),
        ("cody.urdf", "<link name=\"flipper_tip\"/>", "<link name=\"wrist\"/>", "link wrist, name", "second"),
        ("cody.urdf", "</robot>", "", "robot", ""),
        ("cody.skin.toml", "technology = \"fabric\"", "technology = \"wool\"", "TOML", "wool"),
        ("cody.skin.toml", "stiffness_n_per_m3 = 3e7", "stiffness_n_per_m3 = 0", "stiffness_n_per_m3", "0"),
        ("cody.skin.toml", "link = \"forearm\"", "link = \"thigh\"", "patch[0].link", "thigh"),
        ("cody.skin.toml", "name = \"flipper\"", "name = \"forearm\"", "patch[1].name", "forearm"),
        ("cody.skin.toml", "name = \"flipper\"", "name = \"a/b\"", "patch[1].name", "without \"/\""),
        ("cody.skin.toml", "axis = [0.0, 0.0, -1.0]", "axis = [0.0, 0.0, 0.0]", "cylinder.axis", "not all zero"),
        ("cody.skin.toml", "zero_angle = [1.0, 0.0, 0.0]", "zero_angle = [0.0, 0.0, 1.0]", "zero_angle", "across the axis"),
        ("cody.skin.toml", "radius_m = 0.04604", "radius_m = nan", "radius_m", "NaN"),
        ("cody.skin.toml", "rows = 16", "rows = 0", "rows", "0"),
        ("cody.skin.toml", "taxel_size_m = 0.009", "taxel_size_m = 0.0115", "taxel_size_m", "overlap"),
        ("cody.skin.toml", "-157.58", "-187.58", "taxel_size_m", "overlap"),
        ("cody.skin.toml", "[patch.points]", "[patch.dots]", "TOML", "dots"),
        ("cody.skin.toml", "normal = [-0.47474, 0.82228, -0.31381]", "normal = [0, 0, 0]", "taxels[0].normal", "not all zero"),
        ("cody.skin.toml", "[-0.00221, 0.02343, -0.22080]", "[nan, 0.02343, -0.22080]", "taxels[0].position_m", "NaN"),
        ("cody.skin.toml", "derived_area_limits_m2 = [1e-4, 15e-4]", "", "taxels[0].area_m2", "none"),
        ("cody.skin.toml", "[1e-4, 15e-4]", "[15e-4, 1e-4]", "derived_area_limits_m2", "smaller first"),
    ];
    for (name, from, to, field, text) in cases {
        let error = altered_cody(name, from, to).err().unwrap_or_else(|| panic!("{to:?} was accepted in {name}"));
        let file = error.file.to_string_lossy();
        assert!(file.ends_with(".toml") || file.ends_with(".urdf"), "{to:?}: {error}");
        assert!(error.field.contains(field), "{to:?}: {error}");
        assert!(error.to_string().contains(text), "{to:?}: {error}");
        assert!(!error.remedy.is_empty());
    }
}

#[test]
fn errors_name_the_line() {
    // Tests the line numbers of errors at a key of a later table, at an XML element and of a parse error. Each is the
    // line of the altered text.
    for (name, from, to) in [
        ("cody.toml", "damping_nm_s_per_rad = 1.43", "damping_nm_s_per_rad = -1.43"),
        ("cody.toml", "start_deg = 122.0", "start_deg = 1220.0"),
        ("cody.toml", "tip_link = \"flipper_tip\"", "tip_link = \"nowhere\""),
        ("cody.toml", "base_link = \"torso\"", "base_link = \"nowhere\""),
        (
            "cody.urdf",
            "<link name=\"elbow\">",
            "<link name=\"elbow\"><inertial><mass value=\"-1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial></link><link name=\"spare\">",
        ),
        ("cody.skin.toml", "row_pitch_m = 0.0108", "row_pitch_m = \"wide\""),
        ("cody.skin.toml", "position_m = [0.02442, 0.01410, -0.21740]", "position_m = [inf, 0.01410, -0.21740]"),
    ] {
        let text = cody_file(Path::new(name)).unwrap();
        let line = text[..text.find(from).unwrap()].lines().count().max(1);
        let line = if text[..text.find(from).unwrap()].ends_with('\n') { line + 1 } else { line };
        let error = altered_cody(name, from, to).unwrap_err();
        assert_eq!(error.line, Some(line), "{error}");
        assert_eq!(error.file, Path::new(name));
    }
}

/// Tests that an error about a key of an inline table is at the line of that table, and not at that of a later patch with this
/// key.
#[test]
fn errors_name_the_line_of_an_inline_table() {
    let keys = [
        "row_0_m = [0, 0, 0]",
        "axis = [0, 0, 1]",
        "zero_angle = [1, 0, 0]",
        "radius_m = 0.05",
        "rows = 1",
        "row_pitch_m = 0.01",
        "taxel_size_m = 0.009",
        "wraps = false",
        "column_angles_deg = [0]",
    ];
    let inline = keys.join(", ").replace("0.05", "99.0");
    let text = format!(
        "stiffness_n_per_m3 = 3e7\n[[patch]]\nname = \"one\"\nlink = \"rod\"\ncylinder = {{ {inline} }}\n\
         [[patch]]\nname = \"two\"\nlink = \"rod\"\n[patch.cylinder]\n{}\n",
        keys.join("\n")
    );
    let error = read_layout(&Source { path: "rod.skin.toml".into(), text }).unwrap_err();
    assert_eq!((error.field.as_str(), error.line), ("patch[0].cylinder.radius_m", Some(5)), "{error}");
}

/// Tests that a fault in a URDF is reported with the line of its element, also for tags that span several lines and for
/// a second shape.
#[test]
fn urdf_faults_name_the_line_of_the_element() {
    let second = "<collision>\n<geometry><sphere radius=\"0.035\"/></geometry>\n</collision>\n";
    let bad = "<collision>\n<geometry>\n<sphere\nradius=\"1e9\"/></geometry>\n</collision>\n";
    for (from, to, below) in [
        ("<mass value=\"2.0036\"/>", "<mass value=\"1e30\"/>", 0),
        ("<mass value=\"2.0036\"/>", "\n\n<mass\nvalue=\"heavy\"/>", 2),
        ("effort=\"40\"", "effort=\"1e300\"", 0),
        ("<axis xyz=\"-1 0 0\"/>", "<axis xyz=\"-1e-300 0 0\"/>", 0),
        ("<collision>", &format!("{second}{bad}<collision>"), 4),
    ] {
        let text = cody_file(Path::new("cody.urdf")).unwrap();
        let line = text[..text.find(from).unwrap()].matches('\n').count() + 1;
        let error = altered_cody("cody.urdf", from, to).unwrap_err();
        assert_eq!(error.line, Some(line + below), "{error}");
    }
}

/// Tests that a mesh that is not there is reported with the line of its own element, and not with that of the link's first one.
#[test]
fn a_missing_mesh_has_its_own_line() {
    let folder = tempfile::tempdir().unwrap();
    let part = |mesh: &str| format!("<collision><geometry><mesh filename=\"{mesh}\"/></geometry></collision>\n");
    let urdf = format!(
        "<robot name=\"rod\"><link name=\"base\"/>\n<link name=\"rod\">\n{}{}</link>\n\
         <joint name=\"hinge\" type=\"revolute\"><parent link=\"base\"/><child link=\"rod\"/><axis xyz=\"0 0 1\"/>\
         <limit lower=\"-1\" upper=\"1\" effort=\"10\" velocity=\"1\"/></joint></robot>",
        part("one.obj"),
        part("two.obj")
    );
    let [urdf_path, mesh, out] = ["rod.urdf", "one.obj", "rod.toml"].map(|name| folder.path().join(name));
    fs::write(&urdf_path, urdf).unwrap();
    let corners = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\n";
    fs::write(mesh, format!("{corners}f 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n")).unwrap();
    let new = NewArm { urdf: urdf_path, out, tip_link: "rod".into(), hulls_per_mesh: 1, ..NewArm::default() };
    let error = new_files(&new).unwrap_err();
    assert!(error.found.starts_with("two.obj") && error.line == Some(4), "{error}");
}

/// Tests that names with combining accents, as some systems write them in names of files, and with quotation marks reach the files
/// of a new arm.
#[test]
fn names_of_new_files_may_have_accents_and_quotes() {
    let folder = tempfile::tempdir().unwrap();
    let name = "ti\u{301}p";
    let urdf = cody_file(Path::new("cody.urdf")).unwrap().replace("\"flipper_tip\"", &format!("\"{name}\""));
    let [urdf_path, out] = ["co\u{301}dy.urdf", "co\u{301}\"dy.toml"].map(|name| folder.path().join(name));
    fs::write(&urdf_path, urdf).unwrap();
    let new = NewArm { urdf: urdf_path, out, tip_link: name.into(), hulls_per_mesh: 1, ..NewArm::default() };
    let made = new_files(&new).unwrap();
    let file: toml::Table = made.arm_file.parse().unwrap();
    assert_eq!(["urdf", "tip_link"].map(|key| file[key].as_str().unwrap()), ["co\u{301}dy.urdf", name]);
    let scene: toml::Table = made.scene.1.parse().unwrap();
    assert_eq!(scene["arm"].as_str(), Some("co\u{301}\"dy.toml"));
}

/// Tests that a URDF with many nested elements is refused with its line and does not overflow the stack.
#[test]
fn deeply_nested_elements_are_refused() {
    let nested = format!("{}{}</robot>", "<a>".repeat(40_000), "</a>".repeat(40_000));
    let error = altered_cody("cody.urdf", "</robot>", &nested).unwrap_err();
    assert!(error.found.contains("nested elements"), "{error}");
    assert!(error.line.is_some());
}

/// Tests that a skin with more taxels than a frame can number is refused when it is read, whatever its rows and
/// columns.
#[test]
fn skins_of_too_many_taxels_are_refused() {
    for rows in ["rows = 2800", "rows = 18446744073709551"] {
        let error = altered_cody("cody.skin.toml", "rows = 16", rows).unwrap_err();
        assert!(error.allowed.contains("65536 taxels"), "{error}");
    }
}

/// Tests that a skin that cannot sense contact is refused when it is read: under the surface, off it, facing inwards,
/// or on a link without a collision shape. Also tests that a patch that is slightly off is called doubtful, and Cody's
/// own skin is not.
#[test]
fn skins_that_cannot_feel_are_refused() {
    let forearm = "<geometry><cylinder radius=\"0.04604\" length=\"0.237\"/></geometry>";
    let with_radius = |radius_m: f64| forearm.replace("0.04604", &radius_m.to_string());
    let first = "position_m = [-0.00221, 0.02343, -0.22080], normal = [-0.47474, 0.82228, -0.31381]";
    #[rustfmt::skip]
    let cases = [
        ("cody.urdf", forearm, with_radius(0.08), "patch forearm, taxel 0", "mm under the collision surface of link forearm"),
        ("cody.urdf", forearm, with_radius(0.02), "patch forearm, taxel 0", "26.0 mm above the collision surface"),
        ("cody.urdf", "<origin xyz=\"0 0 0.13003\"/>", "<origin xyz=\"0 0.5 0.13003\"/>".into(), "patch forearm", "above"),
        ("cody.skin.toml", "link = \"forearm\"", "link = \"shoulder_yoke\"".into(), "taxel 0", "without a collision shape"),
        ("cody.skin.toml", first, first.replace("normal = [-0.47474, 0.82228", "normal = [0.47474, -0.82228"), "patch flipper, taxel 0", "points into"),
        ("cody.skin.toml", first, first.replace("0.02343", "0.12343"), "patch flipper, taxel 0", "above"),
    ];
    for (name, from, to, field, text) in cases {
        let error = altered_cody(name, from, &to).unwrap_err();
        assert!(error.field.contains(field) && error.found.contains(text), "{to}: {error}");
        assert!(error.file == Path::new("cody.skin.toml") && error.line.is_some(), "{error}");
    }
    assert_eq!(Arm::cody().unwrap().skin_doubts(), [""; 0]);
    let thick = altered_cody("cody.urdf", forearm, &with_radius(0.0535)).unwrap();
    let doubts = thick.skin_doubts();
    assert!(doubts.len() == 1 && doubts[0].contains("384 of 384 taxels"), "{doubts:?}");
}

#[test]
fn rigidly_joined_links_become_one() {
    // Tests merging: a forearm that a fixed joint splits into two halves of known inertia has the mass, centre and
    // inertia that the parallel-axis theorem gives, and skin and shapes may still name the second half.
    let split = r#"<link name="forearm"><inertial><origin xyz="0 0 0.1"/><mass value="1"/>
        <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.0015"/></inertial></link>
        <joint name="seam" type="fixed"><parent link="forearm"/><child link="sleeve"/>
        <origin xyz="0 0 0.2" rpy="0 0 1.5707963267948966"/></joint>
        <link name="sleeve"><inertial><origin xyz="0 0 0.1"/><mass value="3"/>
        <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.0015"/></inertial>
        <collision><origin xyz="0 0 0.13003"/><geometry><cylinder radius="0.04604" length="0.237"/></geometry></collision>
        </link>
        <link name="old_forearm">"#;
    let arm = file::assemble(Path::new("cody.toml"), &|path: &Path| {
        let text = cody_file(path)?;
        Ok(match path.to_str() {
            Some("cody.urdf") => text.replacen("<link name=\"forearm\">", split, 1),
            Some("cody.skin.toml") => text.replacen("link = \"forearm\"", "link = \"sleeve\"", 1),
            _ => text,
        })
    })
    .unwrap();
    let link = &arm.links[5];
    assert_eq!((link.name.as_str(), arm.links.len()), ("forearm", 8));
    assert!((link.mass_kg - 4.0).abs() < 1e-12);
    // 1 kg at z = 0.1 and 3 kg at 0.3: centre at 0.25, Steiner part 1 · 0.15² + 3 · 0.05² = 0.03.
    assert!((link.center_of_mass_link.z - 0.25).abs() < 1e-12);
    let diagonal = [link.inertia_link.x_axis.x, link.inertia_link.y_axis.y, link.inertia_link.z_axis.z];
    for (found, expected) in diagonal.iter().zip([0.001 + 0.002 + 0.03, 0.002 + 0.001 + 0.03, 0.003]) {
        assert!((found - expected).abs() < 1e-12, "{diagonal:?}");
    }
    let patch = &arm.skin.layout.patches[0];
    assert_eq!((patch.link.as_str(), arm.skin.surfaces[0].link), ("forearm", 5));
    let plain = Arm::cody().unwrap().skin.layout.patches[0].taxels[0];
    let moved = patch.taxels[0];
    assert!((moved.position_link.z - plain.position_link.z - 0.2).abs() < 1e-12);
    assert!((moved.normal_link.x + plain.normal_link.y).abs() < 1e-12);
    assert!((moved.normal_link.y - plain.normal_link.x).abs() < 1e-12);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    #[test]
    fn damaged_files_never_panic(which in 0usize..3, at in 0.0..1.0f64, length in 0usize..40, insert in ".{0,6}") {
        // Tests that a file with any damage gives an error or an arm, never a panic.
        let name = ["cody.toml", "cody.urdf", "cody.skin.toml"][which];
        let result = file::assemble(Path::new("cody.toml"), &|path: &Path| {
            let text = cody_file(path)?;
            if path != Path::new(name) {
                return Ok(text);
            }
            let mut characters: Vec<char> = text.chars().collect();
            let start = (at * characters.len() as f64) as usize;
            let end = (start + length).min(characters.len());
            characters.splice(start..end, insert.chars());
            Ok(characters.into_iter().collect())
        });
        match result {
            Ok(arm) => prop_assert!(arm.links.len() == arm.joints.len() + 1),
            Err(error) => prop_assert!(!error.field.is_empty() && !error.remedy.is_empty()),
        }
    }
}
