//! Small scenes that run fast.

use std::path::{Path, PathBuf};

/// A few leaves with few segments, and one goal. A reach takes a fraction of a second.
pub const FEW_LEAVES: &str = r#"summary = "A few leaves and one goal"

[goals]
count = 1
retries = 0

[[objects.foam_block]]
count = 2
place = { x_m = { uniform = [0.40, 0.60] }, y_m = { uniform = [-0.40, -0.05] }, yaw_deg = { uniform = [-10, 10] } }

[[objects.leaf]]
count = 4
segments = 4
"#;

/// A few trunks and one goal.
pub const FEW_TRUNKS: &str = r#"summary = "A few trunks and one goal"

[goals]
count = 1
retries = 0

[[objects.trunk]]
count = 3
place = { x_m = { uniform = [0.40, 0.60] }, y_m = { uniform = [-0.40, -0.05] } }
"#;

/// Leaves beside the forearm and a goal behind them, so that they touch the forearm, whose skin is classified.
pub const LEAVES_AT_FOREARM: &str = r#"summary = "Leaves beside the forearm, a goal beyond"

[goals]
count = 1
retries = 0
x_m = { uniform = [0.60, 0.72] }

[[objects.foam_block]]
count = 4
place = { x_m = { uniform = [0.25, 0.48] }, y_m = { uniform = [-0.50, 0.05] }, yaw_deg = { uniform = [-10, 10] } }

[[objects.leaf]]
count = 12
segments = 4
"#;

/// Trunks beside the forearm and a goal behind them.
pub const TRUNKS_AT_FOREARM: &str = r#"summary = "Trunks beside the forearm, a goal beyond"

[goals]
count = 1
retries = 0
x_m = { uniform = [0.60, 0.72] }

[[objects.trunk]]
count = 6
place = { x_m = { uniform = [0.25, 0.50] }, y_m = { uniform = [-0.50, -0.15] } }
"#;

/// Writes a scene file called `name`.
pub fn write(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}
