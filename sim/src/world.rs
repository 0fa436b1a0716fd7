//! w
/// Period of the skin and of frames, s (100 Hz).
pub const FRAME_PERIOD_S: f64 = 0.01;
