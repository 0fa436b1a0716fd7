//! The range of every number in a scene file, with its reason. Those of objects stand beside each object, those of
//! `[sensor]` in `sensor/limits.rs`.

use underbrush_recording::Limits;

/// Weightless to 30 m/s²: the Moon has 1.6, Jupiter 24.8. It acts downwards, so it has no sign.
pub const GRAVITY_M_PER_S2: Limits = Limits::new(0.0, 30.0, "m/s²");

/// At most a frame. At 0.1 ms forces have converged (it is the reference of `benches/time_step.rs`), and a reach takes a
/// hundred times as long as at a frame; shorter steps only cost time, 1 µs some hours a reach.
pub const STEP_S: Limits = Limits::new(1e-4, 0.01, "s");

/// At most 64 substeps, and none shorter than [`SHORTEST_SUBSTEP_S`].
pub const SUBSTEPS: Limits = Limits::new(1.0, 64.0, "substeps");

/// A tenth of the shortest step, for the same reason, s.
pub const SHORTEST_SUBSTEP_S: f64 = 1e-5;

/// Factor on stiffness: a tenth and ten times that of the arm's file. Farther off it is another arm, with a file of its own.
pub const STIFFNESS_SCALE: Limits = Limits::new(0.1, 10.0, "");

/// Factor on the hand's speed: so slow that a goal takes minutes, so fast that no real arm follows.
pub const HAND_SPEED_SCALE: Limits = Limits::new(0.1, 10.0, "");

/// Goals of one reach: more than a thousand take hours and are a slip of the keyboard.
pub const GOALS: Limits = Limits::new(1.0, 1000.0, "goals");

/// Tries at a goal that is out of reach.
pub const RETRIES: Limits = Limits::new(0.0, 100.0, "retries");

/// Patience of the operator: from the blink of an eye to a quarter of an hour.
pub const PATIENCE_S: Limits = Limits::new(0.1, 1000.0, "s");

/// Objects of one group, and of the whole scene: frames hold an object's index in 16 bits, and far fewer fill the table.
pub const OBJECTS: Limits = Limits::new(0.0, 10_000.0, "objects");
