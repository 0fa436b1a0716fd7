//! The arm's TOML file, and the arm assembled from it, its URDF and its skin file.

use std::collections::BTreeMap;
use std::path::Path;

use glam::DVec3;
use schemars::JsonSchema;
use serde::Deserialize;
use underbrush_recording::{BodyShape, InputError, PLAIN, is_plain, parse_toml, short};

use super::inertia::{self, Entries};
use super::source::{Source, listed};
use super::start::passing_links;
use super::urdf::{Chain, Said, read_chain};
use super::{Arm, ArmSource, Joint, LinkCollider, limits, skin_file};
use crate::geometry::MAX_CORNERS;
use crate::range::Within;

/// An arm: its URDF, its skin, and the properties that URDF cannot express.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct ArmFile {
    /// Name of the robot; `robot_type` in data sets.
    name: String,
    /// Path of the URDF file, relative to this file.
    urdf: String,
    /// Path of the skin file, relative to this file.
    skin: String,
    /// The link that is fixed to the world. Its frame is the world frame.
    base_link: String,
    /// The link at the end of the chain whose frame the controller moves to goals (the end effector).
    tip_link: String,
    /// Coefficient of friction of the arm's surface, with or without skin.
    #[schemars(transform = Within(limits::FRICTION))]
    friction: f64,
    /// One table for each moving joint of the chain.
    #[schemars(length(min = 1))]
    joint: Vec<JointTable>,
    /// Convex collision shapes, in addition to those of the URDF, and in place of the meshes of their links.
    #[serde(default)]
    hull: Vec<HullTable>,
    /// Pairs of links that pass through each other instead of colliding. Links with one or two joints between them, and
    /// links that overlap in the start posture, always do.
    #[serde(default)]
    passing_links: Vec<[String; 2]>,
    /// Joints that are held fixed, such as those of fingers.
    #[serde(default)]
    held: Vec<HeldTable>,
    /// Inertia of links, in place of one in the URDF that no body has.
    #[serde(default)]
    inertia: Vec<InertiaTable>,
}

/// A joint: a spring and a damper about an equilibrium angle, which the controller moves.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct JointTable {
    /// Name of the joint in the URDF.
    name: String,
    /// Stiffness of the simulated joint.
    #[schemars(transform = Within(limits::STIFFNESS_NM_PER_RAD))]
    stiffness_nm_per_rad: f64,
    /// Damping of the simulated joint.
    #[schemars(transform = Within(limits::DAMPING_NM_S_PER_RAD))]
    damping_nm_s_per_rad: f64,
    /// Inertia of the drive, reflected through its gear.
    #[serde(default)]
    #[schemars(transform = Within(limits::ARMATURE_KG_M2))]
    armature_kg_m2: f64,
    /// Stiffness in the controller's model of the joint. Equal to `stiffness_nm_per_rad` unless the model is wrong on
    /// purpose.
    #[schemars(transform = Within(limits::STIFFNESS_NM_PER_RAD))]
    model_stiffness_nm_per_rad: f64,
    /// Smallest and largest angle that the controller asks for, within the joint limits of the URDF.
    #[schemars(transform = Within(limits::ANGLE_DEG))]
    controller_limits_deg: [f64; 2],
    /// Angle at the start of a reach, within `controller_limits_deg`.
    #[schemars(transform = Within(limits::ANGLE_DEG))]
    start_deg: f64,
}

/// A joint of the URDF that is held fixed.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct HeldTable {
    /// Name of the joint in the URDF.
    name: String,
    /// Angle at which a joint that turns is held.
    #[schemars(transform = Within(limits::ANGLE_DEG))]
    angle_deg: Option<f64>,
    /// Displacement at which a joint that slides is held.
    #[schemars(transform = Within(limits::PLACE_M))]
    displacement_m: Option<f64>,
}

/// The inertia of a link of the URDF.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct InertiaTable {
    /// The link of the URDF.
    link: String,
    /// ixx, ixy, ixz, iyy, iyz and izz, in the frame of the link's `<inertial>`. None of the principal moments is above the sum
    /// of the other two.
    #[schemars(transform = Within(limits::INERTIA_ENTRY_KG_M2))]
    entries_kg_m2: Entries,
}

/// A convex hull as a collision shape of a link.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct HullTable {
    /// The link that it belongs to.
    link: String,
    /// Four to 100 points, not all in one plane; their convex hull is the shape. Frame of the link.
    #[schemars(transform = Within(limits::PLACE_M), length(min = 4, max = 100))]
    points_m: Vec<[f64; 3]>,
}

/// Assembles an arm from the TOML file at `path` and the files that it names, relative to itself. `read` reads a file.
pub(super) fn assemble(path: &Path, read: &dyn Fn(&Path) -> Result<String, InputError>) -> Result<Arm, InputError> {
    let open = |path: &Path| Ok(Source { path: path.to_path_buf(), text: read(path)? });
    let source = open(path)?;
    let allowed = "the keys of an arm file, such as that of `cody`, which ships with underbrush";
    let file: ArmFile = parse_toml(path, &source.text, "TOML", allowed)?;
    if !is_plain(&file.name) {
        return Err(source.fault_at("name", format!("{:?}", file.name), PLAIN));
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let named = |key: &str, name: &str| {
        open(&folder.join(name)).map_err(|error| error.named_in(path, source.line_setting(key)))
    };
    let urdf = named("urdf", &file.urdf)?;
    let mut chain = read_held_chain(&source, &file, &urdf)?;
    source.check("friction", file.friction, limits::FRICTION)?;
    for (number, hull) in file.hull.iter().enumerate() {
        add_hull(&source, &format!("hull[{number}]"), hull, &mut chain)?;
    }
    let (end_effector_link, end_effector_pose_link) = chain.frame(&source, "tip_link", &file.tip_link)?;
    if end_effector_link + 1 != chain.links.len() {
        let at_end = chain.frames.iter().filter(|(_, (link, _))| link + 1 == chain.links.len());
        let names: Vec<&str> = at_end.map(|(name, _)| name.as_str()).collect();
        let allowed = format!("the last moving link or one that is fixed to it: {}", names.join(", "));
        return Err(source.fault_at("tip_link", &file.tip_link, allowed));
    }
    let passing = read_passing_links(&source, &file.passing_links, &chain)?;
    let skin_source = named("skin", &file.skin)?;
    let skin = skin_file::read_skin(&skin_source, &chain)?;
    let own_name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
    let files = [(own_name.into_owned(), &source.text), (file.urdf, &urdf.text), (file.skin, &skin_source.text)];
    let files = files.map(|(name, text)| ArmSource { name, text: text.clone() });
    let mut arm = Arm {
        name: file.name,
        files,
        joints: join_tables(&source, chain.joints, &file.joint)?,
        links: chain.links,
        end_effector_link,
        end_effector_pose_link,
        friction: file.friction,
        passing_links: passing,
        skin,
    };
    arm.passing_links = passing_links(&arm);
    Ok(arm)
}

/// The links of the pairs that the file names, the one nearer to the base first.
fn read_passing_links(source: &Source, pairs: &[[String; 2]], chain: &Chain) -> Result<Vec<[usize; 2]>, InputError> {
    let mut found = Vec::new();
    for (number, [name, other]) in pairs.iter().enumerate() {
        let place = format!("passing_links[{number}]");
        let [first, second] = [name, other].map(|name| chain.frame(source, &place, name));
        let (first, second) = (first?.0, second?.0);
        if first == second {
            let found = format!("{name:?} and {other:?}, one rigid link");
            return Err(source.fault_at(&place, found, "two links with a moving joint between them"));
        }
        found.push([first.min(second), first.max(second)]);
    }
    Ok(found)
}

/// Reads the chain of the URDF with the joints that the file holds.
fn read_held_chain(source: &Source, file: &ArmFile, urdf: &Source) -> Result<Chain, InputError> {
    let mut held = BTreeMap::new();
    for (number, table) in file.held.iter().enumerate() {
        let key = |key: &str| format!("held[{number}].{key}");
        source.check(&key("angle_deg"), table.angle_deg.unwrap_or(0.0), limits::ANGLE_DEG)?;
        source.check(&key("displacement_m"), table.displacement_m.unwrap_or(0.0), limits::PLACE_M)?;
        let place = table.angle_deg.map(f64::to_radians).or(table.displacement_m).unwrap_or(0.0);
        if held.insert(table.name.clone(), place).is_some() {
            return Err(source.fault_at(&key("name"), format!("a second {}", table.name), "one table for each joint"));
        }
    }
    let hulled = file.hull.iter().map(|hull| hull.link.clone()).collect();
    let inertia = read_inertia(source, &file.inertia)?;
    let chain = read_chain(urdf, source, &file.base_link, &Said { held, hulled, inertia })?;
    for (number, table) in file.inertia.iter().enumerate() {
        chain.frame(source, &format!("inertia[{number}].link"), &table.link)?;
    }
    for (number, table) in file.held.iter().enumerate() {
        let place = format!("held[{number}]");
        let Some(turns) = chain.held.get(&table.name) else {
            let allowed = "a joint of the URDF that is not fixed";
            return Err(source.fault_at(&format!("{place}.name"), &table.name, allowed));
        };
        if [table.angle_deg.is_some(), table.displacement_m.is_some()] != [*turns, !*turns] {
            let (key, kind) = if *turns { ("angle_deg", "turns") } else { ("displacement_m", "slides") };
            let allowed = format!("`{key}` alone, because {} {kind}", table.name);
            return Err(source.fault_at(&place, "another key, both or none", allowed));
        }
    }
    Ok(chain)
}

/// The inertia of links, by their names.
fn read_inertia(source: &Source, tables: &[InertiaTable]) -> Result<BTreeMap<String, Entries>, InputError> {
    let mut found = BTreeMap::new();
    for (number, table) in tables.iter().enumerate() {
        let entries = format!("inertia[{number}].entries_kg_m2");
        if let Some((found, allowed)) = inertia::fault(table.entries_kg_m2) {
            return Err(source.fault_at(&entries, found, allowed));
        }
        if found.insert(table.link.clone(), table.entries_kg_m2).is_some() {
            let found = format!("a second {}", table.link);
            return Err(source.fault_at(&format!("inertia[{number}].link"), found, "one table for each link"));
        }
    }
    Ok(found)
}

/// Combines each moving joint of the URDF with its table in the TOML file.
fn join_tables(source: &Source, chain: Vec<Joint>, tables: &[JointTable]) -> Result<Vec<Joint>, InputError> {
    for (number, JointTable { name, .. }) in tables.iter().enumerate() {
        let place = format!("joint[{number}].name");
        if !chain.iter().any(|joint| joint.name == *name) {
            let names: Vec<&str> = chain.iter().map(|joint| joint.name.as_str()).collect();
            return Err(source.fault_at(&place, name, format!("a moving joint of the URDF: {}", names.join(", "))));
        }
        if tables[..number].iter().any(|other| other.name == *name) {
            return Err(source.fault_at(&place, format!("a second {name}"), "one table for each joint"));
        }
    }
    chain
        .into_iter()
        .map(|joint| match tables.iter().position(|table| table.name == joint.name) {
            Some(number) => join_table(source, joint, number, &tables[number]),
            None => {
                let remedy = format!("add a [[joint]] table with name = \"{}\"", joint.name);
                Err(source.fault("joint", format!("none for {}", joint.name), "a table for each moving joint", remedy))
            }
        })
        .collect()
}

fn join_table(source: &Source, joint: Joint, number: usize, table: &JointTable) -> Result<Joint, InputError> {
    let place = |key: &str| format!("joint[{number}].{key}");
    // Errors name the joint, and not its place in the file.
    let named = |key: &str, error: InputError| InputError { field: format!("joint {}.{key}", joint.name), ..error };
    let fault = |key: &str, found: String, allowed: &str| named(key, source.fault_at(&place(key), found, allowed));
    let check = |key, value, limits| source.check(&place(key), value, limits).map_err(|error| named(key, error));
    check("stiffness_nm_per_rad", table.stiffness_nm_per_rad, limits::STIFFNESS_NM_PER_RAD)?;
    check("model_stiffness_nm_per_rad", table.model_stiffness_nm_per_rad, limits::STIFFNESS_NM_PER_RAD)?;
    check("damping_nm_s_per_rad", table.damping_nm_s_per_rad, limits::DAMPING_NM_S_PER_RAD)?;
    check("armature_kg_m2", table.armature_kg_m2, limits::ARMATURE_KG_M2)?;
    let degrees = table.controller_limits_deg;
    let limits_rad = degrees.map(f64::to_radians);
    let [lower, upper] = limits_rad;
    if !(degrees.iter().all(|angle| limits::ANGLE_DEG.hold(*angle)) && lower < upper) {
        let allowed = format!("two angles from {}, the smaller first", limits::ANGLE_DEG);
        return Err(fault("controller_limits_deg", listed(&degrees), &allowed));
    }
    if lower < joint.limits_rad[0] || upper > joint.limits_rad[1] {
        let [low, high] = joint.limits_rad.map(f64::to_degrees);
        let allowed = format!("within the URDF's limits, {low:.4} to {high:.4} deg");
        return Err(fault("controller_limits_deg", listed(&degrees), &allowed));
    }
    let start_rad = table.start_deg.to_radians();
    if !(lower..=upper).contains(&start_rad) {
        return Err(fault("start_deg", short(table.start_deg), &format!("an angle within {degrees:?} deg")));
    }
    Ok(Joint {
        stiffness_nm_per_rad: table.stiffness_nm_per_rad,
        damping_nm_s_per_rad: table.damping_nm_s_per_rad,
        armature_kg_m2: table.armature_kg_m2,
        model_stiffness_nm_per_rad: table.model_stiffness_nm_per_rad,
        controller_limits_rad: limits_rad,
        start_rad,
        ..joint
    })
}

fn add_hull(source: &Source, place: &str, hull: &HullTable, chain: &mut Chain) -> Result<(), InputError> {
    let points = format!("{place}.points_m");
    let (link, pose) = chain.frame(source, &format!("{place}.link"), &hull.link)?;
    if hull.points_m.len() > MAX_CORNERS {
        let found = format!("{} points", hull.points_m.len());
        let allowed = format!("at most {MAX_CORNERS} points; leave out those that hardly matter");
        return Err(source.fault_at(&points, found, allowed));
    }
    for point in &hull.points_m {
        source.check_each(&points, point, limits::PLACE_M)?;
    }
    let points_m: Vec<DVec3> = hull.points_m.iter().copied().map(DVec3::from_array).collect();
    let collider = LinkCollider::new(BodyShape::Hull { points_m }, pose);
    let volume_m3 = collider.as_ref().map_or(0.0, |collider| collider.placed_link.shape.mass_properties(1.0).mass());
    let Some(collider) = collider.filter(|_| limits::HULL_VOLUME_M3.hold(volume_m3)) else {
        let found = format!("{} points around {} m³", hull.points_m.len(), short(volume_m3));
        let allowed = format!("at least four points, not all in one plane, around {}", limits::HULL_VOLUME_M3);
        return Err(source.fault_at(&points, found, allowed));
    };
    chain.links[link].colliders.push(collider);
    Ok(())
}
