//! Shared by the tests: calling the program, small scenes, and a small data set.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

pub mod arm;
pub mod fixture;
pub mod json_schema;
pub mod scenes;
pub mod table;

/// The result of a call of the program.
#[derive(Debug)]
pub struct Answer {
    /// Exit status; −1 if a signal ended the program.
    pub status: i32,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
}

impl Answer {
    /// The standard output of a call that must succeed.
    #[track_caller]
    pub fn success(self) -> String {
        assert_eq!(self.status, 0, "{}", self.stderr);
        self.stdout
    }

    /// The result of a call with `--json` that must succeed.
    #[track_caller]
    pub fn json(self) -> serde_json::Value {
        serde_json::from_str(&self.success()).unwrap()
    }

    /// Demands exit status 2, no result on stdout, no panic, and an error message that contains all `parts`.
    #[track_caller]
    pub fn refused(&self, parts: &[&str]) {
        let Answer { status, stdout, stderr } = self;
        assert_eq!(*status, 2, "{stdout}\n{stderr}");
        // `--json` prints the error there.
        let no_result = stdout.is_empty() || stdout.starts_with("{\"error\":");
        assert!(no_result, "results beside an error: {stdout}");
        assert!(!stderr.contains("panicked at"), "{stderr}");
        for part in parts {
            assert!(stderr.contains(part), "no {part:?} in:\n{stderr}");
        }
    }
}

/// No call takes half a minute. The limit makes a test fail if the program hangs.
const TIME_LIMIT: Duration = Duration::from_secs(300);

/// Calls the program; `stdin` is its standard input.
pub fn call(arguments: Vec<OsString>, stdin: &str) -> Answer {
    call_with_bytes(arguments, stdin.as_bytes())
}

/// As [`call`], with a standard input that may be no text.
pub fn call_with_bytes(arguments: Vec<OsString>, stdin: &[u8]) -> Answer {
    let mut program = Command::new(env!("CARGO_BIN_EXE_underbrush"))
        .args(&arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let (mut input, stdin) = (program.stdin.take().unwrap(), stdin.to_vec());
    // The program may end before it has read its input.
    let writer = thread::spawn(move || drop(input.write_all(&stdin)));
    let [stdout, stderr] = [text_of(program.stdout.take().unwrap()), text_of(program.stderr.take().unwrap())];
    let start = Instant::now();
    let status = loop {
        if let Some(status) = program.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > TIME_LIMIT {
            program.kill().unwrap();
            panic!("{arguments:?} hangs");
        }
        thread::sleep(Duration::from_millis(2));
    };
    writer.join().unwrap();
    Answer { status: status.code().unwrap_or(-1), stdout: stdout.join().unwrap(), stderr: stderr.join().unwrap() }
}

/// Reads text to its end, beside the caller.
fn text_of(mut stream: impl Read + Send + 'static) -> JoinHandle<String> {
    thread::spawn(move || {
        let mut text = String::new();
        stream.read_to_string(&mut text).unwrap();
        text
    })
}

/// Calls the program with these arguments (text or paths) and an empty standard input.
macro_rules! underbrush {
    ($($argument:expr),* $(,)?) => {
        $crate::support::call(
            vec![$(<_ as AsRef<std::ffi::OsStr>>::as_ref(&$argument).to_os_string()),*], "")
    };
}
pub(crate) use underbrush;

/// All files below a folder with their bytes, by relative path.
pub fn tree(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_path_buf();
                files.insert(name, std::fs::read(path).unwrap());
            }
        }
    }
    files
}

/// Copies a folder.
pub fn copy_tree(from: &Path, to: &Path) {
    for (name, bytes) in tree(from) {
        let path = to.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
}

/// Demands that two folders hold the same files with the same bytes.
#[track_caller]
pub fn assert_same_trees(left: &Path, right: &Path) {
    let (left, right) = (tree(left), tree(right));
    let names = |files: &BTreeMap<PathBuf, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&left), names(&right));
    assert!(!left.is_empty(), "no files to compare");
    for (name, bytes) in &left {
        assert!(*bytes == right[name], "{} differs", name.display());
    }
}
