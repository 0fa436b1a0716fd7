//! `underbrush reach`.

use underbrush_recording::disk::read_recording;

use crate::support::{arm, scenes, underbrush};

/// Tests that the same seed gives the same recording byte for byte, and that another seed or index gives another
/// clutter.
#[test]
fn a_seed_decides_a_reach() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "leaf.toml", scenes::FEW_LEAVES);
    let run = |name: &str, seed: &str, index: &str| {
        let path = folder.path().join(name);
        underbrush!["reach", scene, "--seed", seed, "--index", index, "--out", path].success();
        path
    };
    let [first, again] = ["first.parquet", "again.parquet"].map(|name| run(name, "7", "0"));
    assert!(std::fs::read(&first).unwrap() == std::fs::read(again).unwrap());
    let first = read_recording(&first).unwrap();
    for (name, seed, index) in [("seed.parquet", "8", "0"), ("index.parquet", "7", "1")] {
        let other = read_recording(&run(name, seed, index)).unwrap();
        assert_ne!(first.objects, other.objects);
        assert_ne!(first.goals[0].position_world, other.goals[0].position_world);
    }
}

/// Tests that `reach --seed --index` runs the same reach as `generate`.
#[test]
fn a_reach_is_that_of_its_campaign() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let [set, file] = ["set", "reach.parquet"].map(|name| folder.path().join(name));
    underbrush!["generate", scene, "--reaches", "2", "--seed", "6", "--out", set].success();
    underbrush!["reach", scene, "--seed", "6", "--index", "1", "--out", file].success();
    let in_set = underbrush_recording::disk::Dataset::open(set).unwrap().read_reach(1).unwrap();
    assert!(in_set == read_recording(&file).unwrap());
}

/// Tests that goals reached, true contact, contacts and peak force in the JSON output agree with the recording, and
/// that the picture is a PNG.
#[test]
fn the_report_agrees_with_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::TRUNKS_AT_FOREARM);
    let [file, picture] = ["reach.parquet", "reach.png"].map(|name| folder.path().join(name));
    let report = underbrush!["reach", scene, "--out", file, "--picture", picture, "--json"].json();
    let recording = read_recording(&file).unwrap();
    assert_eq!(report["goals_reached"], recording.goal_outcomes().reached);
    assert_eq!(report["goals"].as_array().unwrap().len(), recording.goals.len());
    assert_eq!(report["touched_frames"]["forearm"], recording.touched_frames()["forearm"]);
    assert_eq!(report["contacts"], recording.contacts.len());
    let peak = recording.contacts.iter().map(|contact| contact.peak_force_n).fold(0.0, f64::max);
    assert_eq!(report["peak_contact_force_n"], peak);
    assert_eq!(report["simulated_s"], recording.frames.len() as f64 / 100.0);
    assert!(std::fs::read(picture).unwrap().starts_with(b"\x89PNG"));
}

/// Tests that a pair of kinds that is switched off passes through each other and another pair does not: the forearm leans on the
/// trunk unless `passing` names both, in either order. Also tests that an unknown kind is refused.
#[test]
fn pairs_of_kinds_can_be_switched_off() {
    let folder = tempfile::tempdir().unwrap();
    let contacts = |passing: &str| {
        let text = format!("passing = {passing}\n{}", scenes::TRUNKS_AT_FOREARM);
        let scene = scenes::write(folder.path(), "trunk.toml", &text);
        underbrush!["reach", scene, "--json"].json()["contacts"].as_u64().unwrap()
    };
    let all = contacts("[]");
    assert!(all > 0);
    assert_eq!(contacts(r#"[["leaf", "trunk"]]"#), all);
    for pair in [r#"[["arm", "trunk"]]"#, r#"[["trunk", "arm"]]"#] {
        assert_eq!(contacts(pair), 0, "{pair}");
    }
    let text = format!("passing = [[\"arm\", \"bush\"]]\n{}", scenes::TRUNKS_AT_FOREARM);
    underbrush!["reach", scenes::write(folder.path(), "bush.toml", &text)].refused(&["\"bush\"", "arm, table, trunk"]);
}

/// Tests that outputs under the names of other formats are refused before anything is simulated.
#[test]
fn wrong_endings_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::TRUNKS_AT_FOREARM);
    for (option, name, right) in [("--picture", "reach.svg", ".png"), ("--out", "reach.csv", ".parquet")] {
        let path = folder.path().join(name);
        let answer = underbrush!["reach", scene, option, path, "--json"];
        answer.refused(&[name, &format!("ends in {right}")]);
        assert!(answer.stdout.contains("\"kind\":\"input\""), "{}", answer.stdout);
        assert!(!path.exists());
    }
}

/// Tests that the page of --watch has the port that is asked for, and that options of the page are refused without it.
#[test]
fn the_port_of_the_page_can_be_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let taken = std::net::TcpListener::bind((std::net::Ipv4Addr::LOCALHOST, 0)).unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let answer = underbrush!["reach", scene, "--watch", "--no-open", "--port", port];
    assert_eq!(answer.status, 1, "{}", answer.stderr);
    assert!(answer.stderr.contains(&format!("port {port}")), "{}", answer.stderr);
    underbrush!["reach", scene, "--port", port].refused(&["--watch"]);
    underbrush!["reach", scene, "--no-open"].refused(&["--watch"]);
}

/// Tests that --controller replaces the controller of the scene, and that the recording names it.
#[test]
fn the_blind_controller_pushes_on() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let file = folder.path().join("reach.parquet");
    let report = underbrush!["reach", scene, "--controller", "blind", "--out", file, "--json"].json();
    assert_eq!(report["controller"], "blind");
    assert_eq!(read_recording(&file).unwrap().controller, "blind");
}

/// Tests that arms without a patch called `forearm` work: trials are those of the first patch unless another is named,
/// a patch without a grid has no components, and bare arms have no trials.
#[test]
fn any_skin_is_summed_up() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("reach.parquet");
    let reach = |scene: &std::path::Path, patch: &[&str]| {
        let _ = std::fs::remove_file(&out);
        let mut arguments = vec!["reach".into(), scene.into(), "--out".into(), out.clone().into(), "--json".into()];
        arguments.extend(patch.iter().map(Into::into));
        crate::support::call(arguments, "")
    };
    let scene = arm::write(folder.path(), arm::renamed);
    let report = reach(&scene, &[]).json();
    assert_eq!(report["patch"], "sleeve");
    assert!(report["component_trials"].is_u64(), "{report}");
    assert_eq!(read_recording(&out).unwrap().layout.patches[0].name, "sleeve");
    let report = reach(&scene, &["--patch", "flipper"]).json();
    assert_eq!(report["patch"], "flipper");
    assert!(report["taxel_trials"].is_u64() && report["component_trials"].is_null(), "{report}");
    let unknown = reach(&scene, &["--patch", "forearm"]);
    unknown.refused(&["no patch named \"forearm\"", "sleeve", "flipper"]);
    assert!(!out.exists(), "an unknown patch is refused before the reach is run");

    let scene = arm::write(folder.path(), arm::flipper_alone);
    let report = reach(&scene, &[]).json();
    assert_eq!(report["patch"], "flipper");
    let scene = arm::write(folder.path(), arm::bare);
    let report = reach(&scene, &[]).json();
    assert!(report["patch"].is_null() && report["taxel_trials"].is_null(), "{report}");
    assert!(out.exists());
}

/// Tests that trials are extracted, scored and classified on the first patch whatever its name, and that the table
/// names it.
#[test]
fn the_first_patch_is_the_default_everywhere() {
    let folder = tempfile::tempdir().unwrap();
    let [cody, renamed] = ["cody", "renamed"].map(|name| {
        let folder = folder.path().join(name);
        std::fs::create_dir(&folder).unwrap();
        let skin = |text: &str| {
            if name == "cody" { text.to_owned() } else { arm::renamed(text) }
        };
        let (scene, out) = (arm::write(&folder, skin), folder.join("reach.parquet"));
        underbrush!["reach", scene, "--seed", "1", "--out", out].success();
        out
    });
    let table = |recording: &std::path::Path| {
        let table = recording.with_extension("csv");
        underbrush!["trials", recording, "--out", table].success();
        std::fs::read_to_string(table).unwrap()
    };
    assert_eq!(table(&cody).replace("forearm", "sleeve"), table(&renamed));
    let model = crate::support::fixture::fixture().model();
    for command in ["score", "classify"] {
        let both = [&cody, &renamed].map(|recording| underbrush![command, model, recording].success());
        assert!(both[0] == both[1] && both[0].lines().count() > 1, "{command}");
    }
}

/// Tests that a scene that ships is found by its name, and gives the same reach as its file; another name is refused with
/// the names that there are.
#[test]
fn a_scene_has_a_name() {
    let folder = tempfile::tempdir().unwrap();
    let [by_name, by_file] = ["name.parquet", "file.parquet"].map(|name| folder.path().join(name));
    underbrush!["reach", "trunk-post", "--out", by_name].success();
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/engineered/trunk-post.toml");
    underbrush!["reach", file, "--out", by_file].success();
    assert_eq!(std::fs::read(by_name).unwrap(), std::fs::read(by_file).unwrap());
    underbrush!["inspect", "trunk-post"].success();
    underbrush!["reach", "trunk-pots"].refused(&["trunk-pots", "trunk-post", "or the path of a scene file"]);
}

/// Tests that `reach` says why the controller gave a goal up, and `inspect` that a goal has no way.
#[test]
fn a_goal_that_is_given_up_has_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let text = "summary = \"Two goals\"\ncontroller = \"mapped\"\n[goals]\npositions_m = [[0.6, -0.2, -0.3], [2.0, 2.0, 1.0]]\n\
                [[objects.trunk]]\ncount = 1\nplace = { x_m = 0.7, y_m = -0.5 }\n";
    let scene = scenes::write(folder.path(), "far.toml", text);
    let found = underbrush!["reach", scene, "--json"].json();
    let reason = found["goals"][1]["given_up"].as_str().unwrap();
    let table = underbrush!["reach", scene].success();
    assert!(found["goals"][0].get("given_up").is_none() && table.contains(&format!("stuck: {reason}")), "{table}");
    let doubt = underbrush!["inspect", scene, "--json"].json();
    assert_eq!(doubt["doubtful"], "1 of 2 goals have no way round all fixed obstacles");
}
