//! Writes the files of an arm from its URDF: the arm file, a skin file without patches, and a scene with room for this arm.
//! What the URDF does not say is derived by a rule, which the file states.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::{Component, Path, PathBuf};

use glam::DVec3;
use underbrush_recording::{InputError, short};

use super::hulls::{MeshHull, hulls};
use super::inertia::{self, Entries};
use super::mesh::read_triangles;
use super::new_text::{
    RULES, controller_limits_deg, held_tables, inertia_tables, joint_table, scene_text, skin_text, stiffness_nm_per_rad,
};
use super::source::{Source, quoted, read_from_disk, significant};
use super::start::Room;
use super::urdf::{Joint, Said, child, mesh, origin_pose, read_chain, text};
use super::urdf_text::{Element, Elements, attribute, named, number, numbers};
use super::{Arm, ArmSource};

/// The shortest reach, m. Choice: trunks are up to 5 cm thick.
const LEAST_REACH_M: f64 = 0.1;

/// What the files of an arm are made from.
#[derive(Clone, Debug, Default)]
pub struct NewArm {
    /// The URDF.
    pub urdf: PathBuf,
    /// The arm file to be written. It may not be there yet, but its folder is.
    pub out: PathBuf,
    /// The link that the controller moves to goals.
    pub tip_link: String,
    /// The fixed link; without one, the root of the URDF's tree that the tip is on.
    pub base_link: Option<String>,
    /// Folders of ROS packages, by name.
    pub packages: BTreeMap<String, PathBuf>,
    /// Most convex hulls for each mesh.
    pub hulls_per_mesh: usize,
}

/// The files of an arm. [`NewFiles::skin`] and [`NewFiles::scene`] are beside the arm file.
#[derive(Clone, Debug)]
pub struct NewFiles {
    /// The arm that they describe.
    pub arm: Arm,
    /// Text of the arm file.
    pub arm_file: String,
    /// Name and text of the skin file.
    pub skin: (PathBuf, String),
    /// Name and text of a scene with trunks.
    pub scene: (PathBuf, String),
    /// Whether a start posture was found with the tip in front of the base; otherwise the arm starts in the middle of its limits.
    pub start_found: bool,
    /// Joints that are held.
    pub held: Vec<String>,
    /// Number of hulls.
    pub hulls: usize,
    /// Links whose inertia is raised to that of a body, each with the share by which its largest principal moment exceeds the sum
    /// of the other two in the URDF.
    pub raised: Vec<(String, f64)>,
    /// How far corners of meshes stand out over their hulls at most, m.
    pub outside_hulls_m: f64,
}

/// Makes the files.
///
/// # Errors
/// When the URDF or a mesh cannot be read, has no chain of turning joints from base to tip, or the files would not describe an
/// arm.
pub fn new_files(new: &NewArm) -> Result<NewFiles, InputError> {
    let source = Source { path: new.urdf.clone(), text: read_from_disk(&new.urdf)? };
    let elements = Elements::read(&source)?;
    let tree = Tree::read(new, &source, &elements)?;
    let held = tree.held();
    let (hull_text, hulled, found) = tree.hull_tables(new, &elements)?;
    let places = held.iter().map(|(joint, place)| (joint.name.to_owned(), *place)).collect();
    let raised = tree.raised_inertia();
    let inertia = raised.iter().map(|(link, entries, _)| (link.clone(), *entries)).collect();
    let chain = read_chain(&source, &source, tree.base, &Said { held: places, hulled, inertia })?;
    let skin_path = new.out.with_extension("skin.toml");
    let names = [&new.urdf, &skin_path].map(|path| relative(&new.out, path));
    let skin_text = skin_text(&new.out);
    let name = new.out.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let file = |joints: &str| {
        let [base, tip, own, urdf, skin] = [tree.base, &new.tip_link, &name, &names[0], &names[1]].map(quoted);
        let (held, inertia) = (held_tables(&held), inertia_tables(&raised));
        format!(
            "# The arm {name}, written by `underbrush arm new`. docs/arms.md explains every key. What the URDF does not say\n\
             # follows the rules that are stated here; change what you know better.\n\n\
             name = {own}\nurdf = {urdf}\nskin = {skin}\n\n\
             # Its frame is the world frame: z up, x forward.\nbase_link = {base}\ntip_link = {tip}\n\n\
             # Choice: a knit cover, as on Cody.\nfriction = 0.3\n\n{RULES}{joints}{held}{inertia}{hull_text}"
        )
    };
    let assembled = |arm_file: &str| {
        let named = |name: &str, text: &str| ArmSource { name: name.to_owned(), text: text.to_owned() };
        let own = new.out.display().to_string();
        Arm::from_files(&[
            named(&own, arm_file),
            named(&beside(&new.out, &names[0]), &source.text),
            named(&beside(&new.out, &names[1]), &skin_text),
        ])
        // What is wrong with a file that is not written yet comes from the URDF.
        .map_err(|error| {
            let remedy = "correct the URDF, or the `scale` of its meshes";
            let own = source.fault(error.field.clone(), &error.found, error.allowed.clone(), remedy);
            if error.file == new.out { own } else { error }
        })
    };
    let limits_deg: Vec<[f64; 2]> = chain.joints.iter().map(controller_limits_deg).collect();
    let middle = |[low, high]: &[f64; 2]| ((low + high) * 5.0).round() / 10.0;
    let joints = chain.joints.iter().zip(&limits_deg);
    // Stiffness and damping do not matter for kinematics and inertia.
    let joints: String = joints.map(|(joint, own)| joint_table(joint, own, middle(own), [1.0, 1.0])).collect();
    let arm = assembled(&file(&joints))?;
    let room = Room::of(&arm);
    if room.reach_m < LEAST_REACH_M {
        let found = format!("a reach of {} m from the second joint to the tip", short(significant(room.reach_m, 2)));
        let allowed = format!("at least {LEAST_REACH_M} m, because trunks have no room around a smaller arm");
        let remedy = "give a --tip farther from the base, or correct the lengths in the URDF, which are in metres";
        return Err(source.fault("--tip", found, allowed, remedy));
    }
    let posture = room.start_posture(&arm);
    let rounded =
        |(angle, [low, high]): (&f64, &[f64; 2])| ((angle.to_degrees() * 10.0).round() / 10.0).clamp(*low, *high);
    let start_deg: Vec<f64> = match &posture {
        Some(posture) => posture.iter().zip(&limits_deg).map(rounded).collect(),
        None => limits_deg.iter().map(middle).collect(),
    };
    let start_rad: Vec<f64> = start_deg.iter().map(|angle| angle.to_radians()).collect();
    let inertia = arm.mass_matrix(&arm.forward_kinematics(&start_rad));
    let mut joints = match posture.is_some() {
        true => "# - start: the tip is drawn back in front of the base, level with the goals of the scene beside this file; of the\n\
                    #   postures found there, the one with the fewest links through each other and the most room to the limits.\n",
        false => "# - start: the middle of the limits. No posture was found with the tip in front of the base and above the table of\n\
                 #   the scene beside this file; choose one by hand.\n",
    }.to_owned();
    for (number, joint) in chain.joints.iter().enumerate() {
        let stiffness = stiffness_nm_per_rad(joint);
        let damping = significant(2.0 * (stiffness * inertia[(number, number)]).sqrt(), 2);
        joints += &joint_table(joint, &limits_deg[number], start_deg[number], [stiffness, damping]);
    }
    let arm_file = file(&joints);
    let arm = assembled(&arm_file)?;
    Ok(NewFiles {
        scene: (new.out.with_extension("trunks.toml"), scene_text(&new.out, &room)),
        skin: (skin_path, skin_text.clone()),
        start_found: posture.is_some(),
        held: held.iter().map(|(joint, _)| joint.name.to_owned()).collect(),
        hulls: found.len(),
        raised: raised.into_iter().map(|(link, _, share)| (link, share)).collect(),
        outside_hulls_m: found.iter().map(|hull| hull.outside_m).fold(0.0, f64::max),
        arm,
        arm_file,
    })
}

/// The links and joints below the base.
struct Tree<'a> {
    base: &'a str,
    /// Links, in the order of the file.
    links: Vec<Element<'a>>,
    joints: Vec<Joint<'a>>,
    /// Names of the joints from the tip to the base.
    chain: BTreeSet<&'a str>,
}

impl<'a> Tree<'a> {
    fn read(new: &'a NewArm, source: &Source, elements: &'a Elements<'a>) -> Result<Self, InputError> {
        let links: Vec<Element> = elements.of_kind("link").collect();
        let joints: Vec<Joint> = elements.of_kind("joint").map(Joint::of).collect();
        let names = || links.iter().map(|link| text(*link, "name"));
        let refused = |option: &str, found: &str, allowed: String| {
            source.fault(option, format!("{found:?}"), allowed, format!("give another {option}"))
        };
        let all_links = || format!("a link of the URDF: {}", names().collect::<Vec<_>>().join(", "));
        for (option, link) in [("--tip", Some(&new.tip_link)), ("--base", new.base_link.as_ref())] {
            if let Some(link) = link.filter(|link| !names().any(|name| name == *link)) {
                return Err(refused(option, link, all_links()));
            }
        }
        let mut known = BTreeSet::new();
        if let Some(Joint { name, .. }) = joints.iter().find(|joint| !known.insert(joint.name)) {
            let found = format!("joint {name} is there twice");
            return Err(source.fault("joint", found, "joints with names of their own", "rename one of them"));
        }
        let parent = |link: &str| joints.iter().find(|joint| joint.child == link);
        let given = new.base_link.as_deref();
        let no_chain = || {
            let allowed = format!("a link that turning joints carry on {}", given.unwrap_or("the root of the URDF"));
            Err(refused("--tip", &new.tip_link, allowed))
        };
        let mut chain = BTreeSet::new();
        // Without a given base it is the root of the tree that the tip is on.
        let mut base = new.tip_link.as_str();
        while given != Some(base) {
            match parent(base) {
                None if given.is_none() => break,
                Some(Joint { element, name, kind, parent, child })
                    if !["revolute", "continuous", "fixed"].contains(kind) =>
                {
                    let remedy = format!("give --base {child}, or --tip {parent}");
                    let allowed = "revolute, continuous or fixed from --base to --tip";
                    let fault = source.fault(format!("joint {name}, type"), kind, allowed, remedy);
                    return Err(fault.at_line(elements.line_of(*element)));
                }
                Some(joint) if chain.insert(joint.name) => base = joint.parent,
                _ => return no_chain(),
            }
        }
        if !joints.iter().any(|joint| joint.moves() && chain.contains(joint.name)) {
            return no_chain();
        }
        let mut below = BTreeSet::from([base]);
        // Every pass adds the next links; a loop adds none.
        while let Some(joint) = joints.iter().find(|joint| below.contains(joint.parent) && !below.contains(joint.child))
        {
            below.insert(joint.child);
        }
        Ok(Tree {
            base,
            links: links.iter().copied().filter(|link| below.contains(text(*link, "name"))).collect(),
            joints: joints.iter().copied().filter(|joint| below.contains(joint.child)).collect(),
            chain,
        })
    }

    /// The moving joints of side branches and beyond the tip, each with the place nearest to zero that its limits allow; a
    /// mimic joint follows its leader.
    fn held(&self) -> Vec<(Joint<'a>, f64)> {
        let own = |joint: &Joint| {
            let limit = child(joint.element, "limit").filter(|_| ["revolute", "prismatic"].contains(&joint.kind));
            0.0_f64.min(number(limit, "upper")).max(number(limit, "lower"))
        };
        let place = |joint: &Joint| {
            let mimic = child(joint.element, "mimic")?;
            let leader = self.joints.iter().find(|other| attribute(mimic, "joint") == Some(other.name))?;
            let factor = numbers(Some(mimic), "multiplier").map_or(1.0, |[factor]| factor);
            let followed = if self.chain.contains(leader.name) { 0.0 } else { own(leader) };
            Some(factor * followed + number(Some(mimic), "offset"))
        };
        let side = self.joints.iter().filter(|joint| joint.moves() && !self.chain.contains(joint.name));
        side.map(|joint| (*joint, place(joint).unwrap_or_else(|| own(joint)))).collect()
    }

    /// Links with an inertia that no body has, each with the nearest inertia of a body and the share by which its largest principal
    /// moment is too large. Links that have no such nearest inertia are left out.
    fn raised_inertia(&self) -> Vec<(String, Entries, f64)> {
        let of_link = |link: &Element<'a>| {
            let inertial = child(*link, "inertial").filter(|own| number(child(*own, "mass"), "value") > 0.0)?;
            let (entries, share) = inertia::raised(inertia::entries(child(inertial, "inertia")))?;
            Some((text(*link, "name").to_owned(), entries, share))
        };
        self.links.iter().filter_map(of_link).collect()
    }

    /// The `[[hull]]` tables of all meshes, the links that have some, and the hulls.
    fn hull_tables(
        &self,
        new: &NewArm,
        elements: &Elements,
    ) -> Result<(String, BTreeSet<String>, Vec<MeshHull>), InputError> {
        let (mut tables, mut hulled, mut all) = (String::new(), BTreeSet::new(), Vec::new());
        for link in &self.links {
            let name = text(*link, "name");
            let (kind, why) = match child(*link, "collision") {
                None => ("visual", ", a mesh for pictures, because the link has no collision shape"),
                Some(_) => ("collision", ""),
            };
            for part in named(*link, &[kind]) {
                let Some(mesh) = mesh(part) else { continue };
                let filename = text(mesh, "filename");
                let pose = origin_pose(child(part, "origin"));
                let scale = DVec3::from_array(numbers(Some(mesh), "scale").unwrap_or([1.0; 3]));
                let path = find_mesh(new, filename, elements.line_of(part))?;
                let placed = |corner: DVec3| pose.transform_point(corner * scale);
                let triangles: Vec<_> = read_triangles(&path)?.into_iter().map(|own| own.map(placed)).collect();
                let found = hulls(&triangles, new.hulls_per_mesh);
                if found.is_empty() {
                    let _ = writeln!(tables, "\n# {filename} of link {name} is flat and has no hull.");
                }
                for hull in &found {
                    hulled.insert(name.to_owned());
                    let (count, outside_mm, link) = (triangles.len(), hull.outside_m * 1000.0, quoted(name));
                    let _ = writeln!(
                        tables,
                        "\n# Of {filename}{why}; its {count} triangles extend at most {outside_mm:.1} mm beyond this hull.\n\
                         [[hull]]\nlink = {link}\npoints_m = ["
                    );
                    for point in &hull.points_m {
                        // Adding zero makes −0 a plain 0.
                        let [x, y, z] = (*point + 0.0).to_array();
                        let _ = writeln!(tables, "    [{x}, {y}, {z}],");
                    }
                    tables += "]\n";
                }
                all.extend(found);
            }
            let meshed = named(*link, &["collision"]).find(|part| mesh(*part).is_some());
            if let Some(part) = meshed.filter(|_| !hulled.contains(name)) {
                let field = format!("link {name}, collision");
                let remedy = "give the link another collision shape in the URDF, or none";
                let fault =
                    InputError::new(&new.urdf, field, "meshes that are all flat", "shapes with a volume", remedy);
                return Err(fault.at_line(elements.line_of(part)));
            }
        }
        Ok((tables, hulled, all))
    }
}

/// The file of a mesh: `package://NAME/…` in the folder given for the package, or in one of that name around the URDF; other
/// names are relative to the URDF.
fn find_mesh(new: &NewArm, filename: &str, line: usize) -> Result<PathBuf, InputError> {
    let folder = new.urdf.parent().unwrap_or(Path::new(""));
    let (mut places, mut remedy) = (Vec::new(), "give --package NAME=FOLDER");
    match filename.strip_prefix("package://").map(|rest| rest.split_once('/').unwrap_or((rest, ""))) {
        Some((package, rest)) => match new.packages.get(package) {
            Some(given) => places.push(given.join(rest)),
            None => {
                let folder = std::path::absolute(folder).unwrap_or_else(|_| folder.to_path_buf());
                for around in folder.ancestors() {
                    if around.file_name().is_some_and(|own| own == package) {
                        places.push(around.join(rest));
                    }
                    places.push(around.join(package).join(rest));
                }
            }
        },
        None => {
            places.push(folder.join(filename.strip_prefix("file://").unwrap_or(filename)));
            remedy = "put it there, or correct its name in the URDF";
        }
    }
    if let Some(found) = places.iter().position(|place| place.is_file()) {
        return Ok(places.swap_remove(found));
    }
    let searched: Vec<String> = places.iter().map(|place| place.display().to_string()).collect();
    let found = format!("{filename}, which is not in {}", searched.join(", nor "));
    Err(InputError::new(&new.urdf, "mesh filename", found, "a mesh that is there", remedy).at_line(line))
}

/// The path of a file from the folder of another one, which names it, with slashes on every machine; absolute if there is none.
pub(crate) fn relative(naming: &Path, file: &Path) -> String {
    let own = |path: &Path| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        std::fs::canonicalize(folder).or_else(|_| std::path::absolute(folder)).unwrap_or_else(|_| folder.into())
    };
    let (from, to) = (own(naming), own(file));
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let shared = from.components().zip(to.components()).take_while(|(one, other)| one == other).count();
    if shared == 0 {
        return to.join(name.as_ref()).display().to_string();
    }
    let up = from.components().skip(shared).map(|_| "..".to_owned());
    let down = to.components().skip(shared).map(|part: Component| part.as_os_str().to_string_lossy().into_owned());
    up.chain(down).chain([name.into_owned()]).collect::<Vec<_>>().join("/")
}

/// How the arm file finds a file that it names.
fn beside(arm_file: &Path, name: &str) -> String {
    arm_file.parent().unwrap_or(Path::new("")).join(name).display().to_string()
}
