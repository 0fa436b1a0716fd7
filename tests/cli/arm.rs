//! `underbrush arm`, and `underbrush inspect` of an arm.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::support::{call, underbrush};

/// An arm of three joints with a mesh, and a hand with a finger that slides and one that mimics it.
fn write_urdf(folder: &Path) -> PathBuf {
    let link = |name: &str, geometry: &str| {
        format!(
            "<link name=\"{name}\"><inertial><origin xyz=\"0 0 0.15\"/><mass value=\"1\"/>\
             <inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.01\" iyz=\"0\" izz=\"0.002\"/></inertial>\
             <collision><origin xyz=\"0 0 0.15\"/><geometry>{geometry}</geometry></collision></link>"
        )
    };
    let joint = |name: &str, kind: &str, parent: &str, child: &str, rest: &str| {
        format!(
            "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/><child link=\"{child}\"/>{rest}</joint>"
        )
    };
    let turns = |at: f64, axis: &str, effort: f64| {
        format!(
            "<origin xyz=\"0 0 {at}\"/><axis xyz=\"{axis}\"/>\
             <limit lower=\"-2.5\" upper=\"2.5\" effort=\"{effort}\" velocity=\"1\"/>"
        )
    };
    let slides = "<axis xyz=\"0 1 0\"/><limit lower=\"0.01\" upper=\"0.04\" effort=\"10\" velocity=\"1\"/>";
    let mimics = format!("{slides}<mimic joint=\"left\" multiplier=\"-2\" offset=\"0.05\"/>");
    let text = [
        "<robot name=\"crane\"><link name=\"base\"/>".into(),
        link("pillar", "<cylinder radius=\"0.04\" length=\"0.3\"/>"),
        link("boom", "<mesh filename=\"package://crane/meshes/beam.obj\" scale=\"0.001 0.001 0.001\"/>"),
        link("hand", "<box size=\"0.05 0.05 0.3\"/>"),
        link("left_finger", "<box size=\"0.01 0.01 0.05\"/>"),
        link("right_finger", "<box size=\"0.01 0.01 0.05\"/>"),
        joint("turn", "revolute", "base", "pillar", &turns(0.1, "0 0 1", 90.0)),
        joint("lift", "revolute", "pillar", "boom", &turns(0.3, "0 1 0", 30.0)),
        joint("bend", "revolute", "boom", "hand", &turns(0.3, "0 1 0", 6.0)),
        "<link name=\"tip\"/>".into(),
        joint("end", "fixed", "hand", "tip", "<origin xyz=\"0 0 0.3\"/>"),
        joint("left", "prismatic", "hand", "left_finger", slides),
        joint("right", "prismatic", "hand", "right_finger", &mimics),
        "</robot>".into(),
    ];
    let file = folder.join("crane.urdf");
    std::fs::write(&file, text.concat()).unwrap();
    file
}

/// A beam of 60 × 60 × 300 mm, in millimetres, as eight corners and six faces.
fn write_mesh(folder: &Path) {
    let corners = (0..8).map(|bits| {
        let side = |bit: usize, half: i32| if bits >> bit & 1 == 1 { half } else { -half };
        format!("v {} {} {}\n", side(0, 30), side(1, 30), side(2, 150))
    });
    let faces = "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n";
    std::fs::create_dir_all(folder.join("crane/meshes")).unwrap();
    std::fs::write(folder.join("crane/meshes/beam.obj"), corners.collect::<String>() + faces).unwrap();
}

/// Tests the way from a URDF to a reach without an edit: the arm is sound, its numbers follow the rules of the file, skin is
/// added and drawn, and trunks touch it.
#[test]
fn from_a_urdf_to_a_reach() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = write_urdf(folder.path());
    write_mesh(folder.path());
    let arm = folder.path().join("crane.toml");
    let made = underbrush!["arm", "new", urdf, "--tip", "tip", "--out", arm, "--json"].json();
    assert_eq!(
        (&made["joints"], &made["hulls"], &made["held_joints"]),
        (&3.into(), &1.into(), &json!(["left", "right"]))
    );
    assert_eq!(made["links"], json!(["base", "pillar", "boom", "hand"]));
    let text = std::fs::read_to_string(&arm).unwrap();
    // The nearest to zero within the limits, and 0.05 − 2 · 0.01.
    assert!(
        text.contains("name = \"left\"\ndisplacement_m = 0.01") && text.contains("displacement_m = 0.03"),
        "{text}"
    );
    let found = underbrush!["inspect", arm, "--json"].json();
    let stiffness: Vec<f64> =
        found["chain"].as_array().unwrap().iter().map(|own| own["stiffness_nm_per_rad"].as_f64().unwrap()).collect();
    // 90 N m over 90 deg is more than 40 N m/rad; 30 and 6 N m over 90 deg are 19.1 and 3.8 N m/rad.
    assert_eq!(stiffness, [40.0, 19.0, 3.8]);
    // 2.5 rad are 143.24 deg.
    assert_eq!(found["chain"][0]["controller_limits_deg"], json!([-138.2, 138.2]));
    let skin = |link: &str, rest: &[&str]| {
        let options = ["--pitch-mm", "20", "--patch", link, "--json"];
        let first = ["arm".into(), "skin".into(), arm.clone().into_os_string(), "--link".into(), link.into()];
        call(first.into_iter().chain(options.iter().chain(rest).map(Into::into)).collect(), "")
    };
    skin("hand", &[]).refused(&["taxels cannot be touched", "inside of hand", "--prune"]);
    for link in ["hand", "boom"] {
        assert_eq!(skin(link, &["--prune"]).json()["doubtful"], json!([]));
    }
    // Goals are drawn for the first patch, which is not this one.
    assert_eq!(skin("pillar", &[]).json()["rows_and_columns"], json!([15, 12]));
    let still = folder.path().join("crane.png");
    let found = underbrush!["inspect", arm, "--still", still, "--json"].json();
    let patches = found["patches"].as_array().unwrap().iter().map(|own| own["name"].as_str().unwrap());
    let patches: Vec<&str> = patches.collect();
    assert_eq!((&found["doubtful"], patches), (&"nothing".into(), vec!["hand", "boom", "pillar"]));
    // The beams overlap at their joints, where they close like scissors.
    let wedges = found["wedges"].as_str().unwrap();
    assert!(wedges.contains("pillar and boom close like scissors as lift turns"), "{wedges}");
    assert!(std::fs::read(&still).unwrap().starts_with(b"\x89PNG"));
    let scene = folder.path().join("crane.trunks.toml");
    let touched = (0..3).map(|seed| underbrush!["reach", scene, "--seed", seed.to_string(), "--json"].json());
    let frames =
        |reach: Value| reach["touched_frames"].as_object().unwrap().values().map(|own| own.as_u64().unwrap()).sum();
    let frames: Vec<u64> = touched.map(frames).collect();
    assert!(frames.iter().sum::<u64>() > 100, "{frames:?}");
}

/// Tests that the text of `inspect` is a table of the joints, which lines up and has the numbers of the arm's file and URDF.
#[test]
fn the_chain_is_a_table() {
    let arm = Path::new(env!("CARGO_MANIFEST_DIR")).join("sim/arms/cody/cody.toml");
    let text = underbrush!["inspect", arm].success();
    let lines: Vec<&str> = text.lines().skip_while(|line| *line != "chain:").skip(1).take(9).collect();
    let cells = |line: usize| {
        lines[line].split("  ").map(str::trim).filter(|cell| !cell.is_empty()).collect::<Vec<_>>().join(" | ")
    };
    let titles = "joint | moves | limits_deg | controller_limits_deg | start_deg | stiffness_nm_per_rad | \
                  damping_nm_s_per_rad | torque_limit_nm | mass_kg | shapes";
    assert_eq!(cells(0), titles);
    // 2.5133 rad are 144.0 deg.
    let elbow = "elbow_flexion | elbow | 0.0 to 144.0 | 0.0 to 144.0 | 122.0 | 25.0 | 1.43 | 20.0 | 0.3388 | 1";
    assert_eq!(cells(5), elbow);
    let ends: Vec<usize> = lines.iter().map(|line| line.len()).collect();
    assert!(ends[2..].iter().all(|end| *end == ends[0]), "{text}");
}

/// Tests that scene and start posture of an arm whose shoulder is not over its base are at the shoulder, to the millimetre, that
/// `inspect` has words for a joint without limits, and that the next command can be copied if the path has a space.
#[test]
fn a_shoulder_beside_the_base_has_its_room() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = write_urdf(folder.path());
    write_mesh(folder.path());
    let text = std::fs::read_to_string(&urdf).unwrap().replace("xyz=\"0 0 0.1\"", "xyz=\"-1 2 0.1\"");
    std::fs::write(&urdf, text.replace("name=\"turn\" type=\"revolute\"", "name=\"turn\" type=\"continuous\""))
        .unwrap();
    let arm = folder.path().join("my crane.toml");
    let made = underbrush!["arm", "new", urdf, "--tip", "tip", "--out", arm].success();
    assert!(made.contains("my crane.toml' --link"), "{made}");
    let found = underbrush!["inspect", arm, "--json"].json();
    let tip_m: Vec<f64> = found["tip_at_start_m"].as_array().unwrap().iter().map(|own| own.as_f64().unwrap()).collect();
    assert!((tip_m[0] + 0.8).abs() < 0.1 && (tip_m[1] - 2.0).abs() < 0.01, "{tip_m:?}");
    let text = underbrush!["inspect", arm].success();
    assert!(text.contains("none") && !text.contains("null to null"), "{text}");
    let scene = std::fs::read_to_string(folder.path().join("my crane.trunks.toml")).unwrap();
    // 0.38 and 0.8 of 0.6 m.
    assert!(scene.contains("x_m = [-0.772, -0.52]\ny_m = [1.772, 2.228]"), "{scene}");
    underbrush!["inspect", folder.path().join("my crane.trunks.toml")].success();
}

/// Tests that a link whose inertia no body has is raised to the nearest of a body with a warning, and that the arm is then sound,
/// while without the table it is refused.
#[test]
fn an_inertia_of_no_body_is_raised() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = write_urdf(folder.path());
    write_mesh(folder.path());
    let text = std::fs::read_to_string(&urdf).unwrap();
    let (before, hand) = text.split_at(text.find("<link name=\"hand\">").unwrap());
    std::fs::write(&urdf, before.to_owned() + &hand.replacen("izz=\"0.002\"", "izz=\"0.03\"", 1)).unwrap();
    let arm = folder.path().join("crane.toml");
    let made = underbrush!["arm", "new", urdf, "--tip", "tip", "--out", arm, "--json"];
    assert!(made.stderr.contains("the inertia of hand") && made.stderr.contains("50.0 %"), "{}", made.stderr);
    assert_eq!(made.json()["raised_inertia"], json!(["hand"]));
    // 0.03 is 0.01 above 0.01 + 0.01; half of that goes to each of these.
    let table = "[[inertia]]\nlink = \"hand\"\n# ixx, ixy, ixz, iyy, iyz, izz\nentries_kg_m2 = [0.015, 0.0, 0.0, 0.015, 0.0, 0.03]\n";
    let text = std::fs::read_to_string(&arm).unwrap();
    assert!(text.contains(table), "{text}");
    underbrush!["inspect", arm].success();
    std::fs::write(&arm, text.replace(table, "")).unwrap();
    underbrush!["inspect", arm].refused(&["link hand, inertial.inertia", "sum of the other two", "[[inertia]]"]);
}

/// Tests that the errors of `arm new` name what they are about: the places where a mesh was sought, the links that can be the
/// tip, a joint of the chain that slides, has no limits or has a name twice, and a mesh or an arm that is too large or small.
#[test]
fn what_new_refuses() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = write_urdf(folder.path());
    let new = |tip: &str, rest: &[&str]| {
        let out = folder.path().join("crane.toml").into_os_string();
        let first = [
            "arm".into(),
            "new".into(),
            urdf.clone().into_os_string(),
            "--tip".into(),
            tip.into(),
            "--out".into(),
            out,
        ];
        call(first.into_iter().chain(rest.iter().map(Into::into)).collect(), "")
    };
    let sought = folder.path().join("crane/meshes/beam.obj").display().to_string();
    new("hand", &[]).refused(&["package://crane/meshes/beam.obj", &sought, "--package NAME=FOLDER"]);
    new("hand", &["--package", "crane=elsewhere"]).refused(&["elsewhere"]);
    write_mesh(folder.path());
    new("foot", &[]).refused(&["--tip", "\"foot\"", "pillar, boom, hand"]);
    new("left_finger", &[]).refused(&["joint left, type", "prismatic", "give --base left_finger, or --tip hand"]);
    new("hand", &["--base", "left_finger"]).refused(&["--tip", "joints carry on left_finger"]);
    new("tip", &["--base", "hand"]).refused(&["--tip", "\"tip\"", "turning joints carry on hand"]);
    new("boom", &[]).refused(&["--tip", "a reach of 0 m", "at least 0.1 m"]);
    let text = std::fs::read_to_string(&urdf).unwrap();
    let flat = folder.path().join("crane/meshes/flat.obj");
    std::fs::write(flat, "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 100 100 0\nf 1 2 3\nf 2 3 4\n").unwrap();
    let limit = "<limit lower=\"-2.5\" upper=\"2.5\" effort=\"30\" velocity=\"1\"/>";
    for (from, to, parts) in [
        ("package://crane/meshes", "meshes", ["mesh filename", "correct its name in the URDF"]),
        ("robot", "sdf", ["robot: found <sdf>", "root is <robot>"]),
        ("beam.obj", "flat.obj", ["link boom, collision: found meshes that are all flat", "give the link another"]),
        (limit, "", ["joint lift: found no <limit>", "effort and velocity"]),
        ("name=\"lift\"", "name=\"turn\"", ["joint turn is there twice", "rename one"]),
        ("scale=\"0.001 0.001 0.001\"", "", ["crane.urdf: hull", "`scale` of its meshes"]),
    ] {
        std::fs::write(&urdf, text.replace(from, to)).unwrap();
        new("hand", &[]).refused(&parts);
    }
    std::fs::write(&urdf, text).unwrap();
    assert!(!folder.path().join("crane.toml").exists());
    new("hand", &[]).success();
    new("hand", &[]).refused(&["--force"]);
}

/// Tests that the base is the root that the tip hangs on, that `arm new` keeps a skin file and says so, and that it warns if no
/// posture has the tip in front of the base.
#[test]
fn what_new_says() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = write_urdf(folder.path());
    write_mesh(folder.path());
    let arm = folder.path().join("crane.toml");
    let new = |text: &str| {
        std::fs::write(&urdf, text).unwrap();
        underbrush!["arm", "new", &urdf, "--tip", "tip", "--out", &arm, "--force"]
    };
    let text = std::fs::read_to_string(&urdf).unwrap();
    let made = new(&text.replace("<link name=\"base\"/>", "<link name=\"marker\"/><link name=\"base\"/>"));
    assert_eq!(made.stderr, "");
    let made = made.success();
    assert!(made.contains("crane.skin.toml and ") && made.contains("links: base, pillar"), "{made}");
    let skin = |patch: &str| {
        underbrush!["arm", "skin", &arm, "--link", "boom", "--pitch-mm", "20", "--patch", patch, "--prune"]
    };
    skin("a/b").refused(&["a unique name without \"/\"", "change the options"]);
    skin("boom").success();
    // It looks back and cannot bend over.
    let limits =
        |lower: &str, upper: &str, effort: &str| format!("lower=\"{lower}\" upper=\"{upper}\" effort=\"{effort}\"");
    let back =
        [("90", "3", "3.2"), ("30", "0", "1"), ("6", "0", "1")].iter().fold(text, |text, (effort, lower, upper)| {
            text.replace(&limits("-2.5", "2.5", effort), &limits(lower, upper, effort))
        });
    let made = new(&back);
    assert!(made.stderr.contains("warning: no posture was found"), "{}", made.stderr);
    let made = made.success();
    assert!(made.contains("crane.trunks.toml; kept "), "{made}");
    assert!(std::fs::read_to_string(folder.path().join("crane.skin.toml")).unwrap().contains("[[patch]]"));
}

/// Tests that nothing is said to stand out over hulls if the URDF has no meshes.
#[test]
fn an_arm_without_meshes_has_no_hulls() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = write_urdf(folder.path());
    let mesh = "<mesh filename=\"package://crane/meshes/beam.obj\" scale=\"0.001 0.001 0.001\"/>";
    let text = std::fs::read_to_string(&urdf).unwrap().replace(mesh, "<box size=\"0.06 0.06 0.3\"/>");
    std::fs::write(&urdf, text).unwrap();
    let made = underbrush!["arm", "new", urdf, "--tip", "tip", "--out", folder.path().join("crane.toml")].success();
    assert!(made.contains("\nno hulls of meshes\n"), "{made}");
}

/// Tests that a reach in which nothing touches the skin says so, and that one without skin does not.
#[test]
fn skin_that_nothing_touches_is_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    write_mesh(folder.path());
    let arm = folder.path().join("crane.toml");
    underbrush!["arm", "new", write_urdf(folder.path()), "--tip", "hand", "--out", arm].success();
    let scene = folder.path().join("far.toml");
    let text = "summary = \"A trunk\"\narm = \"crane.toml\"\n[workspace]\nx_m = [0.3, 0.5]\ny_m = [0.3, 0.5]\n\
                table_height_m = 0.3\n[goals]\ncount = 1\npositions_m = [[0.3, -0.2, 0.6]]\n";
    std::fs::write(&scene, text).unwrap();
    let warning = "nothing touched the skin";
    let bare = underbrush!["reach", scene];
    assert!(!bare.stderr.contains(warning) && bare.stdout.contains("true contact: no skin\n"), "{}", bare.stdout);
    underbrush!["arm", "skin", arm, "--link", "boom", "--pitch-mm", "20", "--patch", "boom", "--prune"].success();
    let answer = underbrush!["reach", scene];
    assert!(answer.stderr.contains(warning), "{}", answer.stderr);
}

/// Tests that the text of `inspect` has a line for each patch, with its taxels, its grid and their median distance.
#[test]
fn patches_are_a_table() {
    let arm = Path::new(env!("CARGO_MANIFEST_DIR")).join("sim/arms/cody/cody.toml");
    let text = underbrush!["inspect", arm].success();
    let lines = text.lines().skip_while(|line| *line != "patches:").skip(3).take(2);
    let lines: Vec<Vec<&str>> = lines.map(|line| line.split_whitespace().collect()).collect();
    // The rows of the forearm are 10.8 mm apart, its columns 12 mm.
    assert_eq!(lines[0], ["forearm", "forearm", "384", "16", "x", "24", "10.8"], "{text}");
    assert_eq!(lines[1][..4], ["flipper", "flipper", "69", "none"], "{text}");
}
