//! From a URDF to a serial chain of rigid links: links that fixed joints join become one.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;

use glam::{DMat3, DQuat, DVec3, EulerRot};
use rapier3d::prelude::Pose;
use underbrush_recording::InputError;
use urdf_rs::{Geometry, JointType, Robot};

use super::source::Source;
use super::{Link, LinkCollider, LinkShape};

/// What the URDF says of a chain.
pub(super) struct Chain {
    /// Links from the base on.
    pub(super) links: Vec<Link>,
    /// Joints from the base on; joint j carries link j + 1.
    pub(super) joints: Vec<ChainJoint>,
    /// Where every URDF link of the chain ended up: link index and pose in that link's frame.
    pub(super) frames: BTreeMap<String, (usize, Pose)>,
}

/// What the URDF says of a joint.
pub(super) struct ChainJoint {
    pub(super) name: String,
    pub(super) origin_parent: Pose,
    pub(super) axis_child: DVec3,
    pub(super) limits_rad: [f64; 2],
    pub(super) torque_limit_nm: f64,
    pub(super) velocity_limit_rad_per_s: f64,
}

const REMEDY: &str = "mend the URDF";

/// Reads the chain that hangs on `base`.
pub(super) fn read_chain(source: &Source, base: &str) -> Result<Chain, InputError> {
    let robot = urdf_rs::read_from_string(&source.text)
        .map_err(|error| source.fault("robot", error, "a URDF robot description", REMEDY))?;
    let reader = Reader { source, robot: &robot };
    reader.check_names()?;
    let mut chain = Chain {
        links: Vec::new(),
        joints: Vec::new(),
        frames: BTreeMap::new(),
    };
    let mut root = base;
    loop {
        let frames = reader.rigid_group(root)?;
        let joint = reader.next_joint(&frames)?;
        let link = reader.join(&frames, chain.links.is_empty())?;
        for (name, pose) in &frames {
            if chain
                .frames
                .insert((*name).to_string(), (chain.links.len(), *pose))
                .is_some()
            {
                return Err(reader.link_fault(name, "", "a loop", "each link once, from base to tip"));
            }
        }
        chain.links.push(link);
        let Some((joint, origin_parent)) = joint else { break };
        chain.joints.push(reader.joint(joint, origin_parent)?);
        root = &joint.child.link;
    }
    if chain.joints.is_empty() {
        return Err(reader.link_fault(base, "", "no moving joint on it", "a base link that carries the arm"));
    }
    Ok(chain)
}

struct Reader<'a> {
    source: &'a Source,
    robot: &'a Robot,
}

/// Rigidly joined URDF links with their poses in the first one's frame.
type RigidGroup<'a> = Vec<(&'a str, Pose)>;

impl<'a> Reader<'a> {
    fn check_names(&self) -> Result<(), InputError> {
        let mut links = BTreeSet::new();
        for link in &self.robot.links {
            if !links.insert(link.name.as_str()) {
                return Err(self.link_fault(&link.name, "name", "a second link of this name", "unique names"));
            }
        }
        let mut joints = BTreeSet::new();
        let mut children = BTreeSet::new();
        for joint in &self.robot.joints {
            if !joints.insert(joint.name.as_str()) {
                return Err(self.joint_fault(joint, "name", "a second joint of this name", "unique names"));
            }
            for (end, link) in [("parent", &joint.parent.link), ("child", &joint.child.link)] {
                if !links.contains(link.as_str()) {
                    return Err(self.joint_fault(joint, end, link, "the name of a link of this URDF"));
                }
            }
            if !children.insert(joint.child.link.as_str()) {
                let found = format!("{}, which another joint carries already", joint.child.link);
                return Err(self.joint_fault(joint, "child", found, "one parent for each link"));
            }
        }
        Ok(())
    }

    /// All links that fixed joints hang on `root`.
    fn rigid_group(&self, root: &'a str) -> Result<RigidGroup<'a>, InputError> {
        let mut frames = vec![(root, Pose::IDENTITY)];
        let mut next = 0;
        while let Some((parent, pose)) = frames.get(next).copied() {
            for joint in &self.robot.joints {
                if joint.parent.link == parent && joint.joint_type == JointType::Fixed {
                    if frames.iter().any(|(name, _)| *name == joint.child.link) {
                        return Err(self.joint_fault(joint, "child", "a loop", "each link once, from base to tip"));
                    }
                    frames.push((
                        &joint.child.link,
                        pose * self.pose(&joint.name, "joint", &joint.origin)?,
                    ));
                }
            }
            next += 1;
        }
        Ok(frames)
    }

    /// The one moving joint that a rigid group carries, with its pose in the group's frame; `None` at the end.
    fn next_joint(&self, frames: &RigidGroup<'a>) -> Result<Option<(&'a urdf_rs::Joint, Pose)>, InputError> {
        let mut next: Option<(&urdf_rs::Joint, Pose)> = None;
        for joint in self
            .robot
            .joints
            .iter()
            .filter(|joint| joint.joint_type != JointType::Fixed)
        {
            let Some((_, pose)) = frames.iter().find(|(name, _)| *name == joint.parent.link) else {
                continue;
            };
            if let Some((other, _)) = next {
                let found = format!("{} and {} on the same rigid link", other.name, joint.name);
                return Err(self.joint_fault(
                    joint,
                    "parent",
                    found,
                    "a serial chain (fix the joints of side branches)",
                ));
            }
            next = Some((joint, *pose * self.pose(&joint.name, "joint", &joint.origin)?));
        }
        Ok(next)
    }

    fn joint(&self, joint: &urdf_rs::Joint, origin_parent: Pose) -> Result<ChainJoint, InputError> {
        let limits_rad = match joint.joint_type {
            JointType::Revolute => [joint.limit.lower, joint.limit.upper],
            JointType::Continuous => [f64::NEG_INFINITY, f64::INFINITY],
            _ => {
                return Err(self.joint_fault(
                    joint,
                    "type",
                    format!("{:?}", joint.joint_type),
                    "revolute, continuous or fixed",
                ));
            }
        };
        if joint.mimic.is_some() {
            return Err(self.joint_fault(joint, "mimic", "a coupled joint", "independent joints"));
        }
        if limits_rad[0].is_nan() || limits_rad[1].is_nan() || limits_rad[0] >= limits_rad[1] {
            let found = format!("{} to {}", limits_rad[0], limits_rad[1]);
            return Err(self.joint_fault(joint, "limit", found, "lower below upper, rad"));
        }
        for (field, value) in [
            ("limit.effort", joint.limit.effort),
            ("limit.velocity", joint.limit.velocity),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(self.joint_fault(joint, field, value, "a positive number (Nm; rad/s)"));
            }
        }
        let axis = DVec3::from_array(joint.axis.xyz.0);
        let axis_child = axis
            .try_normalize()
            .ok_or_else(|| self.joint_fault(joint, "axis", format!("{axis}"), "three finite numbers, not all zero"))?;
        Ok(ChainJoint {
            name: joint.name.clone(),
            origin_parent,
            axis_child,
            limits_rad,
            torque_limit_nm: joint.limit.effort,
            velocity_limit_rad_per_s: joint.limit.velocity,
        })
    }

    /// Joins a rigid group to one link. Only the base may be without inertia: it never moves.
    fn join(&self, frames: &RigidGroup<'a>, is_base: bool) -> Result<Link, InputError> {
        let name = frames.first().map_or("", |(name, _)| *name);
        let mut parts = Vec::new();
        let mut colliders = Vec::new();
        for (part, pose) in frames {
            let Some(link) = self.robot.links.iter().find(|link| link.name == *part) else {
                return Err(self.link_fault(part, "name", "no such link", "the name of a link of this URDF"));
            };
            let inertial = &link.inertial;
            let mass = inertial.mass.value;
            if !(mass.is_finite() && mass >= 0.0) {
                return Err(self.link_fault(part, "inertial.mass", mass, "a finite number, kg, not negative"));
            }
            if mass > 0.0 {
                let frame = *pose * self.pose(part, "link", &inertial.origin)?;
                parts.push((
                    mass,
                    frame.translation,
                    self.inertia(part, &inertial.inertia, frame.rotation)?,
                ));
            }
            for collision in &link.collision {
                let frame = self.pose(part, "link", &collision.origin)?;
                colliders.push(LinkCollider {
                    shape: self.shape(part, &collision.geometry)?,
                    pose_link: *pose * frame,
                });
            }
        }
        let mass_kg: f64 = parts.iter().map(|(mass, ..)| mass).sum();
        if mass_kg <= 0.0 && !is_base {
            return Err(self.link_fault(
                name,
                "inertial",
                "no mass",
                "an <inertial> with a positive mass: the link moves",
            ));
        }
        let center = parts.iter().map(|(mass, center, _)| *center * *mass).sum::<DVec3>() / mass_kg;
        let center_of_mass_link = if parts.is_empty() { DVec3::ZERO } else { center };
        let mut inertia_link = DMat3::ZERO;
        for (mass, center, inertia) in &parts {
            // Parallel axes (Steiner): m (r² 1 − r rᵀ).
            let r = *center - center_of_mass_link;
            let outer = DMat3::from_cols(r * r.x, r * r.y, r * r.z);
            inertia_link += *inertia + (DMat3::IDENTITY * r.length_squared() - outer) * *mass;
        }
        Ok(Link {
            name: name.to_string(),
            mass_kg,
            center_of_mass_link,
            inertia_link,
            colliders,
        })
    }

    /// The inertia about the centre of mass, turned by `rotation`. A body's principal moments are positive and none
    /// exceeds the sum of the other two.
    fn inertia(&self, link: &str, given: &urdf_rs::Inertia, rotation: DQuat) -> Result<DMat3, InputError> {
        let entries = [given.ixx, given.ixy, given.ixz, given.iyy, given.iyz, given.izz];
        let [xx, xy, xz, yy, yz, zz] = entries;
        if entries.iter().any(|entry| !entry.is_finite()) {
            return Err(self.link_fault(
                link,
                "inertial.inertia",
                format!("{entries:?}"),
                "finite numbers, kg m²",
            ));
        }
        let matrix = nalgebra::Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let mut moments = matrix.symmetric_eigenvalues();
        moments.as_mut_slice().sort_by(f64::total_cmp);
        // Figures rounded to a few digits may miss the triangle inequality by that rounding.
        if moments[0] <= 0.0 || moments[2] > (moments[0] + moments[1]) * 1.001 {
            let found = format!("principal moments {:e}, {:e}, {:e}", moments[0], moments[1], moments[2]);
            let allowed = "positive principal moments, none above the sum of the other two";
            return Err(self.link_fault(link, "inertial.inertia", found, allowed));
        }
        let turn = DMat3::from_quat(rotation);
        let matrix = DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz));
        Ok(turn * matrix * turn.transpose())
    }

    fn shape(&self, link: &str, geometry: &Geometry) -> Result<LinkShape, InputError> {
        let (sizes, shape) = match geometry {
            Geometry::Sphere { radius } => (vec![*radius], LinkShape::Sphere { radius_m: *radius }),
            Geometry::Cylinder { radius, length } => (
                vec![*radius, *length],
                LinkShape::Cylinder {
                    radius_m: *radius,
                    length_m: *length,
                },
            ),
            Geometry::Capsule { radius, length } => (
                vec![*radius, *length],
                LinkShape::Capsule {
                    radius_m: *radius,
                    length_m: *length,
                },
            ),
            Geometry::Box { size } => (
                size.0.to_vec(),
                LinkShape::Box {
                    size_m: DVec3::from_array(size.0),
                },
            ),
            Geometry::Mesh { filename, .. } => {
                let allowed = "box, cylinder, capsule or sphere (give other shapes as [[hull]] in the arm's TOML file)";
                return Err(self.link_fault(link, "collision.geometry", format!("mesh {filename}"), allowed));
            }
        };
        if sizes.iter().any(|size| !(size.is_finite() && *size > 0.0)) {
            return Err(self.link_fault(link, "collision.geometry", format!("{sizes:?}"), "positive sizes, m"));
        }
        Ok(shape)
    }

    fn pose(&self, name: &str, element: &str, origin: &urdf_rs::Pose) -> Result<Pose, InputError> {
        let [roll, pitch, yaw] = origin.rpy.0;
        let translation = DVec3::from_array(origin.xyz.0);
        if !translation.is_finite() || ![roll, pitch, yaw].iter().all(|angle| angle.is_finite()) {
            let found = format!("xyz {translation}, rpy {:?}", origin.rpy.0);
            return Err(self.fault(element, name, "origin", found, "finite numbers"));
        }
        Ok(Pose::from_parts(
            translation,
            DQuat::from_euler(EulerRot::ZYX, yaw, pitch, roll),
        ))
    }

    fn link_fault(&self, link: &str, field: &str, found: impl Display, allowed: &str) -> InputError {
        self.fault("link", link, field, found, allowed)
    }

    fn joint_fault(&self, joint: &urdf_rs::Joint, field: &str, found: impl Display, allowed: &str) -> InputError {
        self.fault("joint", &joint.name, field, found, allowed)
    }

    fn fault(&self, element: &str, name: &str, field: &str, found: impl Display, allowed: &str) -> InputError {
        let place = format!("{element} {name}");
        let place = if field.is_empty() {
            place
        } else {
            format!("{place}, {field}")
        };
        let fault = self.source.fault(place, found, allowed, REMEDY);
        match self.source.line_of_element(element, name) {
            Some(line) => fault.at_line(line),
            None => fault,
        }
    }
}
