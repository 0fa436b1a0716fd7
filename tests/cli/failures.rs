//! Commands that fail, with `--json`.

use std::ffi::OsString;

use serde_json::Value;

use crate::support::fixture::fixture;
use crate::support::{Answer, call, underbrush};

/// The keys of every error.
const KEYS: [&str; 8] = ["allowed", "field", "file", "found", "kind", "line", "message", "remedy"];

/// For every subcommand but `schema` arguments with which it fails, and the kind of this error. `OUT` is a path that can
/// be written, and `FILE` a file.
const FAILING: [(&[&str], &str); 20] = [
    (&["reproduce", "--experiment", "absent.toml", "--out", "OUT"], "input"),
    (&["reach", "absent.toml"], "input"),
    (&["arm", "new", "absent.urdf", "--tip", "hand", "--out", "OUT.toml"], "input"),
    (&["arm", "skin", "absent.toml", "--link", "arm", "--pitch-mm", "9", "--patch", "arm"], "input"),
    (&["arrange", "absent.toml", "--out", "OUT.toml"], "input"),
    (&["fit-skin", "absent.csv", "--ball-radius-mm", "5"], "input"),
    (&["generate", "absent.toml", "--reaches", "1", "--out", "OUT"], "input"),
    (&["merge", "absent", "--out", "OUT"], "input"),
    (&["train", "absent.csv", "--out", "OUT"], "input"),
    (&["classify", "absent.json", "absent.csv"], "input"),
    (&["evaluate", "absent.csv"], "input"),
    (&["trials", "absent", "--out", "OUT.csv"], "input"),
    (&["score", "absent.json", "absent.csv"], "input"),
    (&["check", "absent.toml"], "input"),
    (&["benchmark", "verdicts", "--model", "absent.json", "--out", "OUT"], "input"),
    (&["inspect", "absent"], "input"),
    (&["replay", "absent"], "input"),
    (&["export", "absent", "--to", "mcap", "--out", "OUT"], "usage"),
    (&["completions", "--manual", "FILE/man"], "run"),
    (&["import", "absent.csv", "--mapping", "absent.toml", "--out", "OUT.csv"], "input"),
];

/// The error that a command printed as the only thing on stdout.
#[track_caller]
fn error(answer: &Answer) -> Value {
    let Answer { stdout, stderr, .. } = answer;
    let object: Value = serde_json::from_str(stdout).unwrap_or_else(|error| panic!("{error}: {stdout:?}\n{stderr}"));
    assert_eq!(object.as_object().unwrap().len(), 1, "{object}");
    let keys: Vec<&String> = object["error"].as_object().unwrap().keys().collect();
    assert_eq!(keys, KEYS, "{object}");
    object["error"].clone()
}

/// The names of the subcommands that the help lists.
fn subcommands() -> Vec<String> {
    let help = underbrush!["--help"].success();
    let list = help.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    let entries = list.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names = entries.map(|line| line.split_whitespace().next().unwrap().to_owned());
    names.filter(|name| name != "help").collect()
}

/// Tests that every subcommand, if it fails, prints the error as one object on stdout with `--json`, and only on stderr
/// without it, with the same exit status and the same text on stderr.
#[test]
fn every_command_prints_its_error_as_json() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let out = folder.path().join("out").display().to_string();
    for (arguments, kind) in FAILING {
        let filled = arguments
            .iter()
            .map(|argument| argument.replace("OUT", &out).replace("FILE", &file.display().to_string()).into());
        let plain: Vec<OsString> = filled.collect();
        let with_json = [plain.clone(), vec!["--json".into()]].concat();
        let [plain, with_json] = [plain, with_json].map(|arguments| call(arguments, ""));
        assert_eq!(plain.stdout, "", "{arguments:?}");
        assert_eq!(with_json.stderr, plain.stderr, "{arguments:?}");
        let status = if kind == "run" { 1 } else { 2 };
        assert_eq!((plain.status, with_json.status), (status, status), "{arguments:?}");
        let error = error(&with_json);
        assert_eq!(error["kind"], kind, "{arguments:?}: {error}");
        assert!(!error["message"].as_str().unwrap().is_empty());
        let is_input = kind == "input";
        // The run fails because a folder cannot be made.
        for key in ["file", "found", "remedy"] {
            assert_eq!(error[key].is_string(), is_input || kind == "run", "{key} of {error}");
        }
        for key in ["field", "allowed"] {
            assert_eq!(error[key].is_string(), is_input, "{key} of {error}");
        }
    }
    let names: Vec<&str> = FAILING.iter().map(|(arguments, _)| arguments[0]).collect();
    // These two read and write no files.
    for name in subcommands().iter().filter(|name| !["schema", "validate"].contains(&name.as_str())) {
        assert!(names.contains(&name.as_str()), "no failing {name}");
    }
}

/// Tests that every subcommand prints an error about its usage as one object with `--json`.
#[test]
fn usage_errors_are_json_too() {
    for name in subcommands() {
        let answer = underbrush![name, "--json", "--no-such-option"];
        assert_eq!(answer.status, 2);
        let error = error(&answer);
        assert_eq!(error["kind"], "usage", "{name}");
        assert!(error["message"].as_str().unwrap().contains("--no-such-option"), "{error}");
        assert!(!error["message"].as_str().unwrap().starts_with("error:"), "{error}");
        assert!(answer.stderr.contains("--no-such-option"));
        underbrush![name, "--no-such-option"].refused(&["--no-such-option"]);
    }
    assert!(underbrush!["--json", "--help"].success().contains("Commands:"));
}

/// Tests that no option answers a word in place of a number in the words of the parser of numbers, which do not say what is allowed.
#[test]
fn options_say_which_numbers_are_allowed() {
    let others = subcommands().into_iter().filter(|name| name != "arm").map(|name| vec![name]);
    let of_arm = ["new", "skin"].map(|name| vec!["arm".to_owned(), name.to_owned()]);
    for command in others.chain(of_arm) {
        let with = |further: &[&str]| {
            let arguments = command.iter().map(String::as_str).chain(further.iter().copied());
            call(arguments.map(OsString::from).collect(), "")
        };
        let help = with(&["--help"]).success();
        let named = help.lines().filter_map(|line| line.trim_start().split_once(" <"));
        for (option, _) in named.filter(|(option, _)| option.starts_with("--") && !option.contains(' ')) {
            // Nothing is run without threads.
            let answer = with(&[option, "word", "--jobs", "0"]);
            assert_eq!(answer.status, 2, "{command:?} {option}");
            let is_of_parser =
                ["invalid digit", "invalid float", "is not in"].iter().any(|own| answer.stderr.contains(own));
            assert!(!is_of_parser, "{command:?}: {}", answer.stderr);
        }
    }
}

/// Tests that an error about a line of a file has the file, the line and what is allowed as values of their own.
#[test]
fn an_error_about_a_line_has_all_values() {
    let folder = tempfile::tempdir().unwrap();
    let table = folder.path().join("trials.csv");
    std::fs::write(&table, "trial,time_s,force_n\n0,0,much\n").unwrap();
    let answer = underbrush!["classify", fixture().model(), table, "--json"];
    assert_eq!(answer.status, 2);
    let error = error(&answer);
    assert_eq!(error["file"], table.display().to_string());
    assert_eq!((&error["line"], &error["field"]), (&2.into(), &"force_n".into()));
    for key in ["found", "allowed", "remedy"] {
        assert!(error["message"].as_str().unwrap().contains(error[key].as_str().unwrap()));
    }
}

/// Tests that a result that says itself that something failed stays the only object.
#[test]
fn a_result_is_not_followed_by_an_error() {
    let answer = underbrush!["validate", "--only", "resting-load", "--tolerance-scale", "0", "--json"];
    assert_eq!(answer.status, 1, "{}", answer.stderr);
    let report: Value = serde_json::from_str(&answer.stdout).unwrap();
    assert_eq!(report["sound"], false);
}

/// What the program does with these arguments after a limit of the shell.
#[cfg(target_os = "linux")]
fn limited(limit: &str, arguments: &str) -> std::process::Output {
    let script = format!("ulimit {limit} && exec \"$0\" {arguments}");
    let mut shell = std::process::Command::new("bash");
    shell.args(["-c", &script, env!("CARGO_BIN_EXE_underbrush")]).env("RAYON_NUM_THREADS", "1024").output().unwrap()
}

/// Tests that threads for which there is no memory are no internal error.
#[test]
#[cfg(target_os = "linux")]
fn threads_without_memory_are_no_bug() {
    let output = limited("-v 1000000", "inspect leaf --json");
    let object: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((output.status.code(), object["error"]["kind"].as_str()), (Some(1), Some("run")), "{object}");
}

/// Tests that a program that may start no thread says so. The limit does not hold for root.
#[test]
#[cfg(target_os = "linux")]
fn a_program_without_threads_is_not_silent() {
    let output = limited("-u 1", "schema");
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(output.status.success() || stderr.starts_with("error: cannot start threads"), "{} {stderr}", output.status);
}
