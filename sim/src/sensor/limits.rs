//! The allowed range of every number in `[sensor]`, with the reason for it.

use underbrush_recording::Limits;
pub use underbrush_recording::limits::SHARE;

/// Noise of a taxel: 1 µN is a thousandth of the driver's step, and noise of 1 N hides every contact.
pub const NOISE_N: Limits = Limits::new(1e-6, 1.0, "N").or_off_at(0.0);

/// A gate of a hundred standard deviations suppresses far more than noise.
pub const GATE_SIGMAS: Limits = Limits::new(0.0, 100.0, "");

/// Quantization step: from a thousandth of the driver's to a sensor that only detects contact.
pub const QUANTUM_N: Limits = Limits::new(1e-6, 10.0, "N").or_off_at(0.0);

/// Saturation: a taxel that saturates below 0.1 N cannot feel a leaf, and 10 kN destroys any skin.
pub const SATURATION_N: Limits = Limits::new(0.1, 1e4, "N").or_off_at(f64::INFINITY);

/// Floor of the readings; it must also be below the saturation.
pub const FLOOR_N: Limits = Limits::new(1e-6, 1e3, "N").or_off_at(0.0);

/// Spread of gains: at 1 half of all taxels read twice as much or half as much as they should.
pub const GAIN_SPREAD: Limits = Limits::new(0.0, 1.0, "");

/// Time of the drift: from a frame to some hours.
pub const DRIFT_TIME_S: Limits = Limits::new(0.01, 1e4, "s");

/// Bandwidth: below 0.01 Hz a taxel would need half a minute to feel a touch; above 10 kHz a frame does not see it.
pub const BANDWIDTH_HZ: Limits = Limits::new(0.01, 1e4, "Hz").or_off_at(f64::INFINITY);

/// Creep per decade: rubber has 0.02 to 0.1; at 1 a reading grows fivefold over the four decades.
pub const CREEP_SHARE: Limits = Limits::new(0.0, 1.0, "");

/// Share of taxels with a spurious reading: above one half they would be the rule.
pub const SPURIOUS_SHARE: Limits = Limits::new(0.0, 0.5, "");

/// Duration of a spurious reading: from one frame to a few hours.
pub const SPURIOUS_TIME_S: Limits = Limits::new(0.01, 1e4, "s");

/// A spurious reading: from a tenth of the driver's step to more than the robot's taxels can measure.
pub const SPURIOUS_FORCE_N: Limits = Limits::new(1e-4, 100.0, "N");

/// Frames of delay: two seconds is slower than any skin that is used to control an arm.
pub const DELAY_FRAMES: Limits = Limits::new(0.0, 200.0, "frames");

/// Counts per newton: from one count per 10 N to a 24-bit converter over 17 N.
pub const COUNTS_PER_N: Limits = Limits::new(0.1, 1e6, "counts/N").or_off_at(0.0);

/// Hysteresis: at 0.95 the force must fall to a twentieth before the reading starts to fall.
pub const HYSTERESIS_SHARE: Limits = Limits::new(0.0, 0.95, "");
