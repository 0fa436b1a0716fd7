use std::path::{Path, PathBuf};

use super::dataset::{contents, plan, scene_text};
use super::{Change, reach};
use crate::disk::{Dataset, DatasetPlan, DatasetWriter, PlannedEpisode, Shard, Shards};
use crate::{DiskError, InputError, Recording};

/// Reaches of the campaign: four of one scene, seven of another.
const SCENES: [(&str, u64); 2] = [("foliage", 4), ("trunks", 7)];

/// The reaches of the campaign, of different lengths.
fn campaign() -> Vec<Recording> {
    let reaches = SCENES.into_iter().flat_map(|(scene, count)| {
        (0..count).map(move |index| Recording { scene: scene.into(), ..reach(index, 10 + 7 * index as usize) })
    });
    reaches.collect()
}

/// The plan of the campaign or of a part of it.
fn plan_of(shard: Option<Shard>) -> DatasetPlan {
    let mut plan = plan();
    plan.provenance.shard = shard;
    plan.provenance.scenes =
        SCENES.map(|(name, reaches)| crate::disk::SceneText { reaches, ..scene_text(name, "[leaf]\n") }).into();
    let of_this_part = |position: &usize| shard.is_none_or(|shard| shard.holds(*position as u64));
    let reaches = campaign();
    plan.episodes = (0..reaches.len())
        .filter(of_this_part)
        .map(|position| PlannedEpisode {
            scene: reaches[position].scene.clone(),
            task: format!("reach the goal through {}", reaches[position].scene),
            reach_index: reaches[position].reach_index,
        })
        .collect();
    plan
}

/// Begins or resumes a set with data files so small that there are several.
fn begin(dir: &Path, plan: &DatasetPlan, resume: bool) -> Result<DatasetWriter, DiskError> {
    let mut writer = DatasetWriter::create(dir, plan.clone(), resume)?;
    writer.staging.bytes_per_file = 6_000;
    Ok(writer)
}

/// Makes the set of a plan.
fn make(dir: &Path, plan: DatasetPlan) -> Dataset {
    let writer = begin(dir, &plan, false).unwrap();
    for (position, episode) in writer.staging.plan.episodes.clone().iter().enumerate() {
        let same = |reach: &Recording| reach.scene == episode.scene && reach.reach_index == episode.reach_index;
        let recording = campaign().into_iter().find(same).unwrap();
        writer.stage(position, &recording).unwrap();
    }
    writer.finish().unwrap()
}

/// Makes all parts of the campaign, and returns their folders.
fn make_parts(root: &Path, count: u64) -> Vec<PathBuf> {
    let part = |index| {
        let dir = root.join(format!("part-{}-of-{count}", index + 1));
        make(&dir, plan_of(Some(Shard { index, count })));
        dir
    };
    (0..count).map(part).collect()
}

fn refused(parts: &[&PathBuf]) -> InputError {
    let parts: Vec<PathBuf> = parts.iter().copied().cloned().collect();
    match Shards::open(&parts) {
        Err(DiskError::Input(error)) => error,
        other => panic!("an InputError is expected, not {other:?}"),
    }
}

/// Tests that one, three or eleven parts, named in any order, merge into the bytes of the undivided set, and that a
/// merge that is killed at any reach can be resumed and ends in the same bytes.
#[test]
fn parts_merge_into_the_undivided_set() {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("whole");
    let files = make(&whole, plan_of(None)).episodes().last().unwrap().file_index;
    assert!(files > 2, "the last reach is in file {files}");
    let whole = contents(&whole);
    for count in [1, 3, 11] {
        let mut parts = make_parts(folder.path(), count);
        parts.reverse();
        let merged = folder.path().join(format!("merged-{count}"));
        let mut reaches = 0;
        let shards = Shards::open(&parts).unwrap();
        let writer = begin(&merged, &shards.plan, false).unwrap();
        let set = shards.merge_with(writer, || reaches += 1);
        set.unwrap().verify().unwrap();
        assert_eq!(reaches, 11);
        assert!(contents(&merged) == whole, "{count} parts");
    }
    let parts = make_parts(&folder.path().join("again"), 3);
    for killed_at in [0, 4, 7, 10] {
        let merged = folder.path().join(format!("killed-{killed_at}"));
        let shards = Shards::open(&parts).unwrap();
        let writer = begin(&merged, &shards.plan, false).unwrap();
        let reaches = campaign();
        let killed = writer.finish_from(|position| match position {
            position if position == killed_at => Err(DiskError::Finished(merged.clone())),
            position => Ok(reaches[position].clone()),
        });
        assert!(matches!(killed, Err(DiskError::Finished { .. })));
        let fresh = shards.merge(&merged, false, || ());
        assert!(matches!(fresh, Err(DiskError::Unfinished { .. })), "{fresh:?}");
        let writer = begin(&merged, &shards.plan, true).unwrap();
        shards.merge_with(writer, || ()).unwrap();
        assert!(contents(&merged) == whole, "killed at {killed_at}");
    }
}

/// Tests that parts of another campaign, missing and duplicate parts and whole sets are refused, and that the error
/// names the folder, what it holds and what is missing.
#[test]
fn what_is_not_every_part_once_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let parts = make_parts(folder.path(), 3);
    let whole = folder.path().join("whole");
    make(&whole, plan_of(None));

    let error = refused(&[&parts[0], &whole, &parts[1]]);
    assert_eq!((&error.file, error.field.as_str()), (&whole, "shard"));
    assert!(error.found.contains("whole campaign"), "{error}");

    let error = refused(&[&parts[2], &parts[0]]);
    assert_eq!(error.found, "2 of 3 parts, without 2/3");
    let error = refused(&[&parts[1]]);
    assert_eq!(error.found, "1 of 3 parts, without 1/3, 3/3");

    let copy = folder.path().join("copy");
    make(&copy, plan_of(Some(Shard { index: 1, count: 3 })));
    let error = refused(&[&parts[0], &parts[1], &copy, &parts[2]]);
    assert_eq!(error.file, copy);
    assert_eq!(error.found, format!("2/3, which {} holds, too", parts[1].display()));

    let of_four = folder.path().join("of four");
    make(&of_four, plan_of(Some(Shard { index: 3, count: 4 })));
    let error = refused(&[&parts[0], &of_four, &parts[1], &parts[2]]);
    assert_eq!((error.file, error.found.as_str()), (of_four, "4/4"));
    assert!(error.allowed.contains("a part of 3, as in"), "{}", error.allowed);

    let nothing = Shards::open(&[]);
    assert!(matches!(nothing, Err(DiskError::Input(error)) if error.found == "none"));
}

/// Tests that a part with other arithmetic, another version, scene or number of reaches is refused by the field that
/// differs, and that a part whose reaches are not those that belong to it is refused, too.
#[test]
fn parts_of_other_campaigns_are_refused_by_the_field() {
    let changes: [Change<DatasetPlan>; 5] = [
        ("provenance.arithmetic", |plan| {
            plan.provenance.arithmetic = "another".into();
        }),
        ("provenance.program_version", |plan| {
            plan.provenance.program_version = "0.2.0".into();
        }),
        ("provenance.scenes[\"trunks\"].file.blake3", |plan| {
            plan.provenance.scenes[1].file = scene_text("trunks", "[trunk] # changed\n").file;
        }),
        ("provenance.scenes[\"foliage\"].reaches", |plan| {
            plan.provenance.scenes[0].reaches = 5;
        }),
        ("episodes", |plan| plan.episodes.truncate(1)),
    ];
    let folder = tempfile::tempdir().unwrap();
    let parts = make_parts(folder.path(), 3);
    for (place, (field, change)) in changes.into_iter().enumerate() {
        let mut other = plan_of(Some(Shard { index: 1, count: 3 }));
        change(&mut other);
        let dir = folder.path().join(format!("other-{place}"));
        make(&dir, other);
        let error = refused(&[&parts[0], &dir, &parts[2]]);
        assert_eq!((&error.file, error.field.as_str()), (&dir, field), "{error}");
    }
}

/// Tests that a damaged table of a part is named when it is read, and that the merge can be resumed once the part has
/// been repaired.
#[test]
fn a_damaged_part_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let parts = make_parts(folder.path(), 3);
    let table = parts[1].join("truth/taxels/chunk-000/file-000.parquet");
    let bytes = std::fs::read(&table).unwrap();
    let mut damaged = bytes.clone();
    damaged[bytes.len() / 2] ^= 1;
    std::fs::write(&table, damaged).unwrap();
    let merged = folder.path().join("merged");
    match Shards::open(&parts).unwrap().merge(&merged, false, || ()) {
        Err(DiskError::Input(error)) => assert_eq!((error.file, error.field.as_str()), (table.clone(), "checksum")),
        other => panic!("{other:?}"),
    }
    std::fs::write(&table, bytes).unwrap();
    let set = Shards::open(&parts).unwrap().merge(&merged, true, || ()).unwrap();
    assert_eq!(set.episodes().len(), 11);
}
