//! An arm that touches itself.

use std::fs;
use std::path::Path;

use glam::DVec3;
use underbrush_recording::{InputError, disk};
use underbrush_sim::reach::ReachPlan;
use underbrush_sim::scene::Scene;
use underbrush_sim::simulation::Simulation;

/// Distance from the last joint to where the last link touches the post, along the link, m: √(0.2² + 0.1² − 0.05²), as the
/// radii are 50 mm together. The first two joints give way a little.
const LEVER_M: f64 = 0.218;

/// Three upright hinges in a horizontal plane. The chain is folded like a U, so that the last link is beside a post on the
/// base: 50 mm from it, and three joints away.
const URDF: &str = r#"<robot name="folded">
<link name="base"><collision><origin xyz="0.1 0.1 0"/><geometry><capsule radius="0.02" length="0.4"/></geometry></collision></link>
<joint name="first" type="revolute"><parent link="base"/><child link="near"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="500" velocity="1"/></joint>
<link name="near"><inertial><origin xyz="0.15 0 0"/><mass value="1"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
<joint name="second" type="revolute"><parent link="near"/><child link="middle"/><origin xyz="0.3 0 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="500" velocity="1"/></joint>
<link name="middle"><inertial><origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial></link>
<joint name="third" type="revolute"><parent link="middle"/><child link="far"/><origin xyz="0.2 0 0"/><axis xyz="0 0 1"/><limit lower="-3" upper="3" effort="500" velocity="1"/></joint>
<link name="far"><inertial><origin xyz="0.15 0 0"/><mass value="1"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
<collision><origin xyz="0.17 0 0" rpy="0 1.5707963267948966 0"/><geometry><cylinder radius="0.03" length="0.26"/></geometry></collision></link>
<joint name="end" type="fixed"><parent link="far"/><child link="tip"/><origin xyz="0.3 0 0"/></joint>
<link name="tip"/>
</robot>"#;

const SKIN: &str = r#"stiffness_n_per_m3 = 3e7
thickness_m = 0.003
[[patch]]
name = "far"
link = "far"
technology = "capacitive"
[patch.cylinder]
row_0_m = [0.06, 0.0, 0.0]
axis = [1.0, 0.0, 0.0]
zero_angle = [0.0, 1.0, 0.0]
radius_m = 0.03
rows = 22
row_pitch_m = 0.011
taxel_size_m = 0.009
wraps = true
column_angles_deg = [-160.0, -120.0, -80.0, -40.0, 0.0, 40.0, 80.0, 120.0, 160.0]
"#;

/// The arm file; `more` are further keys.
fn arm_file(more: &str) -> String {
    let joint = |(name, stiffness, damping, start): (&str, f64, f64, f64)| {
        format!(
            "[[joint]]\nname = \"{name}\"\nstiffness_nm_per_rad = {stiffness:?}\ndamping_nm_s_per_rad = {damping:?}\n\
             model_stiffness_nm_per_rad = {stiffness:?}\ncontroller_limits_deg = [-170.0, 170.0]\nstart_deg = {start:?}\n"
        )
    };
    let joints = [("first", 400.0, 20.0, 0.0), ("second", 400.0, 20.0, 90.0), ("third", 20.0, 2.0, 90.0)].map(joint);
    format!(
        "name = \"folded\"\nurdf = \"folded.urdf\"\nskin = \"folded.skin.toml\"\nbase_link = \"base\"\ntip_link = \"tip\"\n\
         friction = 0.0\n{more}\n{}",
        joints.concat()
    )
}

/// A plan of one reach of the arm in an empty scene; `more` are keys of the arm file, and `scene` of the scene file.
fn plan(folder: &Path, more: &str, scene: &str) -> Result<ReachPlan, InputError> {
    fs::write(folder.join("folded.urdf"), URDF).unwrap();
    fs::write(folder.join("folded.skin.toml"), SKIN).unwrap();
    fs::write(folder.join("folded.toml"), arm_file(more)).unwrap();
    let scene = format!(
        "summary = \"Nothing\"\narm = \"folded.toml\"\n{scene}\nworkspace.table_height_m = -1.0\n\
         goals.positions_m = [[0.05, 0.0, 0.0]]\nsensor.model = \"ideal\"\n"
    );
    fs::write(folder.join("empty.toml"), scene).unwrap();
    ReachPlan::new(Scene::load(folder.join("empty.toml"))?, None, 1)
}

/// Turns the equilibrium angle of the last joint by `turn_rad` within a second, waits for two, and returns the simulation.
fn turned(plan: &ReachPlan, turn_rad: f64) -> Simulation {
    let mut simulation = plan.simulation(0).unwrap();
    let start = simulation.arm().start_posture_rad();
    for frame in 0..300 {
        let mut equilibrium = start.clone();
        equilibrium[2] += turn_rad * (f64::from(frame) / 100.0).min(1.0);
        simulation.step(&equilibrium);
    }
    simulation
}

/// Tests that a link that is turned onto a post on the base is stopped by it with the force of the joint's spring over the
/// lever, K (φ − q) / r, that both links have it with opposite signs, that the skin of the turning link feels it, and that all
/// joints are in balance. At rest nothing is left of the method; 1 % is for the arm's last motion.
#[test]
fn an_arm_is_stopped_by_itself() {
    let folder = tempfile::tempdir().unwrap();
    let plan = plan(folder.path(), "", "").unwrap();
    let simulation = turned(&plan, 0.6);
    let report = simulation.report();
    let on = |link: usize| report.contacts.iter().filter(move |contact| contact.link == link);
    assert!(report.contacts.iter().all(|contact| contact.object.is_none()));
    let [base, far] = [0, 3].map(|link| on(link).map(|contact| contact.force_world).sum::<DVec3>());
    assert!((base + far).length() < 1e-12 * far.length(), "{base} {far}");
    assert!(on(0).all(|contact| contact.body == 3) && on(3).all(|contact| contact.body == 0));

    let spring_nm = report.joint_torque_nm()[2];
    let normal: DVec3 = on(3).map(|contact| contact.inward_world * contact.force_world.dot(contact.inward_world)).sum();
    let axis = report.link_pose_world[3].position;
    let place = report.link_pose_world[3].transform_point(on(3).next().unwrap().position_link);
    let lever_m = (place - axis).cross(normal.normalize()).length();
    assert!((lever_m - LEVER_M).abs() < 0.01, "{lever_m}");
    let expected_n = spring_nm.abs() / lever_m;
    assert!((normal.length() / expected_n - 1.0).abs() < 0.01 && expected_n > 20.0, "{normal} {expected_n}");

    let springs = report.joint_torque_nm();
    let contacts = report.contact_torque_nm(simulation.arm());
    for (spring, contact) in springs.iter().zip(&contacts) {
        assert!((spring + contact).abs() < 0.01 * spring_nm.abs(), "{springs:?} {contacts:?}");
    }
    let felt: f64 = report.tactile.taxels.iter().map(|taxel| taxel.true_normal_force_n).sum();
    assert!(
        felt >= 0.99 * normal.length() && report.tactile.taxels.iter().all(|taxel| taxel.object.is_none()),
        "{felt}"
    );
}

/// Tests that links pass through each other if the arm file names them or the scene says so, and that names of no link and of
/// one rigid link are refused with their line.
#[test]
fn links_pass_through_each_other_where_a_file_says_so() {
    let folder = tempfile::tempdir().unwrap();
    for (arm, scene) in [("passing_links = [[\"far\", \"base\"]]", ""), ("", "passing = [[\"arm\", \"arm\"]]")] {
        let free = turned(&plan(folder.path(), arm, scene).unwrap(), 0.6);
        assert!(free.report().contacts.is_empty());
        let turned_rad = free.report().joints[2].angle_rad - free.arm().joints[2].start_rad;
        assert!((turned_rad / 0.6 - 1.0).abs() < 0.01, "{turned_rad}");
    }
    for (pair, found) in [("[\"far\", \"hand\"]", "hand"), ("[\"far\", \"far\"]", "one rigid link")] {
        let error = plan(folder.path(), &format!("passing_links = [{pair}]"), "").err().unwrap();
        assert!(error.field == "passing_links[0]" && error.line == Some(7) && error.found.contains(found), "{error}");
    }
}

/// Tests that a reach in which the arm touches itself is recorded and read back whole: contact points without an object, and
/// no contact in the list of contacts with objects.
#[test]
fn a_recording_holds_contacts_of_the_arm_with_itself() {
    let folder = tempfile::tempdir().unwrap();
    let recording = plan(folder.path(), "", "").unwrap().run(0, &mut |_| {}).unwrap();
    let of_itself = recording.frames.iter().flat_map(|frame| &frame.contact_points);
    assert!(of_itself.clone().count() > 10 && of_itself.into_iter().all(|point| point.object.is_none()));
    assert!(recording.contacts.is_empty());
    let path = folder.path().join("reach.parquet");
    disk::write_recording(&path, &recording).unwrap();
    assert!(disk::read_recording(&path).unwrap() == recording);
}
