//! A data set contains everything that it was made from: `--resume` also compares the arm, and `generate --from` needs
//! nothing else to generate the set again.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use underbrush_recording::Recording;
use underbrush_recording::disk::{Dataset, DatasetPlan, DatasetWriter, Shard};

use super::resume::interrupted;
use crate::support::fixture::fixture;
use crate::support::{assert_same_trees, scenes, underbrush};

/// Writes a user's arm, which is Cody with all springs `scale` times as stiff, to its own folder, and a scene for it.
fn scene_with_own_arm(folder: &Path, scale: f64) -> PathBuf {
    let arm = folder.join("my-arm");
    fs::create_dir_all(&arm).unwrap();
    let cody = Path::new(env!("CARGO_MANIFEST_DIR")).join("sim/arms/cody");
    for name in ["cody.urdf", "cody.skin.toml"] {
        fs::copy(cody.join(name), arm.join(name)).unwrap();
    }
    let scaled = |line: &str| match line.strip_prefix("stiffness_nm_per_rad = ") {
        Some(stiffness) => {
            let stiffness: f64 = stiffness.split('#').next().unwrap().trim().parse().unwrap();
            format!("stiffness_nm_per_rad = {:?}\n", scale * stiffness)
        }
        None => format!("{line}\n"),
    };
    let text = fs::read_to_string(cody.join("cody.toml")).unwrap();
    let text: String = text.lines().map(scaled).collect();
    fs::write(arm.join("my-arm.toml"), text).unwrap();
    let scene = format!("arm = \"my-arm/my-arm.toml\"\n{}", scenes::FEW_TRUNKS);
    scenes::write(folder, "trunk.toml", &scene)
}

/// Tests that a set that was started with a user's arm cannot be resumed after the arm's springs were changed, that
/// the changed file is named, and that `inspect` names the arm's files.
#[test]
fn a_changed_arm_is_refused_on_resume() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("set");
    let scene = scene_with_own_arm(folder.path(), 1.0);
    interrupted(&scene, &out);
    scene_with_own_arm(folder.path(), 0.5);
    let resumed = || underbrush!["generate", scene, "--reaches", "8", "--seed", "3", "--out", out, "--resume"];
    resumed().refused(&["another plan", "provenance.arms", "my-arm.toml"]);
    scene_with_own_arm(folder.path(), 1.0);
    let skin = folder.path().join("my-arm/cody.skin.toml");
    let text = fs::read_to_string(&skin).unwrap();
    fs::write(&skin, format!("{text}\n# another remark\n")).unwrap();
    resumed().refused(&["another plan", "provenance.arms", "cody.skin.toml"]);
    fs::write(&skin, text).unwrap();
    resumed().success();
    let found = underbrush!["inspect", out].success();
    for name in ["my-arm.toml", "cody.urdf", "cody.skin.toml", "trunk.toml"] {
        assert!(found.contains(name), "{name} is not in\n{found}");
    }
}

/// Tests that a set can be generated again, byte for byte, from its own content: with a user's arm whose files are
/// gone, with two scenes, one of them with a saturation that is switched off by `inf`, and for one shard.
#[test]
fn a_set_is_made_again_from_itself() {
    let folder = tempfile::tempdir().unwrap();
    let [sources, shard, again, whole, whole_again] =
        ["sources", "shard", "again", "whole", "whole-again"].map(|name| folder.path().join(name));
    fs::create_dir(&sources).unwrap();
    let trunk = scene_with_own_arm(&sources, 0.8);
    // JSON has no infinity, so it is the stored text of the scene that keeps it.
    let leaf = format!("{}\n[sensor]\nsaturation_n = inf\n", scenes::FEW_LEAVES);
    let leaf = scenes::write(&sources, "leaf.toml", &leaf);
    #[rustfmt::skip]
    underbrush!["generate", leaf, trunk, "--reaches", "3", "--seed", "6", "--shard", "2/4", "--out", shard].success();
    #[rustfmt::skip]
    underbrush!["generate", trunk, "--reaches", "2", "--controller", "ijrr-foliage", "--out", whole].success();
    fs::remove_dir_all(&sources).unwrap();
    for (set, again) in [(&shard, &again), (&whole, &whole_again)] {
        let call = underbrush!["generate", "--from", set, "--out", again];
        // Nothing is said but that nothing touched the skin in the two reaches of the whole set.
        let other = call.stderr.lines().find(|line| !line.starts_with("warning: nothing touched the skin"));
        assert_eq!((call.status, other), (0, None));
        assert_same_trees(set, again);
    }
    let set = Dataset::open(&shard).unwrap();
    assert_eq!((set.episodes().len(), set.plan().provenance.arms.len()), (2, 2));
    let again = Dataset::open(&again).unwrap();
    assert!(again.plan().provenance.scenes[0].file.text.contains("saturation_n = inf"));
}

/// Tests the keys of the controller's parameters in a set's provenance, whatever the fields are called in the program.
#[test]
fn the_controllers_parameters_keep_their_keys() {
    let text = fs::read_to_string(fixture().dataset().join("meta/provenance.json")).unwrap();
    let file: serde_json::Value = serde_json::from_str(&text).unwrap();
    let scenes = file["provenance"]["controller_parameters"].as_object().unwrap();
    assert_eq!(scenes.len(), 2);
    for parameters in scenes.values() {
        let keys: BTreeSet<&str> = parameters.as_object().unwrap().keys().map(String::as_str).collect();
        let expected = [
            "contact_stiffness_n_per_m",
            "equilibrium_offset_rad",
            "equilibrium_reset_rad",
            "equilibrium_step_rad",
            "force_fall_n",
            "force_limit_n",
            "force_rise_n",
            "force_weight",
            "ignored_force_n",
            "name",
            "over_limit_force_change_n",
            "over_limit_force_reduction_n",
            "position_weight",
            "rate_hz",
            "reached_distance_m",
            "slow_distance_m",
            "stop_force_n",
            "stuck_distance_m",
            "stuck_window_s",
            "time_out_s",
            "tip_step_m",
            "torque_change_weight",
        ];
        assert_eq!(keys, BTreeSet::from(expected));
        assert_eq!(parameters["tip_step_m"], 0.02);
    }
}

/// Tests that options that contradict the set are refused, not ignored.
#[test]
fn options_beside_from_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("set");
    let set = fixture().dataset();
    for contradiction in [
        &["--seed", "2"][..],
        &["--reaches", "1"],
        &["--shard", "1/2"],
        &["--controller", "blind"],
        &["--verdicts", "truth", "--allow", "leaf=1"],
        &["scenes/leaf.toml"],
    ] {
        let mut arguments = vec!["generate".into(), "--from".into(), set.clone(), "--out".into(), out.clone()];
        arguments.extend(contradiction.iter().map(PathBuf::from));
        let arguments = arguments.into_iter().map(Into::into).collect();
        crate::support::call(arguments, "").refused(&["cannot be used with", "--from"]);
    }
    assert!(!out.exists());
}

/// Writes a copy of a data set with another plan and other reaches.
fn altered(
    from: &Path,
    to: &Path,
    change_plan: impl Fn(&mut DatasetPlan),
    change_reach: impl Fn(usize, &mut Recording),
) {
    let set = Dataset::open(from).unwrap();
    let mut plan = set.plan().clone();
    change_plan(&mut plan);
    let reaches = plan.episodes.len();
    let writer = DatasetWriter::create(to, plan, false).unwrap();
    for index in 0..reaches {
        let mut recording = set.read_reach(index).unwrap();
        change_reach(index, &mut recording);
        writer.stage(index, &recording).unwrap();
    }
    writer.finish().unwrap();
}

/// Tests that a set that was made again is compared with its source: the first reach that differs, or that the source lacks, is
/// named, with a warning if another version made the source, and with an error if the same one did.
#[test]
fn a_set_made_again_is_compared_with_its_source() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scenes::write(folder.path(), "trunk.toml", scenes::FEW_TRUNKS);
    let set = folder.path().join("set");
    underbrush!["generate", scene, "--reaches", "2", "--out", set].success();
    let flipped = |index: usize, recording: &mut Recording| {
        if index == 1 {
            recording.frames[3].joint_angle_rad[0] += 1e-12;
        }
    };
    let same = |_: usize, _: &mut Recording| {};
    let older = |plan: &mut DatasetPlan| plan.provenance.program_version = "0.0.9".into();
    let named = "reach 1 of trunk is missing or different in";
    let again = |name: &str| {
        let (source, out) = (folder.path().join(name), folder.path().join(format!("{name}-again")));
        underbrush!["generate", "--from", source, "--out", out]
    };
    altered(&set, &folder.path().join("older"), older, same);
    let call = again("older");
    assert_eq!((call.status, call.stderr.as_str()), (0, ""));
    altered(&set, &folder.path().join("older-other"), older, flipped);
    let call = again("older-other");
    assert_eq!(call.status, 0, "{}", call.stderr);
    assert!(call.stderr.contains(named) && call.stderr.contains("0.0.9"), "{}", call.stderr);
    altered(&set, &folder.path().join("other"), |_| {}, flipped);
    altered(&set, &folder.path().join("fewer"), |plan| plan.episodes.truncate(1), same);
    for source in ["other", "fewer"] {
        let call = again(source);
        assert_eq!(call.status, 1, "{}", call.stderr);
        assert!(call.stderr.contains(named), "{}", call.stderr);
    }
    assert!(Dataset::open(folder.path().join("other-again")).is_ok());
}

/// Tests that a set of another program is refused.
#[test]
fn a_set_of_another_program_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let foreign = folder.path().join("foreign");
    let driver = |plan: &mut DatasetPlan| plan.provenance.program = "robot-driver".into();
    altered(&fixture().dataset(), &foreign, driver, |_, _| {});
    let call = underbrush!["generate", "--from", foreign, "--out", folder.path().join("none")];
    call.refused(&["robot-driver", "underbrush generate"]);
}

/// Tests that a set that says to be a part of no parts is refused.
#[test]
fn a_part_of_no_parts_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let part = folder.path().join("part");
    let of_none = |plan: &mut DatasetPlan| plan.provenance.shard = Some(Shard { index: 0, count: 0 });
    altered(&fixture().dataset(), &part, of_none, |_, _| {});
    let call = underbrush!["generate", "--from", part, "--out", folder.path().join("none")];
    call.refused(&["provenance.json", "shard: found index 0, count 0", "an index below the count"]);
}

/// Tests that a set that says to be of more reaches than any campaign has is refused before the reaches are listed, which would fill
/// the memory.
#[test]
fn a_set_of_too_many_reaches_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let endless = folder.path().join("endless");
    let many = |plan: &mut DatasetPlan| plan.provenance.scenes[0].reaches = u64::MAX;
    altered(&fixture().dataset(), &endless, many, |_, _| {});
    let call = underbrush!["generate", "--from", endless, "--out", folder.path().join("none")];
    call.refused(&["provenance.json", "scenes[0].reaches: found 18446744073709551615", "1 to 1000000"]);
}

/// Tests that the audit refuses a set whose frames have a joint that the stored arm lacks.
#[test]
fn an_audit_with_another_arm_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    let one_more = |plan: &mut DatasetPlan| plan.joint_names.push("thumb".into());
    let moved = |_: usize, recording: &mut Recording| {
        recording.joint_names.push("thumb".into());
        for frame in &mut recording.frames {
            frame.joint_angle_rad.push(0.0);
            frame.joint_velocity_rad_per_s.push(0.0);
            frame.equilibrium_angle_rad.push(0.0);
            frame.joint_torque_nm.push(0.0);
        }
    };
    altered(&fixture().dataset(), &set, one_more, moved);
    underbrush!["inspect", set, "--audit"].refused(&["provenance.json", "arms[0]", "thumb"]);
}
