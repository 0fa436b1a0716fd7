//! Both ends of all ranges for numbers in files can be simulated.

use std::path::Path;

use underbrush_sim::arm::Arm;
use underbrush_sim::clutter::Clutter;
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;
use underbrush_sim::sensor::Sensor;
use underbrush_sim::simulation::{Setup, Simulation};

/// A trunk and two leaves with their foam, near the forearm.
const AROUND: &str = r#"summary = "One of each, near the arm"

[goals]
count = 1

[[objects.trunk]]
count = 1
place = { x_m = 0.25, y_m = -0.05 }

[[objects.foam_block]]
count = 1
place = { x_m = 0.45, y_m = -0.3, yaw_deg = 0 }

[[objects.leaf]]
count = 2
segments = 2
"#;

/// Simulates ten frames while the elbow pushes outwards, and demands finite numbers from engine, skin and sensor. Returns
/// whether the clutter could be drawn. Extreme values may leave no room, or give leaves that cannot carry their own weight.
/// An error is right then, and the arm is simulated alone.
#[track_caller]
fn stays_finite(plan: &ReachPlan, what: &str) -> bool {
    let drawn = plan.draw(0);
    let can_be_drawn = drawn.is_ok();
    let clutter = drawn.unwrap_or_default();
    run(plan, clutter, what);
    can_be_drawn
}

#[track_caller]
fn run(plan: &ReachPlan, clutter: Clutter, what: &str) {
    let scene = &plan.scene.file;
    let mut posture = plan.arm.start_posture_rad();
    let mut simulation = Simulation::new(Setup {
        arm: plan.arm.clone(),
        clutter,
        sensor: Sensor::new(&scene.sensor, &plan.arm.skin, 0, "ends", 0),
        physics: scene.physics.options(),
        dormancy: scene.physics.dormancy,
    });
    posture[1] += 0.3;
    posture[3] -= 0.3;
    for frame in 0..10 {
        let report = simulation.step(&posture);
        let joints = report.joints.iter().flat_map(|joint| [joint.angle_rad, joint.torque_nm]);
        let felt = report.tactile.taxels.iter().flat_map(|taxel| [taxel.true_normal_force_n, taxel.sensed_force_n]);
        let numbers: Vec<f64> = joints.chain(felt).collect();
        assert!(numbers.iter().all(|number| number.is_finite()), "{what}, frame {frame}: {numbers:?}");
    }
}

/// Tests that both ends of the ranges of numbers in a scene file are accepted, that ten simulated frames with them give
/// only finite numbers, and which ends cannot be drawn.
#[test]
fn ends_of_a_scene_s_ranges_can_be_simulated() {
    let roll = "[[objects.foam_roll]]\ncount = 1\nplace = { x_m = 0.25, y_m = 0.1 }\n";
    let bottle = "[[objects.water_bottle]]\ncount = 1\nplace = { x_m = 0.5, y_m = 0.1 }\n";
    // The widest do not fit beside the arm.
    let [far_roll, far_bottle] = [roll, bottle].map(|object| {
        let (kind, _) = object.split_once("place").unwrap();
        format!("{kind}place = {{ x_m = 0.8, y_m = 0.6 }}\n")
    });
    #[rustfmt::skip]
    let ends = [
        ("[physics]\ngravity_m_per_s2 = V\n", ["0", "30"]),
        ("[physics]\nstep_s = V\n", ["0.0001", "0.01"]),
        ("[robot]\nstiffness_scale = V\n", ["0.1", "10"]),
        ("[workspace]\ntable_height_m = V\n", ["-5", "5"]),
        ("[sensor]\nnoise_n = V\n", ["1e-6", "1"]),
        ("[sensor]\nquantum_n = V\n", ["1e-6", "10"]),
        ("[sensor]\nsaturation_n = V\n", ["0.1", "1e4"]),
        ("[sensor]\ncreep_share_per_decade = V\n", ["0", "1"]),
        ("[sensor]\ncrosstalk_share = V\n", ["0", "1"]),
        ("[sensor]\nspurious_share = V\n", ["0", "0.5"]),
        ("[sensor]\nspurious_time_s = V\n", ["0.01", "1e4"]),
        ("[sensor.fabric]\ncounts_per_n = V\n", ["0.1", "1e6"]),
        ("[sensor.fabric]\nhysteresis_share = V\n", ["0", "0.95"]),
        ("[[objects.trunk]]\ncount = 1\ndiameter_m = V\n", ["0.005", "0.3"]),
        ("[[objects.trunk]]\ncount = 1\nheight_m = V\n", ["0.05", "2"]),
        ("[[objects.foam_block]]\ncount = 1\nheight_m = V\n", ["0.01", "0.5"]),
        ("[[objects.foam_block]]\ncount = 1\ndry_modulus_pa = V\nwet_share = 0\n", ["1e3", "1e9"]),
        ("[[objects.leaf]]\ncount = 1\nloss_factor = V\n", ["0", "2"]),
        ("[[objects.leaf]]\ncount = 1\nflexural_rigidity_n_m2 = V\n", ["0.02", "10"]),
        ("[[objects.leaf]]\ncount = 1\nmass_per_area_kg_per_m2 = V\n", ["0.01", "20"]),
        ("[[objects.leaf]]\ncount = 1\nwidth_m = V\n", ["0.003", "0.3"]),
        // A slender or heavy roll only stands if it is stiff.
        ("FAR_ROLLdiameter_m = V\nmodulus_pa = 1e6\n", ["0.02", "0.5"]),
        ("ROLLrelaxing_share = V\n", ["0", "0.95"]),
        ("ROLLrelaxation_time_s = V\n", ["0.01", "1000"]),
        ("ROLLdensity_kg_per_m3 = V\nmodulus_pa = 1e6\n", ["1", "1000"]),
        ("FAR_BOTTLEdiameter_m = V\n", ["0.02", "0.5"]),
        ("BOTTLEheight_m = V\n", ["0.05", "2"]),
        ("BOTTLEempty_mass_kg = V\n", ["0.01", "30"]),
        ("FAR_BOTTLEwater_mass_kg = V\ndiameter_m = 0.5\nheight_m = 2\n", ["0", "300"]),
        ("BOTTLEfriction = V\n", ["0", "2"]),
    ];
    let mut cannot_be_drawn = Vec::new();
    for (section, values) in ends {
        for value in values {
            let text = format!(
                "{AROUND}\n{}",
                section
                    .replace("FAR_ROLL", &far_roll)
                    .replace("FAR_BOTTLE", &far_bottle)
                    .replace("ROLL", roll)
                    .replace("BOTTLE", bottle)
                    .replace('V', value)
            );
            let scene = Scene::parse("ends.toml", text.clone()).unwrap();
            if !stays_finite(&ReachPlan::new(scene, None, 0).unwrap(), &text) {
                cannot_be_drawn.push(section.replace('V', value));
            }
        }
    }
    // No goal is within reach of the arm above such a table.
    let expected = ["[workspace]\ntable_height_m = -5\n", "[workspace]\ntable_height_m = 5\n"];
    assert_eq!(cannot_be_drawn, expected);
}

/// Tests that both ends of the ranges of numbers in an arm's files are accepted, and that ten simulated frames with
/// them give only finite numbers.
#[test]
fn ends_of_an_arm_s_ranges_can_be_simulated() {
    let cody = Path::new(env!("CARGO_MANIFEST_DIR")).join("sim/arms/cody");
    let folder = tempfile::tempdir().unwrap();
    let names = ["cody.toml", "cody.urdf", "cody.skin.toml"];
    #[rustfmt::skip]
    let ends = [
        (names[0], "friction = 0.3", "friction = V", ["0", "2"]),
        (names[0], "\nstiffness_nm_per_rad = 25.0", "\nstiffness_nm_per_rad = V", ["1e-3", "1e5"]),
        (names[0], "\nstiffness_nm_per_rad = 30.0", "\nstiffness_nm_per_rad = V", ["1e-3", "1e5"]),
        (names[0], "damping_nm_s_per_rad = 1.43", "damping_nm_s_per_rad = V", ["0", "1e4"]),
        (names[0], "damping_nm_s_per_rad = 1.43", "damping_nm_s_per_rad = 1.43\narmature_kg_m2 = V", ["0", "100"]),
        (names[1], "<mass value=\"0.33\"/>", "<mass value=\"V\"/>", ["1e-4", "1e4"]),
        (names[1], "effort=\"20\"", "effort=\"V\"", ["1e-3", "1e5"]),
        (names[2], "stiffness_n_per_m3 = 3e7", "stiffness_n_per_m3 = V", ["1e5", "2e15"]),
    ];
    for (name, from, to, values) in ends {
        for value in values {
            for file in names {
                let text = std::fs::read_to_string(cody.join(file)).unwrap();
                assert!(file != name || text.contains(from), "{name} has no {from}");
                let text = if file == name { text.replacen(from, &to.replace('V', value), 1) } else { text };
                std::fs::write(folder.path().join(file), text).unwrap();
            }
            let arm = Arm::load(folder.path().join("cody.toml")).unwrap();
            let scene = Scene::parse("ends.toml", AROUND.to_string()).unwrap();
            let mut plan = ReachPlan::new(scene, None, 0).unwrap();
            plan.arm = arm;
            assert!(stays_finite(&plan, &to.replace('V', value)), "{to}, {value}");
        }
    }
}

/// Tests that the JSON Schema holds the ranges: of a number, with its unit, of the values and deviation of a drawn quantity,
/// and of an optional key.
#[test]
fn the_schema_tells_the_ranges() {
    let schema = serde_json::to_value(underbrush_sim::scene::schema()).unwrap();
    for (pointer, bound) in [
        ("/$defs/PhysicsSection/properties/gravity_m_per_s2/maximum", 30.0),
        ("/$defs/PhysicsSection/properties/step_s/minimum", 1e-4),
        ("/$defs/SensorOptions/properties/noise_n/maximum", 1.0),
        ("/$defs/LeafSpecification/properties/height_m/oneOf/0/maximum", 1.0),
        ("/$defs/Goals/properties/x_m/oneOf/1/properties/uniform/prefixItems/0/minimum", -5.0),
        ("/$defs/Goals/properties/x_m/oneOf/2/properties/normal/prefixItems/1/maximum", 10.0),
        ("/$defs/Placement/properties/yaw_deg/anyOf/0/oneOf/0/minimum", -360.0),
    ] {
        let found = schema.pointer(pointer).and_then(serde_json::Value::as_f64);
        assert_eq!(found, Some(bound), "{pointer} in {schema:#}");
    }
    assert_eq!(schema["$defs"]["PhysicsSection"]["properties"]["step_s"]["unit"], "s");
}
