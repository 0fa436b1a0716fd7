use std::fs;

use super::assemble_from;
use crate::disk::DatasetWriter;
use crate::disk::dataset::staging::packed::read_reach;
use crate::disk::tests::dataset::{begin, contents, copy, make, recordings};

/// Positions of the reaches that are still staged.
fn staged(writer: &DatasetWriter) -> Vec<usize> {
    let positions = 0..writer.staging.plan.episodes.len();
    positions.filter(|position| writer.staging.path(*position).exists()).collect()
}

/// Tests that a staged reach is removed as soon as it is in complete files, so that finishing does not take twice the
/// disk space of the set. Also tests that a finish can be killed at any reach, before or after removing staged files,
/// and that its complete files can be damaged before it is resumed: nothing is lost, and the bytes are the same.
#[test]
fn reaches_are_freed_file_by_file() {
    let folder = tempfile::tempdir().unwrap();
    let [unbroken, ready] = ["unbroken", "ready"].map(|name| folder.path().join(name));
    let files: Vec<usize> = make(&unbroken).episodes().iter().map(|episode| episode.file_index).collect();
    let whole = contents(&unbroken);
    let writer = begin(&ready, false);
    for (position, recording) in recordings().iter().enumerate() {
        writer.stage(position, recording).unwrap();
    }
    drop(writer);
    let mut freed_in_all = 0;
    for killed_at in 1..files.len() {
        for afterwards in ["nothing", "not yet freed", "damaged"] {
            let dir = folder.path().join(format!("{killed_at} {afterwards}"));
            copy(&ready, &dir);
            let writer = begin(&dir, true);
            // Assembling stops at a missing reach, as if it had been killed there.
            fs::remove_file(writer.staging.path(killed_at)).unwrap();
            let staging = &writer.staging;
            let read = |position| read_reach(&staging.path(position));
            assemble_from(staging, &mut |positions| positions.map(read).collect()).unwrap_err();
            let kept =
                (0..files.len()).filter(|position| *position > killed_at || files[*position] == files[killed_at - 1]);
            let kept: Vec<usize> = kept.filter(|position| *position != killed_at).collect();
            assert_eq!(staged(&writer), kept);
            let freed = files.len() - 1 - kept.len();
            freed_in_all += freed;
            match afterwards {
                "not yet freed" => copy(&ready, &dir),
                "damaged" if freed > 0 => {
                    let path = dir.join("data/chunk-000/file-000.parquet");
                    let mut bytes = fs::read(&path).unwrap();
                    bytes[100] ^= 1;
                    fs::write(path, bytes).unwrap();
                    let lost: Vec<usize> = (0..files.len()).filter(|position| !kept.contains(position)).collect();
                    assert_eq!(writer.missing().unwrap(), lost);
                }
                _ => assert_eq!(writer.missing().unwrap(), [killed_at]),
            }
            for position in writer.missing().unwrap() {
                writer.stage(position, &recordings()[position]).unwrap();
            }
            drop(writer);
            begin(&dir, true).finish().unwrap();
            assert!(contents(&dir) == whole, "killed at {killed_at}, {afterwards}");
        }
    }
    assert!(freed_in_all > 0, "no reach was freed early");
}

/// Tests that the bytes of a set do not depend on the number of threads that assemble it.
#[test]
fn any_number_of_threads_writes_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let [one, three] = [1, 3].map(|threads| {
        let dir = folder.path().join(threads.to_string());
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| make(&dir));
        contents(&dir)
    });
    assert!(one == three);
}
