//! The commands end to end, with small inputs.

mod arm;
mod arrange;
mod benchmark;
mod check;
mod classifiers;
mod classify;
mod completions;
mod evaluate;
mod exchange;
mod experiment;
mod failures;
mod flips;
mod generate;
mod inspect;
mod kept;
mod live;
#[cfg(all(target_os = "linux", target_env = "gnu", target_arch = "x86_64"))]
mod machines;
mod materials;
mod merge;
mod models;
#[cfg(feature = "onnx")]
mod onnx;
mod oracle;
mod overwrite;
#[cfg(unix)]
mod paths;
mod provenance;
mod public_data;
mod reach;
mod replay;
mod resume;
mod schema;
#[cfg(unix)]
mod shared;
#[cfg(unix)]
mod signals;
#[cfg(target_os = "linux")]
mod streams;
mod thresholds;
mod torn;
pub mod touch;
mod train;
mod trials;
mod validate;
mod verdicts;
