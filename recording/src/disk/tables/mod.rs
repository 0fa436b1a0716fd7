//! The tables of a data set or a recording: their columns, and how a recording gives their rows and takes them.

pub(super) mod description;
pub(super) mod dictionary;
pub(super) mod episode;
pub(super) mod frames;
pub(super) mod shared_tables;
pub(super) mod truth_bodies;
pub(super) mod truth_columns;
pub(super) mod truth_tables;

use self::dictionary::{
    FRAMES, MAP, TAXELS, TRUTH_BODIES, TRUTH_CONTACT_POINTS, TRUTH_CONTACTS, TRUTH_GOALS, TRUTH_OBJECTS, TRUTH_PATCHES,
    TRUTH_POSES, TRUTH_TAXELS, Table,
};
use self::truth_bodies::body_rows;
use self::truth_tables::{
    contact_point_rows, contact_rows, goal_rows, map_rows, object_rows, patch_rows, pose_rows, taxel_rows,
};
use super::table::{Column, Row};
use crate::Recording;

/// Makes the columns of an episode for a table.
pub(super) type ColumnsOf = fn(usize, &Recording) -> Vec<Column>;

/// The tables with rows for every reach beside the frames: ground truth, and what the controller believed. Each stands
/// with the function that makes its columns for a reach.
pub(super) const FURTHER: [(&Table, ColumnsOf); 9] = [
    (&TRUTH_TAXELS, |episode, recording| Row::write(&taxel_rows(episode, recording))),
    (&TRUTH_PATCHES, |episode, recording| Row::write(&patch_rows(episode, recording))),
    (&TRUTH_OBJECTS, |episode, recording| Row::write(&object_rows(episode, recording))),
    (&TRUTH_CONTACTS, |episode, recording| Row::write(&contact_rows(episode, recording))),
    (&TRUTH_CONTACT_POINTS, |episode, recording| Row::write(&contact_point_rows(episode, recording))),
    (&TRUTH_GOALS, |episode, recording| Row::write(&goal_rows(episode, recording))),
    (&TRUTH_BODIES, |episode, recording| Row::write(&body_rows(episode, recording))),
    (&TRUTH_POSES, |episode, recording| Row::write(&pose_rows(episode, recording))),
    (&MAP, |episode, recording| Row::write(&map_rows(episode, recording))),
];

/// The tables with rows for every reach, first the frames.
pub(super) fn tables_of_reaches() -> impl Iterator<Item = &'static Table> {
    [&FRAMES].into_iter().chain(FURTHER.map(|(table, _)| table))
}

/// All tables that are described here. LeRobot's own tables in `meta/` are not among them.
pub(super) fn all_tables() -> impl Iterator<Item = &'static Table> {
    tables_of_reaches().chain([&TAXELS])
}
