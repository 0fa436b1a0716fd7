//! The allowed range of every number in an arm's three files, with the reason for it.

use underbrush_recording::Limits;
pub(crate) use underbrush_recording::limits::SHARE;

/// Coefficient of friction: rubber on a rough surface reaches 1 to 1.5.
pub(crate) const FRICTION: Limits = Limits::new(0.0, 2.0, "");

/// Stiffness of a joint: from a finger's tendon to a drive with stiff position control.
pub(super) const STIFFNESS_NM_PER_RAD: Limits = Limits::new(1e-3, 1e5, "N m/rad");

/// Damping of a joint: the critical damping of the stiffest joint with 10 kg m² attached is 2 √(K I) = 2000.
pub(super) const DAMPING_NM_S_PER_RAD: Limits = Limits::new(0.0, 1e4, "N m s/rad");

/// Reflected inertia of a drive: large industrial joints have a few tens of kg m².
pub(super) const ARMATURE_KG_M2: Limits = Limits::new(0.0, 100.0, "kg m²");

/// Angles of joints and of frames: ten full revolutions in either direction.
pub(super) const ANGLE_RAD: Limits = Limits::new(-62.84, 62.84, "rad");

/// As [`ANGLE_RAD`], in degrees.
pub(super) const ANGLE_DEG: Limits = Limits::new(-3600.0, 3600.0, "deg");

/// Torque of a joint's drive: from a finger's to that of an excavator.
pub(super) const TORQUE_NM: Limits = Limits::new(1e-3, 1e5, "N m");

/// Speed of a joint: from one revolution in two hours to a fast servo's thousand revolutions per minute.
pub(super) const SPEED_RAD_PER_S: Limits = Limits::new(1e-3, 100.0, "rad/s");

/// Mass of a link: from a tenth of a gram (the cap of a fingertip) to ten tonnes.
pub(super) const MASS_KG: Limits = Limits::new(1e-4, 1e4, "kg").or_off_at(0.0);

/// Principal moments of inertia: from 0.1 g at a millimetre to ten tonnes at ten metres.
pub(super) const INERTIA_KG_M2: Limits = Limits::new(1e-10, 1e6, "kg m²");

/// An entry of an inertia matrix, whose principal moments must be within [`INERTIA_KG_M2`].
pub(super) const INERTIA_ENTRY_KG_M2: Limits = Limits::new(-INERTIA_KG_M2.max, INERTIA_KG_M2.max, "kg m²");

/// Loss time of a skin: from none to that of a very slow foam.
pub(crate) const LOSS_TIME_S: Limits = Limits::new(0.0, 1.0, "s");

/// Coordinates on an arm: the longest arms reach 3 to 4 m.
pub(super) const PLACE_M: Limits = Limits::new(-5.0, 5.0, "m");

/// Sizes of collision shapes: less than 0.1 mm is no shape, and 10 m is twice [`PLACE_M`].
pub(super) const SIZE_M: Limits = Limits::new(1e-4, 10.0, "m");

/// Volume of a convex hull: at least that of a cube of 1 mm. Flatter hulls give contacts no direction.
pub(super) const HULL_VOLUME_M3: Limits = Limits::new(1e-9, 1000.0, "m³");

/// Length of a direction vector, which need not be a unit vector.
pub(super) const DIRECTION: Limits = Limits::new(1e-3, 1e3, "");

/// A component of a vector whose length lies within [`DIRECTION`].
pub(super) const DIRECTION_ENTRY: Limits = Limits::new(-DIRECTION.max, DIRECTION.max, "");

/// Stiffness of the skin per volume, modulus over thickness: from 5 cm of the softest foam (5 kPa) to 0.1 mm of steel
/// (200 GPa).
pub(crate) const SKIN_N_PER_M3: Limits = Limits::new(1e5, 2e15, "N/m³");

/// Thickness of the soft layer: from a coat of paint to a cushion.
pub(crate) const LAYER_M: Limits = Limits::new(1e-4, 0.1, "m");

/// Radius of a sleeve of skin: from a wire's to a barrel's.
pub(super) const RADIUS_M: Limits = Limits::new(1e-3, 1.0, "m");

/// Side of a taxel, and pitch of rows: from 0.1 mm in the finest sensors to 0.5 m in a mat.
pub(super) const TAXEL_SIZE_M: Limits = Limits::new(1e-4, 0.5, "m");

/// Area of a taxel: the square of [`TAXEL_SIZE_M`].
pub(super) const TAXEL_AREA_M2: Limits = Limits::new(1e-8, 0.25, "m²");

/// Nesting depth of a URDF's elements: five are needed, and some XML readers recurse for each level.
pub(super) const MAX_NESTED_ELEMENTS: usize = 50;

/// Elements of a URDF: a humanoid has a few thousand.
pub(super) const MAX_ELEMENTS: usize = 100_000;

/// Moving joints of a chain: the engine's cost grows with their square, the controller's with their cube.
pub(super) const MAX_JOINTS: usize = 64;
