use std::path::Path;
use std::sync::Barrier;
use std::time::Duration;
use std::{fs, thread};

use super::dataset::{contents, make, plan, recordings};
use crate::DiskError;
use crate::disk::{Dataset, DatasetPlan, DatasetWriter, Shard};

/// Joins the folder, with data files as small as those of [`make`].
fn share(dir: &Path, plan: DatasetPlan) -> Result<DatasetWriter, DiskError> {
    let mut writer = DatasetWriter::share(dir, plan)?;
    writer.staging.bytes_per_file = 60_000;
    Ok(writer)
}

/// Stages the missing reaches of a part.
fn stage(writer: &DatasetWriter, part: Shard) {
    for position in writer.missing_of(part).unwrap() {
        writer.stage(position, &recordings()[position]).unwrap();
    }
}

/// Runs one part as a process would, and returns whether it made the set.
fn run(dir: &Path, part: Shard) -> bool {
    loop {
        match share(dir, plan()) {
            Ok(writer) => {
                stage(&writer, part);
                return writer.finish_if_last().unwrap().is_some();
            }
            Err(DiskError::Finished { .. }) => return false,
            Err(DiskError::InUse { .. }) => thread::sleep(Duration::from_millis(1)),
            Err(error) => panic!("{error}"),
        }
    }
}

/// Tests that parts that run one after another, in any order and by different divisions, give the same bytes as one
/// process, that only the last part makes the set, and that every part may run again at any time.
#[test]
fn the_last_part_makes_the_set() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, shared] = ["whole", "shared"].map(|name| folder.path().join(name));
    make(&whole);
    // Of the five reaches, the runs have 2; 2 again; 0 and 3; 1 and 3; and 1 and 4, after which the set is complete.
    let runs = [(2, 3, false), (2, 3, false), (0, 3, false), (1, 2, false), (1, 3, true), (0, 2, false)];
    for (index, count, makes_the_set) in runs {
        assert_eq!(run(&shared, Shard { index, count }), makes_the_set, "{index} of {count}");
        match Dataset::open(&shared) {
            Ok(set) => set.verify().unwrap(),
            Err(error) => assert!(matches!(error, DiskError::Unfinished { .. }), "{error}"),
        }
    }
    assert_eq!(contents(&whole), contents(&shared));
}

/// Tests that parts that begin and end at the same moment, each run by two processes, give the same bytes as one
/// process, without leftovers, whichever is last. Locks belong to open files, so threads can stand for processes.
#[test]
fn parts_that_end_at_the_same_moment_make_one_set() {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("whole");
    make(&whole);
    let whole = contents(&whole);
    for round in 0..8 {
        let shared = folder.path().join(format!("shared-{round}"));
        let barrier = Barrier::new(10);
        thread::scope(|scope| {
            for index in (0..5).chain(0..5) {
                let (shared, barrier) = (&shared, &barrier);
                scope.spawn(move || {
                    barrier.wait();
                    run(shared, Shard { index, count: 5 })
                });
            }
        });
        assert_eq!(whole, contents(&shared), "round {round}");
        assert!(!shared.join("incomplete").exists(), "round {round}");
    }
}

/// Tests that if two processes begin different sets in one folder at the same moment, one of them is refused with the
/// field that differs, and the set of the other is not disturbed.
#[test]
fn one_folder_takes_one_plan() {
    let folder = tempfile::tempdir().unwrap();
    for round in 0..30 {
        let shared = folder.path().join(format!("shared-{round}"));
        let barrier = Barrier::new(2);
        let begun = thread::scope(|scope| {
            let begin = |seed| {
                let (shared, barrier) = (&shared, &barrier);
                scope.spawn(move || {
                    let mut plan = plan();
                    plan.provenance.seed = seed;
                    barrier.wait();
                    share(shared, plan)
                })
            };
            [begin(7), begin(8)].map(|thread| thread.join().unwrap())
        });
        let refused: Vec<&DiskError> = begun.iter().filter_map(|begun| begun.as_ref().err()).collect();
        let [DiskError::PlanDiffers { field, .. }] = refused.as_slice() else {
            panic!("round {round}: {refused:?}");
        };
        assert_eq!(field, "provenance.seed");
    }
}

/// Tests that processes that share a folder and a process that writes it alone exclude each other, and that a single
/// process may finish what the parts have left.
#[test]
fn alone_and_shared_exclude_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, shared] = ["whole", "shared"].map(|name| folder.path().join(name));
    make(&whole);
    let part = share(&shared, plan()).unwrap();
    stage(&part, Shard { index: 1, count: 2 });
    let alone = || DatasetWriter::create(&shared, plan(), true);
    assert!(matches!(alone(), Err(DiskError::InUse { .. })));
    assert!(part.finish_if_last().unwrap().is_none());
    let mut writer = alone().unwrap();
    assert!(matches!(share(&shared, plan()), Err(DiskError::InUse { .. })));
    writer.staging.bytes_per_file = 60_000;
    assert_eq!(writer.missing().unwrap(), [0, 2, 4]);
    stage(&writer, Shard { index: 0, count: 2 });
    writer.finish().unwrap();
    assert_eq!(contents(&whole), contents(&shared));
}

/// Tests that the next process, shared or alone, removes the lock file that a crash in the last step leaves, and that
/// the set counts as finished.
#[test]
fn what_the_last_step_leaves_is_removed() {
    let folder = tempfile::tempdir().unwrap();
    let set = folder.path().join("set");
    make(&set);
    let whole = contents(&set);
    let crash = || {
        fs::create_dir(set.join("incomplete")).unwrap();
        fs::write(set.join("incomplete/lock"), "").unwrap();
        Dataset::open(&set).unwrap().verify().unwrap();
    };
    crash();
    assert!(matches!(share(&set, plan()), Err(DiskError::Finished { .. })));
    assert_eq!(contents(&set), whole);
    crash();
    let alone = DatasetWriter::create(&set, plan(), true);
    assert!(matches!(alone, Err(DiskError::Finished { .. })));
    assert_eq!(contents(&set), whole);
    assert!(!set.join("incomplete").exists());
}
