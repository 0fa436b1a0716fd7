//! Files that appear only when they are complete, and leftovers of killed processes.

use std::fs::{self, File};
use std::path::Path;

use super::reach;
use crate::DiskError;
use crate::disk::{write_file, write_recording, write_trials};

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().to_str().unwrap().to_owned()).collect();
    names.sort();
    names
}

/// A temporary file for `output` as a killed process leaves it, without a lock.
fn leftover(folder: &Path, output: &str, end: &str) -> String {
    let hash = blake3::hash(output.as_bytes()).to_hex();
    let name = format!(".underbrush-unfinished-{}-{end}", &hash[..16]);
    fs::write(folder.join(&name), "half of it").unwrap();
    name
}

/// Tests that writing a file removes what killed processes have left of it and nothing else: no leftovers of other
/// files, no files that a living process is writing, no files of other programs.
#[test]
fn leftovers_of_an_output_go_with_its_next_run() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    leftover(folder, "trials.csv", "abandoned");
    leftover(folder, "trials.csv", "too");
    let others = leftover(folder, "other.csv", "abandoned");
    let living = leftover(folder, "trials.csv", "living");
    fs::write(folder.join(".hidden"), "of another program").unwrap();
    let writer = File::open(folder.join(&living)).unwrap();
    writer.lock().unwrap();

    write_trials(folder.join("trials.csv"), &[]).unwrap();
    let mut expected = vec![".hidden".to_owned(), others.clone(), living, "trials.csv".to_owned()];
    expected.sort();
    assert_eq!(names(folder), expected);

    // A process that another test starts has a copy of the file until it runs its program, so dropping this one may not unlock it.
    writer.unlock().unwrap();
    write_file(&folder.join("trials.csv"), b"anew").unwrap();
    assert_eq!(names(folder), [".hidden", &others, "trials.csv"]);
    assert_eq!(fs::read(folder.join("trials.csv")).unwrap(), b"anew");
    leftover(folder, "reach.parquet", "abandoned");
    write_recording(&folder.join("reach.parquet"), &reach(0, 5)).unwrap();
    assert_eq!(names(folder), [".hidden", &others, "reach.parquet", "trials.csv"]);
}

/// Tests that a folder or a device is refused and not replaced.
#[test]
fn only_files_are_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let inner = folder.path().join("model.json");
    fs::create_dir(&inner).unwrap();
    assert!(matches!(write_file(&inner, b"{}"), Err(DiskError::Io { path, .. }) if path == inner));
    assert_eq!(names(folder.path()), ["model.json"]);
    if cfg!(unix) {
        assert!(write_file(Path::new("/dev/null"), b"{}").is_err());
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}

/// Tests that a file that is written anew keeps its permissions, and that a link to it stays a link, also to a recording and a table.
#[cfg(unix)]
#[test]
fn links_and_permissions_are_kept() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let [file, link] = ["suite.toml", "link.toml"].map(|name| folder.path().join(name));
    fs::write(&file, "old").unwrap();
    fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
    symlink("suite.toml", &link).unwrap();
    write_file(&link, b"new").unwrap();
    assert_eq!(fs::read_link(&link).unwrap(), Path::new("suite.toml"));
    assert_eq!(fs::read(&file).unwrap(), b"new");
    assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
    for (name, write) in [
        ("reach.parquet", (|path: &Path| write_recording(path, &reach(0, 5)).unwrap()) as fn(&Path)),
        ("trials.csv", |path: &Path| write_trials(path, &[]).unwrap()),
    ] {
        let [file, link] = [name.to_owned(), format!("link-{name}")].map(|name| folder.path().join(name));
        fs::write(&file, "old").unwrap();
        symlink(name, &link).unwrap();
        write(&link);
        assert!(link.is_symlink() && fs::read(&file).unwrap() != b"old", "{name}");
    }
}

/// Tests that names as long as the file system allows, and names that are not UTF-8, can be written.
#[cfg(unix)]
#[test]
fn any_name_can_be_written() {
    use std::os::unix::ffi::OsStrExt;
    let folder = tempfile::tempdir().unwrap();
    for name in [&b"\xff\xfe.json"[..], &[b'x'; 255][..]] {
        let path = folder.path().join(std::ffi::OsStr::from_bytes(name));
        write_file(&path, b"whole").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"whole");
    }
}
