//! Reads a URDF as a serial chain of rigid links. Links that are connected by fixed joints are merged into one.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DMat3, DQuat, DVec3, EulerRot};
use underbrush_recording::limits::{first_outside, short};
use underbrush_recording::{BodyShape, InputError, PLAIN, Pose, is_plain};

use super::inertia::{self, Entries};
use super::limits::{self, MAX_JOINTS};
use super::source::{Source, directions, listed, unit};
use super::urdf_text::{Element, Elements, SHAPES, attribute, named, number, numbers};
use super::{Link, LinkCollider};

/// A chain as described by a URDF.
pub(super) struct Chain {
    /// Links from the base on.
    pub(super) links: Vec<Link>,
    /// Joints from the base on, without what only an arm file says; joint j carries link j + 1.
    pub(super) joints: Vec<super::Joint>,
    /// For every URDF link of the chain, the index of the link it was merged into and its pose in that link's frame.
    pub(super) frames: BTreeMap<String, (usize, Pose)>,
    /// The joints that are held, each with whether it turns; otherwise it slides.
    pub(super) held: BTreeMap<String, bool>,
}

/// What an arm file says about its URDF.
pub(super) struct Said {
    /// Joints that are held, each at an angle, rad, or displacement, m.
    pub(super) held: BTreeMap<String, f64>,
    /// Links whose meshes are replaced by hulls.
    pub(super) hulled: BTreeSet<String>,
    /// Inertia of links, in place of that of the URDF.
    pub(super) inertia: BTreeMap<String, Entries>,
}

impl Chain {
    /// The link that the URDF's link `name` was merged into, and its pose in that link's frame. The name stands at `field`
    /// of a file.
    pub(super) fn frame(&self, source: &Source, field: &str, name: &str) -> Result<(usize, Pose), InputError> {
        self.frames.get(name).copied().ok_or_else(|| {
            let names: Vec<&str> = self.frames.keys().map(String::as_str).collect();
            source.fault_at(field, name, format!("a link of the chain: {}", names.join(", ")))
        })
    }
}

const NO_LOOP: &str = "each link once, from the base to the end effector";

/// Reads the chain that starts at `base`, which `arm_file` names.
pub(super) fn read_chain(source: &Source, arm_file: &Source, base: &str, said: &Said) -> Result<Chain, InputError> {
    let elements = Elements::read(source)?;
    let reader = Reader {
        elements: &elements,
        links: elements.of_kind("link").map(|link| (text(link, "name"), link)).collect(),
        joints: elements.of_kind("joint").map(Joint::of).collect(),
        said,
    };
    reader.check_names()?;
    let mut chain =
        Chain { links: Vec::new(), joints: Vec::new(), frames: BTreeMap::new(), held: reader.held_joints()? };
    let Some(base) = reader.links.get(base).copied() else {
        let names: Vec<&str> = reader.links.keys().copied().collect();
        return Err(arm_file.fault_at("base_link", base, format!("a link of the URDF: {}", names.join(", "))));
    };
    let mut root = base;
    loop {
        let frames = reader.rigid_group(root)?;
        let joint = reader.next_joint(&frames)?;
        let link = reader.join(&frames, chain.links.is_empty())?;
        for (part, pose) in &frames {
            if chain.frames.insert(text(*part, "name").to_owned(), (chain.links.len(), *pose)).is_some() {
                return Err(elements.fault(*part, "", "a loop", NO_LOOP));
            }
        }
        chain.links.push(link);
        let Some((joint, origin_parent)) = joint else { break };
        if chain.joints.len() == MAX_JOINTS {
            let allowed = format!("at most {MAX_JOINTS} moving joints");
            return Err(elements.fault(joint.element, "", "one more moving joint", &allowed));
        }
        chain.joints.push(reader.joint(&joint, origin_parent)?);
        root = reader.links[joint.child];
    }
    if chain.joints.is_empty() {
        return Err(elements.fault(base, "", "no moving joint on it", "the base link of the arm"));
    }
    Ok(chain)
}

struct Reader<'a> {
    elements: &'a Elements<'a>,
    /// The links, by name.
    links: BTreeMap<&'a str, Element<'a>>,
    joints: Vec<Joint<'a>>,
    said: &'a Said,
}

/// A joint of the file.
#[derive(Clone, Copy)]
pub(super) struct Joint<'a> {
    pub(super) element: Element<'a>,
    pub(super) name: &'a str,
    pub(super) kind: &'a str,
    /// Names of its links.
    pub(super) parent: &'a str,
    pub(super) child: &'a str,
}

impl<'a> Joint<'a> {
    pub(super) fn of(element: Element<'a>) -> Self {
        let [name, kind] = ["name", "type"].map(|key| text(element, key));
        let [parent, child] = ["parent", "child"].map(|end| child(element, end).map_or("", |end| text(end, "link")));
        Joint { element, name, kind, parent, child }
    }

    /// Whether the file lets it move.
    pub(super) fn moves(&self) -> bool {
        self.kind != "fixed"
    }
}

/// The value of an attribute that the file has, because it was checked.
pub(super) fn text<'a>(element: Element<'a>, key: &str) -> &'a str {
    attribute(element, key).unwrap_or_default()
}

/// The first child with this name.
pub(super) fn child<'a>(element: Element<'a>, name: &str) -> Option<Element<'a>> {
    named(element, &[name]).next()
}

/// The mesh of a `<collision>` or `<visual>`.
pub(super) fn mesh(owner: Element) -> Option<Element> {
    child(child(owner, "geometry")?, "mesh")
}

/// The pose that an `<origin>` gives; the identity without one.
pub(super) fn origin_pose(origin: Option<Element>) -> Pose {
    let [xyz, [roll, pitch, yaw]] = ["xyz", "rpy"].map(|key| numbers(origin, key).unwrap_or_default());
    Pose::new(DVec3::from_array(xyz), DQuat::from_euler(EulerRot::ZYX, yaw, pitch, roll))
}

/// Rigidly connected URDF links with their poses in the first one's frame.
type RigidGroup<'a> = Vec<(Element<'a>, Pose)>;

impl<'a> Reader<'a> {
    fn check_names(&self) -> Result<(), InputError> {
        let mut names = BTreeSet::new();
        let mut check_name = |kind: &'static str, element: Element<'a>| {
            let name = text(element, "name");
            let fault = |found: String, allowed: &str| Err(self.elements.fault(element, "name", found, allowed));
            match names.insert((kind, name)) {
                false => fault(format!("a second {kind} of this name"), "unique names"),
                true if is_plain(name) => Ok(()),
                true => fault(format!("{name:?}"), PLAIN),
            }
        };
        self.elements.of_kind("link").try_for_each(|link| check_name("link", link))?;
        let mut children = BTreeSet::new();
        for joint in &self.joints {
            check_name("joint", joint.element)?;
            let fault = |key: &str, found: &str, allowed: &str| self.elements.fault(joint.element, key, found, allowed);
            for (end, link) in [("parent", joint.parent), ("child", joint.child)] {
                if !self.links.contains_key(link) {
                    return Err(fault(end, link, "the name of a link of this URDF"));
                }
            }
            if !children.insert(joint.child) {
                let found = format!("{}, which another joint carries already", joint.child);
                return Err(fault("child", &found, "one parent for each link"));
            }
        }
        Ok(())
    }

    fn is_fixed(&self, joint: &Joint) -> bool {
        !joint.moves() || self.said.held.contains_key(joint.name)
    }

    /// All links that fixed joints connect to `root`.
    fn rigid_group(&self, root: Element<'a>) -> Result<RigidGroup<'a>, InputError> {
        let mut frames = vec![(root, Pose::IDENTITY)];
        let mut next = 0;
        while let Some((parent, pose)) = frames.get(next).copied() {
            let carried = |joint: &&Joint| self.is_fixed(joint) && joint.parent == text(parent, "name");
            for joint in self.joints.iter().filter(carried) {
                let child = self.links[joint.child];
                if frames.iter().any(|(part, _)| *part == child) {
                    return Err(self.elements.fault(joint.element, "child", "a loop", NO_LOOP));
                }
                frames.push((child, pose * self.joint_origin(joint)?));
            }
            next += 1;
        }
        Ok(frames)
    }

    /// The one moving joint on a rigid group, with its pose in the group's frame; `None` at the end of the chain.
    fn next_joint(&self, frames: &RigidGroup<'a>) -> Result<Option<(Joint<'a>, Pose)>, InputError> {
        let mut next: Option<(Joint, Pose)> = None;
        for joint in self.joints.iter().filter(|joint| !self.is_fixed(joint)) {
            let Some((_, pose)) = frames.iter().find(|(part, _)| text(*part, "name") == joint.parent) else {
                continue;
            };
            if let Some((other, _)) = next {
                let found = format!("{} and {} on the same rigid link", other.name, joint.name);
                let allowed = "a serial chain (hold the joints of side branches by [[held]] in the arm's TOML file)";
                return Err(self.elements.fault(joint.element, "parent", found, allowed));
            }
            next = Some((*joint, *pose * self.joint_origin(joint)?));
        }
        Ok(next)
    }

    /// Pose of a joint's child in its parent at angle 0, or where the joint is held.
    fn joint_origin(&self, joint: &Joint) -> Result<Pose, InputError> {
        let origin = self.pose(child(joint.element, "origin"))?;
        let Some(place) = self.said.held.get(joint.name).filter(|_| joint.moves()) else { return Ok(origin) };
        let axis = self.axis(joint)?;
        Ok(origin
            * match joint.kind {
                "prismatic" => Pose::new(axis * *place, DQuat::IDENTITY),
                _ => Pose::from_orientation(DQuat::from_axis_angle(axis, *place)),
            })
    }

    fn axis(&self, joint: &Joint) -> Result<DVec3, InputError> {
        let axis = numbers(child(joint.element, "axis"), "xyz").unwrap_or([1.0, 0.0, 0.0]);
        unit(axis).ok_or_else(|| self.elements.fault(joint.element, "axis", listed(&axis), &directions()))
    }

    /// The joints that are held, each with whether it turns.
    fn held_joints(&self) -> Result<BTreeMap<String, bool>, InputError> {
        let held = self.joints.iter().filter(|joint| joint.moves() && self.is_fixed(joint));
        held.map(|joint| match joint.kind {
            "revolute" | "continuous" => Ok((joint.name.to_owned(), true)),
            "prismatic" => Ok((joint.name.to_owned(), false)),
            other => {
                let allowed = "revolute, continuous or prismatic, to be held";
                Err(self.elements.fault(joint.element, "type", other, allowed))
            }
        })
        .collect()
    }

    fn joint(&self, joint: &Joint, origin_parent: Pose) -> Result<super::Joint, InputError> {
        let fault = |key: &str, found: &str, allowed: &str| self.elements.fault(joint.element, key, found, allowed);
        let limit = child(joint.element, "limit");
        let [lower, upper, effort, velocity] = ["lower", "upper", "effort", "velocity"].map(|key| number(limit, key));
        if matches!(joint.kind, "revolute" | "continuous") && limit.is_none() {
            let allowed = "a <limit> with effort and velocity and, of a revolute joint, lower and upper";
            return Err(fault("", "no <limit>", allowed));
        }
        let limits_rad = match joint.kind {
            "revolute" => [lower, upper],
            "continuous" => [f64::NEG_INFINITY, f64::INFINITY],
            other => {
                let allowed = "revolute, continuous or fixed (or hold it by [[held]] in the arm's TOML file)";
                return Err(fault("type", other, allowed));
            }
        };
        if child(joint.element, "mimic").is_some() {
            return Err(fault("mimic", "a coupled joint", "independent joints"));
        }
        let values = [
            ("lower", lower, limits::ANGLE_RAD),
            ("upper", upper, limits::ANGLE_RAD),
            ("effort", effort, limits::TORQUE_NM),
            ("velocity", velocity, limits::SPEED_RAD_PER_S),
        ];
        if let Some((key, found, allowed)) = first_outside(values) {
            return Err(self.elements.fault(limit.unwrap_or(joint.element), key, found, &allowed));
        }
        if limits_rad[0] >= limits_rad[1] {
            return Err(fault("limit", &format!("{} to {}", limits_rad[0], limits_rad[1]), "lower below upper, rad"));
        }
        Ok(super::Joint {
            name: joint.name.to_owned(),
            origin_parent,
            axis_child: self.axis(joint)?,
            limits_rad,
            torque_limit_nm: effort,
            slew_limit_rad_per_s: velocity,
            ..super::Joint::default()
        })
    }

    /// Merges a rigid group into one link. Only the base may have no inertia, because it does not move.
    fn join(&self, frames: &RigidGroup<'a>, is_base: bool) -> Result<Link, InputError> {
        let (root, _) = frames[0];
        let mut parts = Vec::new();
        let mut colliders = Vec::new();
        for (link, pose) in frames {
            if let Some(inertial) = child(*link, "inertial") {
                let mass = number(child(inertial, "mass"), "value");
                if !limits::MASS_KG.hold(mass) {
                    return Err(self.elements.fault(inertial, "mass", short(mass), &limits::MASS_KG.to_string()));
                }
                if mass > 0.0 {
                    let frame = *pose * self.pose(child(inertial, "origin"))?;
                    parts.push((mass, frame.position, self.inertia(*link, inertial, frame.orientation)?));
                }
            }
            for collision in named(*link, &["collision"]) {
                if self.said.hulled.contains(text(*link, "name")) && mesh(collision).is_some() {
                    continue;
                }
                let frame = self.pose(child(collision, "origin"))?;
                colliders.extend(LinkCollider::new(self.shape(collision)?, *pose * frame));
            }
        }
        let mass_kg: f64 = parts.iter().map(|(mass, ..)| mass).sum();
        if mass_kg <= 0.0 && !is_base {
            let allowed = "an <inertial> with a positive mass, because the link moves";
            return Err(self.elements.fault(root, "inertial", "no mass", allowed));
        }
        let center = parts.iter().map(|(mass, center, _)| *center * *mass).sum::<DVec3>() / mass_kg;
        let center_of_mass_link = if parts.is_empty() { DVec3::ZERO } else { center };
        let mut inertia_link = DMat3::ZERO;
        for (mass, center, inertia) in &parts {
            // Parallel axis theorem: m (r² 1 − r rᵀ).
            let r = *center - center_of_mass_link;
            let outer = DMat3::from_cols(r * r.x, r * r.y, r * r.z);
            inertia_link += *inertia + (DMat3::IDENTITY * r.length_squared() - outer) * *mass;
        }
        let mut names = frames.iter().map(|(link, _)| text(*link, "name").to_owned());
        let name = names.next().unwrap_or_default();
        Ok(Link { name, joined: names.collect(), mass_kg, center_of_mass_link, inertia_link, colliders })
    }

    /// The inertia of a link about the centre of mass, rotated by `rotation`.
    fn inertia(&self, link: Element, inertial: Element, rotation: DQuat) -> Result<DMat3, InputError> {
        let said = self.said.inertia.get(text(link, "name")).copied();
        let entries = said.unwrap_or_else(|| inertia::entries(child(inertial, "inertia")));
        let [xx, xy, xz, yy, yz, zz] = entries;
        if let Some((found, allowed)) = inertia::fault(entries) {
            let allowed =
                format!("{allowed} (or [[inertia]] in the arm's TOML file, which `underbrush arm new` writes)");
            return Err(self.elements.fault(inertial, "inertia", found, &allowed));
        }
        let rotation = DMat3::from_quat(rotation);
        let matrix = DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz));
        Ok(rotation * matrix * rotation.transpose())
    }

    fn shape(&self, collision: Element) -> Result<BodyShape, InputError> {
        let geometry = child(collision, "geometry");
        let shape = geometry.and_then(|geometry| named(geometry, SHAPES).next());
        let [radius_m, length_m] = ["radius", "length"].map(|key| number(shape, key));
        let shape = match shape.map_or("", |shape| shape.tag_name().name()) {
            "sphere" => BodyShape::Sphere { radius_m },
            "cylinder" => BodyShape::Cylinder { radius_m, length_m },
            "capsule" => BodyShape::Capsule { radius_m, length_m },
            "box" => BodyShape::Box { size_m: DVec3::from_array(numbers(shape, "size").unwrap_or_default()) },
            _ => {
                let allowed = "box, cylinder, capsule or sphere; or [[hull]] for this link in the arm's TOML file, in place of \
                               its meshes (`underbrush arm new` makes them)";
                let filename = shape.map_or("", |mesh| text(mesh, "filename"));
                return Err(self.elements.fault(collision, "geometry", format!("mesh {filename}"), allowed));
            }
        };
        let sizes = shape.numbers();
        if sizes.iter().any(|size| !limits::SIZE_M.hold(*size)) {
            let allowed = format!("sizes of {}", limits::SIZE_M);
            return Err(self.elements.fault(collision, "geometry", listed(&sizes), &allowed));
        }
        Ok(shape)
    }

    /// The pose that an `<origin>` gives.
    fn pose(&self, origin: Option<Element>) -> Result<Pose, InputError> {
        for (key, limits) in [("xyz", limits::PLACE_M), ("rpy", limits::ANGLE_RAD)] {
            let given: Option<(Element, [f64; 3])> = origin.zip(numbers(origin, key));
            if let Some((origin, given)) = given.filter(|(_, own)| own.iter().any(|number| !limits.hold(*number))) {
                let found = format!("{key} {}", listed(&given));
                return Err(self.elements.fault(origin, "", found, &format!("numbers from {limits}")));
            }
        }
        Ok(origin_pose(origin))
    }
}
