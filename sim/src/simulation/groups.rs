//! The collision groups; every collider is in one of them.

use rapier3d::prelude::{Group, InteractionGroups, InteractionTestMode};

const ARM: Group = Group::GROUP_1;
const FIXED: Group = Group::GROUP_2;
const BENDABLE: Group = Group::GROUP_3;
pub const ROOTED: Group = Group::GROUP_4;
const TABLE: Group = Group::GROUP_5;

/// Links of the arm: they collide with everything but each other.
pub fn arm() -> InteractionGroups {
    InteractionGroups::new(ARM, FIXED | BENDABLE | ROOTED, InteractionTestMode::And)
}

/// Trunks and foam blocks.
pub fn fixed() -> InteractionGroups {
    InteractionGroups::new(FIXED, ARM | BENDABLE, InteractionTestMode::And)
}

/// Moving parts of leaves and rolls.
pub fn bendable() -> InteractionGroups {
    InteractionGroups::new(BENDABLE, ARM | FIXED | BENDABLE | ROOTED, InteractionTestMode::And)
}

/// The lowest part of a leaf or roll. It stands inside foam, with which it must not collide.
pub fn rooted() -> InteractionGroups {
    InteractionGroups::new(ROOTED, ARM | BENDABLE, InteractionTestMode::And)
}

/// Objects that stand free on the table: like moving parts, but they also collide with the table.
pub fn standing() -> InteractionGroups {
    let others = ARM | FIXED | BENDABLE | ROOTED | TABLE;
    InteractionGroups::new(BENDABLE, others, InteractionTestMode::And)
}

/// The table. Other moving parts belong to the group that the table accepts, but they do not accept the table, so
/// the two do not collide.
pub fn table() -> InteractionGroups {
    InteractionGroups::new(TABLE, BENDABLE, InteractionTestMode::And)
}
