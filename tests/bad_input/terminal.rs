//! Characters that would change the terminal or the order of the text.

use crate::support::fixture::fixture;
use crate::support::{Answer, call, scenes, underbrush};

/// The beginning of an escape sequence, its form of one character, and a bidirectional control.
const HOSTILE: [char; 3] = ['\u{1b}', '\u{9b}', '\u{202e}'];

/// Demands that nothing on stdout or stderr has such a character, and that what was there is shown escaped.
#[track_caller]
fn assert_escaped(answer: &Answer, character: char) {
    let said = format!("{}{}", answer.stdout, answer.stderr);
    assert!(!said.contains(HOSTILE), "{said:?}");
    let escaped = [format!("\\u{:04x}", u32::from(character)), format!("\\u{{{:x}}}", u32::from(character))];
    assert!(escaped.iter().any(|escaped| said.contains(escaped)), "{said}");
}

/// Tests that summaries of scenes and suites, names of scene files and patches, and categories of tables and models are
/// refused if they have such characters.
#[test]
fn names_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    for character in HOSTILE {
        let code = format!("{:04x}", u32::from(character));
        let scene = scenes::FEW_TRUNKS.replace("A few trunks", &format!("A \\u{code}[31m few trunks"));
        let scene = write("scene.toml", &scene);
        let named = write(&format!("tr{character}unk.toml"), scenes::FEW_TRUNKS);
        let suite = format!("summary = \"A \\u{code} suite\"\nseed = 1\nscenes = []\n");
        let suite = write("suite.toml", &suite);
        let table = format!("trial,category,time_s,force_n\n0,le{character}[2Jaf,0,1\n");
        let table = write("trials.csv", &table);
        let model = std::fs::read_to_string(fixture().model()).unwrap();
        let model = write("model.json", &model.replace("\"trunk\"", &format!("\"tru\\u{code}nk\"")));
        for (field, answer) in [
            ("summary", underbrush!["inspect", scene]),
            ("file name", underbrush!["inspect", named]),
            ("summary", underbrush!["check", suite]),
            ("category", underbrush!["evaluate", table]),
            ("categories", underbrush!["inspect", model]),
        ] {
            answer.refused(&[field, "text without control characters"]);
            assert_escaped(&answer, character);
        }
    }
}

/// Tests that such characters are escaped where they cannot be refused: in names of files, arguments, quoted lines of
/// files, and JSON.
#[test]
fn what_is_printed_is_escaped() {
    let folder = tempfile::tempdir().unwrap();
    for character in HOSTILE {
        let absent = format!("ab{character}[31msent.toml");
        let broken = folder.path().join("broken.toml");
        std::fs::write(&broken, format!("# {character}[2J\r\nsummary = 3 # {character}]0;title\n")).unwrap();
        let table = folder.path().join(format!("table{character}.csv"));
        std::fs::copy(fixture().table_csv(), &table).unwrap();
        for options in [&[][..], &["--json"]] {
            let with = |words: &[&str]| call([words, options].concat().into_iter().map(Into::into).collect(), "");
            assert_escaped(&with(&["inspect", &absent]), character);
            // Here clap removes whole escape sequences instead.
            let usage = with(&["reach", "scene.toml", &absent]);
            assert_eq!(usage.status, 2);
            let said = format!("{}{}", usage.stdout, usage.stderr);
            assert!(said.contains("sent.toml") && !said.contains(HOSTILE), "{said:?}");
        }
        let quoted = underbrush!["inspect", broken];
        assert_escaped(&quoted, character);
        // The mark is under the line that it is about, from its first column to its last.
        let lines: Vec<&str> = quoted.stderr.lines().collect();
        let at = lines.iter().position(|line| line.ends_with("^ here")).unwrap();
        let [line, mark] = [at - 1, at].map(|at| lines[at].split_once("| ").unwrap());
        let marked = format!("{} here", "^".repeat(line.1.chars().count()));
        assert_eq!(mark.1, marked, "{}", quoted.stderr);
        assert_eq!(mark.0.len(), line.0.len(), "{}", quoted.stderr);
        assert_escaped(&underbrush!["inspect", &table], character);
        assert_escaped(&underbrush!["inspect", &table, "--json"], character);
    }
}
