use std::fs;
use std::path::Path;

use super::dataset::{contents, make};
use crate::InputError;
use crate::disk::{Dataset, DatasetCopy, DiskError};

/// Copies files of a set until `count` of them are there, and returns how many were missing before.
fn copy_some(set: &Dataset, to: &Path, count: usize) -> usize {
    let copy = DatasetCopy::begin(to, &set.file_bytes(DatasetCopy::LIST).unwrap()).unwrap();
    let missing = copy.missing().unwrap();
    for name in missing.iter().take(count) {
        copy.add(name, &set.file_bytes(name).unwrap(), Path::new("origin"))
            .unwrap();
    }
    missing.len()
}

fn refused<T: std::fmt::Debug>(result: Result<T, DiskError>) -> InputError {
    match result {
        Err(DiskError::Input(error)) => error,
        other => panic!("an InputError is expected, not {other:?}"),
    }
}

/// Pins that a copy that is interrupted after any file is not a data set, continues with the files that are missing or
/// damaged, and ends in the same bytes.
#[test]
fn a_copy_goes_on_where_it_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let set = make(&folder.path().join("set"));
    let (files, whole) = (set.files(), contents(set.dir()));
    assert_eq!(files.len(), whole.len());
    assert_eq!(
        [files.first(), files.last()].map(|name| name.unwrap().as_str()),
        ["meta/checksums.json", "meta/info.json"]
    );
    for count in 0..files.len() - 1 {
        let to = folder.path().join(format!("copy-{count}"));
        assert_eq!(copy_some(&set, &to, count), files.len() - 1);
        refused(Dataset::open(&to));
        // The last of the copied files is truncated.
        if let Some(torn) = count.checked_sub(1).map(|last| to.join(&files[last + 1])) {
            let bytes = fs::read(&torn).unwrap();
            fs::write(&torn, &bytes[..bytes.len() / 2]).unwrap();
        }
        assert_eq!(copy_some(&set, &to, usize::MAX), files.len() - count.max(1));
        assert_eq!(contents(&to), whole);
        assert_eq!(copy_some(&set, &to, 0), 0);
    }
}

/// Pins that changed bytes, files that are not listed, a damaged list, and lists with paths that lead out of the folder are
/// refused, and that nothing is written then.
#[test]
fn what_is_not_of_the_set_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let set = make(&folder.path().join("set"));
    let to = folder.path().join("to");
    let list = set.file_bytes(DatasetCopy::LIST).unwrap();
    let mut changed = list.clone();
    let place = changed.iter().position(|byte| *byte == b'7').unwrap();
    changed[place] = b'8';
    refused(DatasetCopy::begin(&to, &changed));
    refused(DatasetCopy::begin(&to, b"{}"));
    for path in [
        "../up",
        "data/../../up",
        "/up",
        "data//up",
        "up",
        "incomplete/plan.json",
        "data\\up",
        "data/.up",
    ] {
        let hash = blake3::hash(b"").to_hex();
        let line = blake3::hash(format!("{path} 0 {hash}\n").as_bytes()).to_hex();
        let files = serde_json::json!({ path: { "bytes": 0, "blake3": hash.as_str() } });
        let list = serde_json::json!({ "blake3": line.as_str(), "files": files }).to_string();
        let error = refused(DatasetCopy::begin(&to, list.as_bytes()));
        assert_eq!(error.found, path);
    }
    assert!(!to.exists());
    let copy = DatasetCopy::begin(&to, &list).unwrap();
    let mut bytes = set.file_bytes("meta/info.json").unwrap();
    bytes[10] ^= 1;
    let error = refused(copy.add("meta/info.json", &bytes, Path::new("s3://bucket/set/meta/info.json")));
    assert_eq!(error.file, Path::new("s3://bucket/set/meta/info.json"));
    refused(copy.add("meta/other.json", &bytes, Path::new("origin")));
    assert_eq!(contents(&to).len(), 1);
}

/// Pins that a copy does not write to a folder with another set, an unfinished set or other files.
#[test]
fn a_copy_needs_a_folder_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let set = make(&folder.path().join("set"));
    let list = set.file_bytes(DatasetCopy::LIST).unwrap();
    let begin = |name: &str| DatasetCopy::begin(folder.path().join(name), &list);
    let other = make(&folder.path().join("other"));
    // Another list, so that it is another set.
    fs::write(other.dir().join(DatasetCopy::LIST), "{}").unwrap();
    assert!(matches!(begin("other"), Err(DiskError::Finished { .. })));
    drop(super::dataset::begin(&folder.path().join("unfinished"), false));
    assert!(matches!(begin("unfinished"), Err(DiskError::Unfinished { .. })));
    fs::create_dir(folder.path().join("mine")).unwrap();
    fs::write(folder.path().join("mine/notes.txt"), "").unwrap();
    assert!(matches!(begin("mine"), Err(DiskError::FolderNotEmpty { .. })));
}
