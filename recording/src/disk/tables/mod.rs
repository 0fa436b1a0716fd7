//! The tables of a data set or a recording: their columns, and how a recording gives their rows and takes them.

pub(super) mod description;
pub(super) mod dictionary;
pub(super) mod episode;
pub(super) mod episode_table;
pub(super) mod frames;
pub(super) mod tasks;
pub(super) mod taxel_table;
pub(super) mod truth_bodies;
pub(super) mod truth_columns;
pub(super) mod truth_tables;
