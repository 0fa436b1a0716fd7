//! The allowed range of every number in a scene file, with the reason for it. The ranges of an object's numbers are
//! beside the object, those of `[sensor]` in `sensor/limits.rs`.

use underbrush_recording::Limits;

/// Zero gravity to 30 m/s²: the Moon has 1.6, Jupiter 24.8. Gravity acts downwards, so it has no sign.
pub const GRAVITY_M_PER_S2: Limits = Limits::new(0.0, 30.0, "m/s²");

/// At most one frame. At 0.1 ms the forces have converged (it is the reference in `benches/time_step.rs`) and a reach
/// takes a hundred times as long as with one step per frame. Shorter steps only cost time: with 1 µs a reach takes
/// hours.
pub const STEP_S: Limits = Limits::new(1e-4, 0.01, "s");

/// Scale of the stiffness: from a tenth to ten times that in the arm's file. Beyond that it is another arm and needs a
/// file of its own.
pub const STIFFNESS_SCALE: Limits = Limits::new(0.1, 10.0, "");

/// Scale of the hand's speed: from so slow that a goal takes minutes to so fast that no real arm could follow.
pub const HAND_SPEED_SCALE: Limits = Limits::new(0.1, 10.0, "");

/// Scale of the allowed force: from a tenth, where the sensor's noise matters, to ten times, where the skin saturates.
pub const FORCE_LIMIT_SCALE: Limits = Limits::new(0.1, 10.0, "");

/// Allowed force: from a hundredth of a newton, the noise of the skin, to the force that stops the robot.
pub const ALLOWED_FORCE_N: Limits = Limits::new(0.01, 100.0, "N");

/// Goals of one reach: more than a thousand would take hours and must be a typing error.
pub const GOALS: Limits = Limits::new(1.0, 1000.0, "goals");

/// Repeated attempts at one goal.
pub const RETRIES: Limits = Limits::new(0.0, 100.0, "retries");

/// The operator's patience: from the blink of an eye to a quarter of an hour.
pub const PATIENCE_S: Limits = Limits::new(0.1, 1000.0, "s");

/// Objects in one group and in the whole scene: frames store an object's index in 16 bits, and far fewer fill the
/// table.
pub const OBJECTS: Limits = Limits::new(0.0, 10_000.0, "objects");

/// Angle between the upper and the lower edge of a picture: from a telescope to the widest lens that draws straight lines.
pub const FIELD_DEG: Limits = Limits::new(1.0, 150.0, "degrees");

/// Width and height of a picture: below 64 nothing can be told apart, and the renderer is made for pictures of up to 1280.
pub const PICTURE_PX: Limits = Limits::new(64.0, 1280.0, "pixels");
