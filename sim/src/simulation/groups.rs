//! The collision groups; every collider is in one of them.

use rapier3d::prelude::{Group, InteractionGroups, InteractionTestMode};

use crate::object::structure::CollisionGroup;

const ARM: Group = Group::GROUP_1;
const FIXED: Group = Group::GROUP_2;
const BENDABLE: Group = Group::GROUP_3;
pub const ROOTED: Group = Group::GROUP_4;
const TABLE: Group = Group::GROUP_5;

fn colliding(own: Group, others: Group) -> InteractionGroups {
    InteractionGroups::new(own, others, InteractionTestMode::And)
}

/// Links of the arm. Which of them meet each other is said by [`crate::arm::Arm::passing_links`].
pub fn arm() -> InteractionGroups {
    colliding(ARM, ARM | FIXED | BENDABLE | ROOTED)
}

/// Bodies of objects.
pub fn of_object(group: CollisionGroup) -> InteractionGroups {
    match group {
        // Trunks and foam blocks.
        CollisionGroup::Fixed => colliding(FIXED, ARM | BENDABLE),
        // Moving parts of leaves and rolls.
        CollisionGroup::Bendable => colliding(BENDABLE, ARM | FIXED | BENDABLE | ROOTED),
        // The lowest part of a leaf or roll. It stands inside foam, with which it must not collide.
        CollisionGroup::Rooted => colliding(ROOTED, ARM | BENDABLE),
        // Objects that stand free on the table: like moving parts, but they also collide with the table.
        CollisionGroup::Standing => colliding(BENDABLE, ARM | FIXED | BENDABLE | ROOTED | TABLE),
    }
}

/// The table. Other moving parts belong to the group that the table accepts, but they do not accept the table, so
/// the two do not collide.
pub fn table() -> InteractionGroups {
    colliding(TABLE, BENDABLE)
}
