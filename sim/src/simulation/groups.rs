//! The collision groups; every collider is in one of them.

use rapier3d::prelude::{Group, InteractionGroups, InteractionTestMode};

use crate::object::structure::CollisionGroup;

const ARM: Group = Group::GROUP_1;
const FIXED: Group = Group::GROUP_2;
const BENDABLE: Group = Group::GROUP_3;
pub const ROOTED: Group = Group::GROUP_4;
const TABLE: Group = Group::GROUP_5;
pub const FOAM: Group = Group::GROUP_6;

/// What bends.
const BENDING: Group = BENDABLE.union(ROOTED);

fn colliding(own: Group, others: Group) -> InteractionGroups {
    InteractionGroups::new(own, others, InteractionTestMode::And)
}

/// Links of the arm. Which of them meet each other is said by [`crate::arm::Arm::passing_links`].
pub fn arm() -> InteractionGroups {
    colliding(ARM, ARM | FIXED | FOAM | BENDING)
}

/// Bodies of objects.
pub fn of_object(group: CollisionGroup) -> InteractionGroups {
    match group {
        CollisionGroup::Fixed => colliding(FIXED, ARM | BENDING),
        CollisionGroup::Foam => colliding(FOAM, ARM | BENDING),
        CollisionGroup::Bendable => colliding(BENDABLE, ARM | FIXED | FOAM | BENDING),
        CollisionGroup::Rooted => colliding(ROOTED, ARM | FIXED | FOAM | BENDING),
        // Like moving parts, but they also collide with the table.
        CollisionGroup::Standing => colliding(BENDABLE, ARM | FIXED | FOAM | BENDING | TABLE),
    }
}

/// The table. Other moving parts belong to the group that the table accepts, but they do not accept the table, so
/// the two do not collide.
pub fn table() -> InteractionGroups {
    colliding(TABLE, BENDABLE)
}
