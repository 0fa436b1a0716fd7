//! A data set: many reaches in one folder, in the LeRobotDataset v3.0 layout (plain Parquet and JSON).
//!
//! ```text
//! README.md                                     the card: how to load the set; columns, units and codes
//! data/chunk-000/file-000.parquet …             the frames, one row group per episode: what a robot could know
//! truth/TABLE/chunk-000/file-000.parquet …      ground truth: taxels patches objects contacts goals bodies poses
//! controller/map/chunk-000/file-000.parquet …   what the controller believed
//! meta/info.json                                features and totals; written last, so a set without it is unfinished
//! meta/episodes/chunk-000/file-000.parquet      one row per episode: place of its frames, outcome, audit
//! meta/tasks.parquet  meta/stats.json           LeRobot's task sentences and statistics
//! meta/taxels.parquet                           the positions of the taxels
//! meta/provenance.json  meta/checksums.json     origin, with the text of scenes and arms; BLAKE3 of every file
//! incomplete/                                   only while the set is unfinished: plan.json, assembled.bin,
//!                                               finished reaches
//! ```

mod checksums;
mod columns;
mod info;
mod names;
mod plan;
mod reader;
mod staging;

pub use checksums::file_blake3;
pub use plan::{ArmText, DatasetPlan, FileText, PlannedEpisode, Provenance, SceneText, Shard};
pub use reader::Dataset;
pub use staging::folder::make_room;
pub use staging::parts::Shards;
#[cfg(test)]
pub(super) use staging::table_files::ROWS_PER_GROUP;
pub use staging::writer::DatasetWriter;
