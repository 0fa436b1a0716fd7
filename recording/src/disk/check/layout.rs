//! Rules for the robot: its skin, the rate of its frames and its joints.

use super::violation::{Violation, finite, require};
use crate::SkinLayout;

/// Checks a skin layout: unique patch names that can be part of column names, taxels in every patch, and grids that
/// fit.
pub(crate) fn check_layout(layout: &SkinLayout) -> Result<(), Violation> {
    for (index, patch) in layout.patches.iter().enumerate() {
        let field = |name: &str| format!("layout.patches[{index}].{name}");
        // LeRobot reads a "/" in a feature name as part of a path.
        let named = !patch.name.is_empty() && !patch.name.contains('/');
        require(named, || field("name"), || format!("{:?}", patch.name), "a name without \"/\"")?;
        let unique = layout.patch_index(&patch.name) == Some(index);
        require(unique, || field("name"), || format!("{:?} twice", patch.name), "unique names")?;
        let count = patch.taxels.len();
        require((1..=65536).contains(&count), || field("taxels"), || format!("{count} taxels"), "1 to 65536 taxels")?;
        if let Some(grid) = patch.grid {
            let fits = grid.rows.checked_mul(grid.columns) == Some(count);
            let found = || format!("{} × {} for {count} taxels", grid.rows, grid.columns);
            require(fits, || field("grid"), found, "rows × columns = taxels")?;
        }
        let numbers = patch.taxels.iter().flat_map(|taxel| {
            let vectors = [taxel.position_link, taxel.normal_link, taxel.tangent_link];
            vectors.into_iter().flat_map(|vector| vector.to_array()).chain([taxel.area_m2])
        });
        finite(numbers, || field("taxels"))?;
    }
    Ok(())
}

/// Checks what recordings and data sets say about the robot: skin, frame rate and joints.
pub(crate) fn check_robot(layout: &SkinLayout, rate_hz: f64, joint_names: &[String]) -> Result<(), Violation> {
    check_layout(layout)?;
    require(rate_hz.is_finite() && rate_hz > 0.0, || "rate_hz".into(), || rate_hz.to_string(), "a number above 0")?;
    require(!joint_names.is_empty(), || "joint_names".into(), || "none".into(), "at least one joint")
}
