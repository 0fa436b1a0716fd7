//! Every number in a file has a range. One table lists all keys, and each key is tried with the same values.

use std::path::{Path, PathBuf};

use underbrush_classifier::{Model, ModelError};
use underbrush_recording::InputError;
use underbrush_recording::disk::{DiskError, read_trials};
use underbrush_sim::arm::Arm;
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;

use crate::support::{scenes, underbrush};

/// The values that every number is tried with.
const VALUES: [&str; 11] = ["nan", "inf", "-inf", "0", "-1", "1e-300", "1e300", "-1e30", "1e30", "1e308", "-1e308"];

/// One key: its text with `V` in place of the value; the field that an error names and, after `|`, others that it may
/// name if the value contradicts the rest of the files; a valid value; and the [`VALUES`] that lie within its range.
struct Key(&'static str, &'static str, &'static str, &'static str);

/// Keys of scene files, each with the section that it stands in.
#[rustfmt::skip]
const SCENE: &[Key] = &[
    Key("[workspace]\nx_m = [V, 2.0]\n", "workspace.x_m", "0.2", "0 -1 1e-300"),
    Key("[workspace]\nx_m = [-2.0, V]\n", "workspace.x_m", "0.7", "0 -1 1e-300"),
    Key("[workspace]\ny_m = [V, 2.0]\n", "workspace.y_m", "0.2", "0 -1 1e-300"),
    Key("[workspace]\ny_m = [-2.0, V]\n", "workspace.y_m", "0.7", "0 -1 1e-300"),
    Key("[workspace]\ntable_height_m = V\n", "table_height_m", "-0.6", "0 -1 1e-300"),
    Key("[robot]\nstiffness_scale = V\n", "robot.stiffness_scale", "2.0", ""),
    Key("[robot]\nhand_speed_scale = V\n", "robot.hand_speed_scale", "2.0", ""),
    Key("[robot]\nforce_limit_scale = V\n", "robot.force_limit_scale", "2.0", ""),
    Key("[goals]\ncount = V\n", "goals.count", "3", ""),
    Key("[goals]\nretries = V\n", "goals.retries", "3", "0"),
    Key("[goals]\npatience_s = V\n", "goals.patience_s", "2.0", ""),
    Key("[goals]\nx_m = V\n", "goals.x_m", "0.5", "0 -1 1e-300"),
    Key("[goals]\ny_m = { uniform = [V, 2.0] }\n", "goals.y_m", "0.5", "0 -1 1e-300"),
    Key("[goals]\ny_m = { uniform = [-2.0, V] }\n", "goals.y_m", "0.5", "0 -1 1e-300"),
    Key("[goals]\nz_m = { normal = [V, 0.1] }\n", "goals.z_m", "-0.2", "0 -1 1e-300"),
    Key("[goals]\nz_m = { normal = [-0.2, V] }\n", "goals.z_m", "0.1", "0 1e-300"),
    Key("[physics]\nstep_s = V\n", "physics.step_s", "0.005", ""),
    Key("[physics]\ngravity_m_per_s2 = V\n", "physics.gravity_m_per_s2", "1.62", "0 1e-300"),
    Key("[sensor]\nnoise_n = V\n", "sensor.noise_n", "0.001", "0"),
    Key("[sensor]\ngate_sigmas = V\n", "sensor.gate_sigmas", "3.0", "0 1e-300"),
    Key("[sensor]\nquantum_n = V\n", "sensor.quantum_n", "0.01", "0"),
    Key("[sensor]\nsaturation_n = V\n", "sensor.saturation_n", "5.0", "inf"),
    Key("[sensor]\nfloor_n = V\n", "sensor.floor_n", "1.0", "0"),
    Key("[sensor]\ncrosstalk_share = V\n", "sensor.crosstalk_share", "0.1", "0 1e-300"),
    Key("[sensor]\ncreep_share_per_decade = V\n", "sensor.creep_share_per_decade", "0.1", "0 1e-300"),
    Key("[sensor]\nspurious_share = V\n", "sensor.spurious_share", "0.1", "0 1e-300"),
    Key("[sensor]\nspurious_time_s = V\n", "sensor.spurious_time_s", "1.0", ""),
    Key("[sensor]\nspurious_force_n = [V, 0.1]\n", "sensor.spurious_force_n", "0.05", ""),
    Key("[sensor]\nspurious_force_n = [0.02, V]\n", "sensor.spurious_force_n", "0.05", ""),
    Key("[sensor]\ndelay_frames = V\n", "sensor.delay_frames", "2", "0"),
    Key("[sensor]\ndead_share = V\n", "sensor.dead_share", "0.1", "0 1e-300"),
    Key("[sensor]\ndead_taxels = { forearm = [V] }\n", "sensor.dead_taxels", "3", "0"),
    Key("[sensor.fabric]\ncounts_per_n = V\n", "sensor.fabric.counts_per_n", "20.0", "0"),
    Key("[sensor.fabric]\nfull_scale_n = V\n", "sensor.fabric.full_scale_n", "20.0", "inf"),
    Key("[sensor.fabric]\nhysteresis_share = V\n", "sensor.fabric.hysteresis_share", "0.1", "0 1e-300"),
    Key("[sensor.fabric]\nnoise_n = V\n", "sensor.fabric.noise_n", "0.1", "0"),
    Key("[sensor.fabric]\ngate_sigmas = V\n", "sensor.fabric.gate_sigmas", "2.0", "0 1e-300"),
    Key("[[objects.trunk]]\ncount = V\n", "objects.trunk|count", "2", "0"),
    Key("[[objects.trunk]]\ncount = 1\nplace = { x_m = V }\n", "place", "0.5", "0 -1 1e-300"),
    Key("[[objects.trunk]]\ncount = 1\nplace = { y_m = V }\n", "place", "0.5", "0 -1 1e-300"),
    Key("[[objects.trunk]]\ncount = 1\nplace = { yaw_deg = V }\n", "place", "45", "0 -1 1e-300"),
    Key("[[objects.trunk]]\ncount = 1\ndiameter_m = V\n", "objects.trunk[0].diameter_m", "0.03", ""),
    Key("[[objects.trunk]]\ncount = 1\nheight_m = V\n", "objects.trunk[0].height_m", "0.5", ""),
    Key("[[objects.foam_block]]\ncount = 1\nheight_m = V\n", "objects.foam_block[0].height_m", "0.1", ""),
    Key("[[objects.foam_block]]\ncount = 1\nwet_share = V\n", "objects.foam_block[0].wet_share", "0.1", "0 1e-300"),
    Key("[[objects.foam_block]]\ncount = 1\ndry_modulus_pa = V\n", "objects.foam_block[0].dry_modulus_pa", "1e6", ""),
    Key("[[objects.foam_block]]\ncount = 1\nwet_modulus_pa = V\n", "objects.foam_block[0].wet_modulus_pa", "1e5", ""),
    Key("[[objects.foam_roll]]\ncount = 1\ndiameter_m = V\n", "objects.foam_roll[0].diameter_m", "0.1", ""),
    Key("[[objects.foam_roll]]\ncount = 1\nheight_m = V\n", "objects.foam_roll[0].height_m", "0.5", ""),
    Key("[[objects.foam_roll]]\ncount = 1\nmodulus_pa = V\n", "objects.foam_roll[0].modulus_pa", "1e5", ""),
    Key("[[objects.foam_roll]]\ncount = 1\nrelaxing_share = V\n", "objects.foam_roll[0].relaxing_share", "0.5", "0 1e-300"),
    Key("[[objects.foam_roll]]\ncount = 1\nrelaxation_time_s = V\n", "objects.foam_roll[0].relaxation_time_s", "2.0", ""),
    Key("[[objects.foam_roll]]\ncount = 1\ndensity_kg_per_m3 = V\n", "objects.foam_roll[0].density_kg_per_m3", "30.0", ""),
    Key("[[objects.water_bottle]]\ncount = 1\ndiameter_m = V\n", "objects.water_bottle[0].diameter_m", "0.25", ""),
    Key("[[objects.water_bottle]]\ncount = 1\nheight_m = V\n", "objects.water_bottle[0].height_m", "0.4", ""),
    Key("[[objects.water_bottle]]\ncount = 1\nempty_mass_kg = V\n", "objects.water_bottle[0].empty_mass_kg", "0.5", ""),
    Key("[[objects.water_bottle]]\ncount = 1\nwater_mass_kg = V\n", "objects.water_bottle[0].water_mass_kg", "0.5", "0 1e-300"),
    Key("[[objects.water_bottle]]\ncount = 1\nfriction = V\n", "objects.water_bottle[0].friction", "0.2", "0 1e-300"),
    Key("[[objects.leaf]]\ncount = 1\nheight_m = V\n", "objects.leaf[0].height_m", "0.3", ""),
    Key("[[objects.leaf]]\ncount = 1\nwidth_m = V\n", "objects.leaf[0].width_m", "0.03", ""),
    Key("[[objects.leaf]]\ncount = 1\nflexural_rigidity_n_m2 = V\n", "objects.leaf[0].flexural_rigidity_n_m2", "0.01", ""),
    Key("[[objects.leaf]]\ncount = 1\nmass_per_area_kg_per_m2 = V\n", "objects.leaf[0].mass_per_area_kg_per_m2", "0.7", ""),
    Key("[[objects.leaf]]\ncount = 1\nloss_factor = V\n", "objects.leaf[0].loss_factor", "0.1", "0 1e-300"),
    Key("[[objects.leaf]]\ncount = 1\nroot_depth_m = V\n", "objects.leaf[0].root_depth_m", "0.04", ""),
    Key("[[objects.leaf]]\ncount = 1\nsegments = V\n", "segments", "4", ""),
];

/// Keys of Cody's three files: the file, the original text, and the key that replaces it.
#[rustfmt::skip]
const ARM: &[(&str, &str, Key)] = &[
    ("cody.toml", "friction = 0.3", Key("friction = V", "friction", "0.5", "0 1e-300")),
    ("cody.toml", "\nstiffness_nm_per_rad = 20.0", Key("\nstiffness_nm_per_rad = V", "shoulder_flexion.stiffness", "30.0", "")),
    ("cody.toml", "damping_nm_s_per_rad = 5.73", Key("damping_nm_s_per_rad = V", "shoulder_flexion.damping", "3.0", "0 1e-300")),
    ("cody.toml", "damping_nm_s_per_rad = 5.73", Key("damping_nm_s_per_rad = 5.73\narmature_kg_m2 = V", "shoulder_flexion.armature", "0.1", "0 1e-300")),
    ("cody.toml", "model_stiffness_nm_per_rad = 3.2", Key("model_stiffness_nm_per_rad = V", "elbow_flexion.model_stiffness", "30.0", "")),
    ("cody.toml", "[-47.61, 120.0]", Key("[V, 120.0]", "joint shoulder_flexion", "-45.0", "")),
    ("cody.toml", "[-47.61, 120.0]", Key("[-47.61, V]", "joint shoulder_flexion", "100.0", "0 -1 1e-300")),
    ("cody.toml", "start_deg = -40.0", Key("start_deg = V", "shoulder_flexion.start_deg", "-30.0", "0 -1 1e-300")),
    (
        "cody.toml",
        "[[joint]]\nname = \"wrist_yaw\"\nstiffness_nm_per_rad = 30.0\ndamping_nm_s_per_rad = 0.48\n\
         model_stiffness_nm_per_rad = 30.0\ncontroller_limits_deg = [-40.0, 40.0]\nstart_deg = 0.0\n",
        Key("[[held]]\nname = \"wrist_yaw\"\nangle_deg = V\n", "held[0].angle_deg", "10.0", "0 -1 1e-300"),
    ),
    (
        "cody.toml",
        "friction = 0.3",
        Key(
            "friction = 0.3\n[[inertia]]\nlink = \"shoulder\"\nentries_kg_m2 = [V, 0, 0, 0.003212, 0, 0.004658]\n",
            "inertia[0].entries_kg_m2", "0.003", "",
        ),
    ),
    ("cody.toml", "[-0.00443, 0.04363", Key("[V, 0.04363", "hull[0].points_m|patch flipper", "-0.0045", "0 -1 1e-300")),
    ("cody.urdf", "xyz=\"-0.002865 -0.175436", Key("xyz=\"V -0.175436", "link shoulder, inertial.origin", "0.001", "0 -1 1e-300")),
    ("cody.urdf", "<mass value=\"2.0036\"/>", Key("<mass value=\"V\"/>", "link shoulder, inertial", "2.5", "")),
    ("cody.urdf", "ixx=\"0.003056\"", Key("ixx=\"V\"", "link shoulder, inertial.inertia", "0.0031", "")),
    ("cody.urdf", "ixy=\"0.000268\"", Key("ixy=\"V\"", "link shoulder, inertial.inertia", "0.0002", "0 1e-300")),
    ("cody.urdf", "ixz=\"0.000504\"", Key("ixz=\"V\"", "link shoulder, inertial.inertia", "0.0002", "0 1e-300")),
    ("cody.urdf", "iyy=\"0.003212\"", Key("iyy=\"V\"", "link shoulder, inertial.inertia", "0.0033", "")),
    ("cody.urdf", "iyz=\"0.000078\"", Key("iyz=\"V\"", "link shoulder, inertial.inertia", "0.0001", "0 1e-300")),
    ("cody.urdf", "izz=\"0.004658\"", Key("izz=\"V\"", "link shoulder, inertial.inertia", "0.0047", "")),
    ("cody.urdf", "<origin xyz=\"0 -0.185 0\"/>", Key("<origin xyz=\"0 V 0\"/>", "link shoulder, collision.origin", "-0.18", "0 -1 1e-300")),
    ("cody.urdf", "<origin xyz=\"0 -0.185 0\"/>", Key("<origin rpy=\"0 V 0\"/>", "link shoulder, collision.origin", "0.1", "0 -1 1e-300")),
    ("cody.urdf", "<sphere radius=\"0.06\"/>", Key("<sphere radius=\"V\"/>", "link shoulder, collision.geometry", "0.05", "")),
    ("cody.urdf", "<sphere radius=\"0.06\"/>", Key("<box size=\"0.1 V 0.1\"/>", "link shoulder, collision.geometry", "0.05", "")),
    ("cody.urdf", "<capsule radius=\"0.05\" length=\"0.20\"/>", Key("<capsule radius=\"V\" length=\"0.20\"/>", "collision.geometry", "0.04", "")),
    ("cody.urdf", "<capsule radius=\"0.05\" length=\"0.20\"/>", Key("<capsule radius=\"0.05\" length=\"V\"/>", "collision.geometry", "0.1", "")),
    ("cody.urdf", "radius=\"0.04604\" length=\"0.237\"", Key("radius=\"V\" length=\"0.237\"", "collision.geometry|patch forearm", "0.046", "")),
    ("cody.urdf", "radius=\"0.04604\" length=\"0.237\"", Key("radius=\"0.04604\" length=\"V\"", "collision.geometry|patch forearm", "0.25", "")),
    ("cody.urdf", "xyz=\"0 -0.18493 0\"", Key("xyz=\"0 V 0\"", "joint shoulder_abduction, origin", "-0.2", "0 -1 1e-300")),
    ("cody.urdf", "<axis xyz=\"0 -1 0\"/>", Key("<axis xyz=\"0 V 0\"/>", "joint shoulder_flexion, axis", "1", "-1")),
    ("cody.urdf", "lower=\"-0.8310\"", Key("lower=\"V\"", "joint shoulder_flexion", "-0.9", "-1")),
    ("cody.urdf", "upper=\"2.0945\"", Key("upper=\"V\"", "joint shoulder_flexion", "2.2", "")),
    ("cody.urdf", "effort=\"40\"", Key("effort=\"V\"", "joint shoulder_flexion, limit.effort", "50", "")),
    ("cody.urdf", "velocity=\"0.87266\"", Key("velocity=\"V\"", "joint shoulder_flexion, limit.velocity", "0.8", "")),
    ("cody.skin.toml", "stiffness_n_per_m3 = 3e7", Key("stiffness_n_per_m3 = V", "stiffness_n_per_m3", "1e7", "")),
    ("cody.skin.toml", "row_0_m = [0.0, ", Key("row_0_m = [V, ", "row_0_m|patch forearm", "0.001", "0 -1 1e-300")),
    ("cody.skin.toml", "axis = [0.0, 0.0, -1.0]", Key("axis = [0.0, 0.0, V]", "cylinder.axis|patch forearm", "-2.0", "-1")),
    ("cody.skin.toml", "zero_angle = [1.0, ", Key("zero_angle = [V, ", "cylinder.zero_angle", "2.0", "-1")),
    ("cody.skin.toml", "radius_m = 0.04604", Key("radius_m = V", "cylinder.radius_m", "0.0459", "")),
    ("cody.skin.toml", "rows = 16", Key("rows = V", "rows", "14", "")),
    ("cody.skin.toml", "row_pitch_m = 0.0108", Key("row_pitch_m = V", "cylinder.row_pitch_m", "0.0106", "")),
    ("cody.skin.toml", "taxel_size_m = 0.009", Key("taxel_size_m = V", "cylinder.taxel_size_m", "0.008", "")),
    ("cody.skin.toml", "-172.39,", Key("V,", "column_angles_deg|taxel_size_m", "-172.5", "")),
    ("cody.skin.toml", "[1e-4, 15e-4]", Key("[V, 15e-4]", "derived_area_limits_m2", "2e-4", "")),
    ("cody.skin.toml", "[1e-4, 15e-4]", Key("[1e-4, V]", "derived_area_limits_m2", "2e-4", "")),
    ("cody.skin.toml", "[-0.00221, 0.02343", Key("[V, 0.02343", "taxels[0].position_m|patch flipper, taxel 0", "-0.002", "0 -1 1e-300")),
    ("cody.skin.toml", "normal = [-0.47474, 0.82228", Key("normal = [V, 0.82228", "taxels[0].normal", "-0.5", "0 -1 1e-300")),
    ("cody.skin.toml", "-0.31381] },", Key("-0.31381], area_m2 = V },", "taxels[0].area_m2", "1e-4", "")),
];

const MODEL: &str = r#"{"format": "underbrush-model/1", "features": ["force_n"],
  "models": {"leaf": {"initial": [0.5, 0.5], "transition": [[0.25, 0.75], [0.0, 1.0]], "mean": [[0.1], [0.3]],
    "covariance": [[[0.01]], [[1e-4]]]}},
  "scaling": {"mean": [0.7], "standard_deviation": [0.6]},
  "recipe": {"states": 2, "features": "force", "topology": "left_to_right", "initial": "uniform", "score": "viterbi",
    "scaling": "z_score", "max_samples": 90, "training": {"iterations": 500, "tolerance": 0.001, "variance_floor": 0.0001}},
  "decision": {"prior": {"leaf": 0.9}, "rule": {"outlier_band": {"uncertain_below": 15.0, "category_above": 80.0}}},
  "training": {"leaf": {"trials": 1, "samples": 2, "log_likelihood": [-3.5], "stop": {"fell": {"iteration": 1, "by": 0.125}},
    "empty_states": []}}}"#;

/// Keys of a model: the original text in [`MODEL`], and the key that replaces it.
#[rustfmt::skip]
const MODEL_KEYS: &[(&str, Key)] = &[
    ("[0.5, 0.5]", Key("[V, 0.5]", "models.leaf.initial", "0.5", "")),
    ("[0.25, 0.75]", Key("[V, 0.75]", "models.leaf.transition[0]", "0.25", "")),
    ("[[0.1], [0.3]]", Key("[[V], [0.3]]", "models.leaf.mean[0]", "0.2", "0 -1 1e-300")),
    ("[[0.01]]", Key("[[V]]", "models.leaf.covariance[0]", "0.02", "")),
    ("[0.7]", Key("[V]", "scaling.mean", "0.6", "0 -1 1e-300")),
    ("[0.6]", Key("[V]", "scaling.standard_deviation", "0.7", "")),
    ("\"states\": 2", Key("\"states\": V", "recipe", "2", "")),
    ("\"max_samples\": 90", Key("\"max_samples\": V", "recipe", "50", "")),
    ("\"iterations\": 500", Key("\"iterations\": V", "recipe", "50", "0")),
    ("\"tolerance\": 0.001", Key("\"tolerance\": V", "recipe.training.tolerance", "0.01", "0 1e-300")),
    ("\"variance_floor\": 0.0001", Key("\"variance_floor\": V", "recipe.training.variance_floor", "0.01", "0")),
    ("\"leaf\": 0.9", Key("\"leaf\": V", "decision", "0.5", "")),
    ("\"uncertain_below\": 15.0", Key("\"uncertain_below\": V", "decision", "10.0", "0 1e-300")),
    ("\"category_above\": 80.0", Key("\"category_above\": V", "decision", "70.0", "")),
    ("[-3.5]", Key("[V]", "training.leaf.log_likelihood", "-4.0", "0 -1 1e-300 1e30 -1e30")),
    ("\"by\": 0.125", Key("\"by\": V", "training.leaf.stop", "0.25", "0 1e-300 1e30")),
];

/// Keys of a table of trials: its second line.
#[rustfmt::skip]
const TRIALS: &[Key] = &[
    Key("V,0.0,0.5,0.001,3,1.5,2.25,4,7", "trial", "3", "0"),
    Key("1,V,0.5,0.001,3,1.5,2.25,4,7", "time_s", "3.5", "0 -1 1e-300"),
    Key("1,0.0,V,0.001,3,1.5,2.25,4,7", "force_n", "3.5", "0 -1 1e-300"),
    Key("1,0.0,0.5,V,3,1.5,2.25,4,7", "motion_m", "0.1", "0 1e-300"),
    Key("1,0.0,0.5,0.001,V,1.5,2.25,4,7", "region_taxels", "2", ""),
    Key("1,0.0,0.5,0.001,3,V,2.25,4,7", "region_largest_force_n|region_force_sum_n", "2.0", ""),
    Key("1,0.0,0.5,0.001,3,1.5,V,4,7", "region_force_sum_n", "1.6", ""),
    Key("1,0.0,0.5,0.001,3,1.5,2.25,V,7", "reach", "4", "0"),
    Key("1,0.0,0.5,0.001,3,1.5,2.25,4,V", "taxel", "4", "0"),
];
const TRIALS_HEAD: &str =
    "trial,time_s,force_n,motion_m,region_taxels,region_largest_force_n,region_force_sum_n,reach,taxel";

/// Tries one key with its valid value and with all of [`VALUES`]; `read` reads a text with this key.
fn try_all(key: &Key, read: &dyn Fn(&str) -> Result<(), InputError>) {
    let Key(template, fields, sound, within) = key;
    let text = |value: &str| template.replacen('V', value, 1);
    if let Err(error) = read(&text(sound)) {
        panic!("{} is sound: {error}", text(sound));
    }
    for value in VALUES {
        let is_within = within.split(' ').any(|allowed| allowed == value);
        match read(&text(value)) {
            Ok(()) => assert!(is_within, "{} was accepted", text(value)),
            Err(error) => {
                // A value within the range may be refused only because it contradicts something else.
                let mut names = fields.split('|').skip(usize::from(is_within));
                let named = names.any(|field| error.field.contains(field));
                assert!(named, "{}: the error names {:?}: {error}", text(value), error.field);
                assert!(error.to_string().len() < 1000, "{error}");
                assert!(![&error.found, &error.allowed, &error.remedy].iter().any(|part| part.is_empty()));
            }
        }
    }
}

fn write(path: &Path, text: &str) -> PathBuf {
    std::fs::write(path, text).unwrap();
    path.to_path_buf()
}

/// Tests that every number in every file is accepted within its range, that it is refused outside it with an error that
/// names file and field, and that no number makes the program panic.
#[test]
fn every_number_has_a_range() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file.toml");
    let in_file = |result: Result<(), InputError>| {
        if let Err(error) = &result {
            assert!(error.file.starts_with(folder.path()), "{error}");
        }
        result
    };
    for key in SCENE {
        try_all(key, &|text| {
            write(&file, &format!("summary = \"A scene\"\n\n{text}"));
            let plan = Scene::load(&file).and_then(|scene| ReachPlan::new(scene, None, 0));
            in_file(plan.map(|_| ()))
        });
    }
    let cody = Path::new(env!("CARGO_MANIFEST_DIR")).join("sim/arms/cody");
    let original = |name: &str| std::fs::read_to_string(cody.join(name)).unwrap();
    for (name, from, key) in ARM {
        for file in ["cody.toml", "cody.urdf", "cody.skin.toml"] {
            write(&folder.path().join(file), &original(file));
        }
        assert!(original(name).contains(from), "{name} has no {from}");
        try_all(key, &|text| {
            write(&folder.path().join(name), &original(name).replacen(from, text, 1));
            in_file(Arm::load(folder.path().join("cody.toml")).map(|_| ()))
        });
    }
    for (from, key) in MODEL_KEYS {
        assert!(MODEL.contains(from), "no {from}");
        let path = folder.path().join("model.json");
        try_all(key, &|text| {
            match Model::from_json(&path, &MODEL.replacen(from, text, 1)) {
                Ok(_) => Ok(()),
                // JSON has no NaN and no infinity; the error then has a line.
                Err(ModelError::Input(error)) if error.field == "JSON" && error.line.is_some() => {
                    Err(InputError { field: key.1.split('|').next().unwrap_or_default().into(), ..*error })
                }
                Err(ModelError::Input(error)) => Err(*error),
                Err(other) => panic!("{text}: {other}"),
            }
        });
    }
    for key in TRIALS {
        try_all(key, &|text| {
            let path = write(&folder.path().join("trials.csv"), &format!("{TRIALS_HEAD}\n{text}\n"));
            match read_trials(path) {
                Ok(_) => Ok(()),
                Err(DiskError::Input(error)) => {
                    assert_eq!(error.line, Some(2), "{error}");
                    in_file(Err(error))
                }
                Err(other) => panic!("{text}: {other}"),
            }
        });
    }
    let keys = SCENE.len() + ARM.len() + MODEL_KEYS.len() + TRIALS.len();
    assert_eq!(keys, 137, "rows for a key were added or removed");
}

/// Tests that the error about a line of one megabyte is short, in scene files and in tables.
#[test]
fn faults_in_long_lines_are_shown_shortly() {
    let folder = tempfile::tempdir().unwrap();
    let long = "9".repeat(1_000_000);
    let scene = scenes::write(folder.path(), "long.toml", &format!("summary = \"A\"\ncolour_{long} = 3\n"));
    let table = folder.path().join("long.csv");
    std::fs::write(&table, format!("trial,time_s,force_n\n1,0.0,{long}\n")).unwrap();
    let beside = folder.path().join("beside.csv");
    std::fs::write(&beside, format!("trial,time_s,force_n,note\n1,0.0,-5,x\n1,0.1,0,{long}\n")).unwrap();
    for (path, part) in [(scene, "long.toml:2"), (table, "long.csv:2"), (beside, "beside.csv:2")] {
        let answer = underbrush!["inspect", path];
        answer.refused(&[part]);
        assert!(answer.stderr.len() < 4000, "{} bytes", answer.stderr.len());
    }
}
