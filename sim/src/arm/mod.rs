//! The arm as data: a serial chain of links on compliant revolute joints, with tactile skin.
//!
//! An arm is described by three files. A URDF holds what URDF can express (links, inertia, joint axes, limits,
//! collision shapes). A TOML file that names the URDF holds the rest (springs, dampers, the controller's model
//! stiffness, start posture, convex hulls). A skin file places patches of taxels on links. The robot Cody ships as such
//! files.

use std::f64::consts::PI;
use std::path::Path;

use glam::{DMat3, DVec3};
use underbrush_recording::{BodyShape, InputError, Pose, SkinLayout};

use crate::contact::surface::Surface;
use crate::geometry::{PlacedShape, engine_shape};

pub mod cover;
mod file;
mod hulls;
mod inertia;
pub mod kinematics;
pub(crate) mod limits;
pub mod mesh;
pub mod new;
mod new_text;
pub mod skin;
mod skin_file;
mod skin_fit;
mod source;
mod start;
mod urdf;
mod urdf_text;
pub mod wedge;

pub use skin::Skin;
pub use start::{ArmAtStart, SkinAlongArm};

/// A serial arm. Its base link is fixed, and the base link's frame is the world frame.
///
/// ```
/// use underbrush_sim::arm::Arm;
///
/// let arm = Arm::cody()?;
/// assert_eq!(arm.joints.len(), 7);
/// let taxels: usize = arm.skin.layout.patches.iter().map(|patch| patch.taxels.len()).sum();
/// assert_eq!(taxels, 384 + 69);
/// # Ok::<(), underbrush_recording::InputError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Arm {
    /// Name.
    pub name: String,
    /// The links from the base to the end of the chain: link 0 is fixed, joint j carries link j + 1.
    pub links: Vec<Link>,
    /// The joints from the base to the end of the chain.
    pub joints: Vec<Joint>,
    /// The link that carries the end effector, index in [`Arm::links`].
    pub end_effector_link: usize,
    /// Pose of the end effector in that link's frame.
    pub end_effector_pose_link: Pose,
    /// Coefficient of friction of its surface.
    pub friction: f64,
    /// Pairs of links that pass through each other instead of colliding, the one nearer to the base first, indices in
    /// [`Arm::links`].
    pub passing_links: Vec<[usize; 2]>,
    /// The skin.
    pub skin: Skin,
    /// The files that it was read from, for the provenance of data sets: the TOML file, the URDF and the skin file.
    pub files: [ArmSource; 3],
}

/// A file of an arm, as it was read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ArmSource {
    /// Its name, relative to the folder of the arm's TOML file.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// One rigid link. The origin of its frame is at the joint that carries it.
#[derive(Clone, Debug)]
pub struct Link {
    /// Name in the URDF; for rigidly joined links, the name of the one closest to the base.
    pub name: String,
    /// The names of the links that are rigidly joined to that one.
    pub joined: Vec<String>,
    /// Mass, kg; 0 for a base without inertia.
    pub mass_kg: f64,
    /// Centre of mass, m, link frame.
    pub center_of_mass_link: DVec3,
    /// Inertia about the centre of mass, kg m², axes of the link frame.
    pub inertia_link: DMat3,
    /// Collision shapes.
    pub colliders: Vec<LinkCollider>,
}

/// One collision shape of a link.
#[derive(Clone, Debug)]
pub struct LinkCollider {
    /// Shape.
    pub shape: BodyShape,
    /// Pose of the shape's frame in the link frame.
    pub pose_link: Pose,
    /// The shape for distances, in the link frame. A hull takes some milliseconds to make.
    placed_link: PlacedShape,
}

impl LinkCollider {
    /// `None` for a hull without volume or with too many corners.
    fn new(shape: BodyShape, pose_link: Pose) -> Option<LinkCollider> {
        let (engine, rotation) = engine_shape(&shape)?;
        Some(LinkCollider { shape, pose_link, placed_link: PlacedShape { shape: engine, pose: pose_link * rotation } })
    }

    /// The shape for distances, with the link at this pose.
    pub fn placed(&self, link_pose: &Pose) -> PlacedShape {
        self.placed_link.on(link_pose)
    }
}

/// One compliant revolute joint: torque = K (φ − q) − D q̇ about its axis, with the equilibrium angle φ.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Joint {
    /// Name.
    pub name: String,
    /// Pose of the child link's frame in the parent link's frame at q = 0.
    pub origin_parent: Pose,
    /// Axis of rotation, unit vector, child link frame; q is right-handed about it.
    pub axis_child: DVec3,
    /// Mechanical limits of q, rad; infinite for a continuous joint.
    pub limits_rad: [f64; 2],
    /// Largest torque of the actuator, N m.
    pub torque_limit_nm: f64,
    /// Largest rate of the equilibrium angle, rad/s.
    pub slew_limit_rad_per_s: f64,
    /// Stiffness K of the simulated spring, N m/rad.
    pub stiffness_nm_per_rad: f64,
    /// Damping D, N m s/rad.
    pub damping_nm_s_per_rad: f64,
    /// Reflected inertia of the drive, kg m².
    pub armature_kg_m2: f64,
    /// Stiffness in the controller's model of the arm, N m/rad.
    pub model_stiffness_nm_per_rad: f64,
    /// Limits of q that the controller respects, rad.
    pub controller_limits_rad: [f64; 2],
    /// Angle at the start of a reach, rad.
    pub start_rad: f64,
}

/// A joint this close to a mechanical limit counts as held by its stop, rad: a tenth of a degree.
const AT_STOP_RAD: f64 = 2e-3;

impl Joint {
    /// Whether a mechanical stop may carry a part of the joint's torque at this angle. Stops are compliant, so the angle may
    /// be beyond the limit.
    pub fn is_at_stop(&self, angle_rad: f64) -> bool {
        let [lower, upper] = self.limits_rad;
        angle_rad < lower + AT_STOP_RAD || angle_rad > upper - AT_STOP_RAD
    }

    /// The nearest angle within the controller's limits.
    pub(crate) fn within_limits(&self, angle_rad: f64) -> f64 {
        let [low, high] = self.controller_limits_rad;
        angle_rad.max(low).min(high)
    }

    /// The angle at this share, from 0 to 1, of the part of the controller's range that is within half a turn from zero.
    pub(crate) fn at_share(&self, share: f64) -> f64 {
        let [low, high] = within_half_turn(self.controller_limits_rad);
        low + (high - low) * share
    }
}

/// The part of a joint's range, rad, that is within half a turn from zero: a joint without limits turns all round, and no
/// farther. A range that lies farther from zero is left as it is.
fn within_half_turn(range_rad: [f64; 2]) -> [f64; 2] {
    let [low, high] = range_rad.map(|limit| limit.clamp(-PI, PI));
    if low < high { [low, high] } else { range_rad }
}

impl Arm {
    /// Reads an arm from its TOML file and the files that it names, relative to itself.
    ///
    /// # Errors
    /// When a file cannot be read or parsed, has unknown keys, a value outside its limits, or a link or joint that the
    /// other files do not have, or when the URDF is not a serial chain of revolute joints with inertia.
    pub fn load(path: impl AsRef<Path>) -> Result<Arm, InputError> {
        file::assemble(path.as_ref(), &source::read_from_disk)
    }

    /// Assembles an arm from the texts of its files, in the order of [`Arm::files`]: the TOML file first.
    ///
    /// # Errors
    /// As [`Arm::load`].
    pub fn from_files(files: &[ArmSource]) -> Result<Arm, InputError> {
        let first = files.first().map_or("arm.toml", |file| file.name.as_str());
        let read = |path: &Path| {
            let file = files.iter().find(|file| Path::new(&file.name) == path);
            file.map(|file| file.text.clone()).ok_or_else(|| {
                let found = "no such file among the arm's files";
                let allowed = "the text of every file that the arm file names";
                InputError::new(path, "file", found, allowed, "give this file, too")
            })
        };
        file::assemble(Path::new(first), &read)
    }

    /// The right arm of the robot Cody, from the files that ship with this crate.
    ///
    /// # Errors
    /// Only when this crate's own files are broken.
    pub fn cody() -> Result<Arm, InputError> {
        let file = |name: &str, text: &str| ArmSource { name: name.to_owned(), text: text.to_owned() };
        Arm::from_files(&[
            file("cody.toml", include_str!("../../arms/cody/cody.toml")),
            file("cody.urdf", include_str!("../../arms/cody/cody.urdf")),
            file("cody.skin.toml", include_str!("../../arms/cody/cody.skin.toml")),
        ])
    }

    /// The angles at the start of a reach, rad.
    pub fn start_posture_rad(&self) -> Vec<f64> {
        self.joints.iter().map(|joint| joint.start_rad).collect()
    }

    /// Makes every joint `scale` times as stiff, in the simulation and in the controller's model, and keeps its damping
    /// ratio: D ∝ √K.
    pub(crate) fn scale_stiffness(&mut self, scale: f64) {
        for joint in &mut self.joints {
            joint.stiffness_nm_per_rad *= scale;
            joint.model_stiffness_nm_per_rad *= scale;
            joint.damping_nm_s_per_rad *= scale.sqrt();
        }
    }

    /// The surface of a link. A link that carries skin is covered with it all over; the others are hard.
    pub fn surface(&self, link: usize) -> Surface {
        if !self.skin.surfaces.iter().any(|patch| patch.link == link) {
            return Surface::hard(self.friction);
        }
        Surface {
            compliance_m3_per_n: 1.0 / self.skin.stiffness_n_per_m3,
            thickness_m: self.skin.thickness_m,
            loss_time_s: self.skin.loss_time_s,
            friction: self.friction,
        }
    }

    /// Index of the link called `name`.
    pub fn link_index(&self, name: &str) -> Option<usize> {
        self.links.iter().position(|link| link.name == name)
    }
}

/// The layout of a skin's taxels, from the TOML file of an arm or from a skin file alone.
///
/// If the file is an arm's, a patch is in the frame of the moving link that carries it, as in recordings of the arm. If
/// it is a skin file, a patch is in the frame of the link that the file names.
///
/// # Errors
/// As for [`Arm::load`]. A skin file alone is checked only in itself, not against an arm.
pub fn load_layout(path: &Path) -> Result<SkinLayout, InputError> {
    let source = source::Source { path: path.to_path_buf(), text: source::read_from_disk(path)? };
    match names_urdf(&source.text) {
        true => Ok(Arm::load(path)?.skin.layout),
        false => skin_file::read_layout(&source),
    }
}

/// Whether a file is an arm's TOML file: it names a URDF.
pub fn is_arm_file(path: &Path) -> bool {
    source::read_from_disk(path).is_ok_and(|text| names_urdf(&text))
}

fn names_urdf(text: &str) -> bool {
    text.parse::<toml::Table>().is_ok_and(|keys| keys.contains_key("urdf"))
}

/// The JSON Schema of an arm's TOML file.
pub fn schema() -> schemars::Schema {
    schemars::schema_for!(file::ArmFile)
}

/// The JSON Schema of a skin file.
pub fn skin_schema() -> schemars::Schema {
    schemars::schema_for!(skin_file::SkinFile)
}

#[cfg(test)]
pub(crate) mod tests;
