//! The controller's map: the table `controller/map`.

use crate::disk::DiskError;
use crate::disk::table::row_groups::EpisodeRows;
use crate::disk::tables::dictionary::MapRow;
use crate::disk::tables::truth_tables::COUNTS;
use crate::{MappedObstacle, ObstacleKind, Recording};

/// The map of an episode.
pub(in crate::disk) fn map_rows(episode: usize, recording: &Recording) -> Vec<MapRow> {
    let row = |obstacle: &MappedObstacle| MapRow {
        episode_index: episode as i64,
        kind: obstacle.kind.name().into(),
        top_world: obstacle.top_world,
        radius_m: obstacle.radius_m,
        deviation_m: obstacle.deviation_m,
        first_frame: obstacle.first_frame.into(),
        last_frame: obstacle.last_frame.into(),
    };
    recording.map.iter().map(row).collect()
}

/// Reads the map of an episode.
pub(in crate::disk) fn read_map(rows: &EpisodeRows) -> Result<Vec<MappedObstacle>, DiskError> {
    rows.read(|batch, row: MapRow| {
        let kind = ObstacleKind::ALL.into_iter().find(|kind| kind.name() == &*row.kind);
        Ok(MappedObstacle {
            kind: kind.ok_or_else(|| batch.error("kind", &*row.kind, "yielding, doubtful or fixed"))?,
            top_world: row.top_world,
            radius_m: row.radius_m,
            deviation_m: row.deviation_m,
            first_frame: batch.index("first_frame", row.first_frame, COUNTS)?,
            last_frame: batch.index("last_frame", row.last_frame, COUNTS)?,
        })
    })
}
