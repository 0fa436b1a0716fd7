//! `underbrush completions`.

use crate::support::underbrush;

/// Tests that every script knows the commands and options, and that bash takes its script.
#[test]
fn shells_get_scripts() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = underbrush!["completions", shell].success();
        assert!(script.contains("fit-skin") && script.contains("punch-area-cm2"), "{shell}");
    }
    let script = underbrush!["completions", "bash"].success();
    let bash = std::process::Command::new("bash").args(["-n", "-c", &script]).output().unwrap();
    assert!(bash.status.success(), "{}", String::from_utf8_lossy(&bash.stderr));
}

/// Tests that the error names both things that can be asked for if neither is.
#[test]
fn a_shell_or_a_folder_is_needed() {
    underbrush!["completions"].refused(&["SHELL", "--manual"]);
}

/// Tests that there is a manual page for the program and each command, with the options of that command.
#[test]
fn commands_have_manual_pages() {
    let folder = tempfile::tempdir().unwrap();
    let man = folder.path().join("man1");
    assert!(underbrush!["completions", "--manual", man].success().contains("man1"));
    assert_eq!(underbrush!["completions", "--manual", man, "--json"].json()["manual"], man.to_str().unwrap());
    let page = |name: &str| std::fs::read_to_string(man.join(name)).unwrap();
    assert!(page("underbrush.1").contains("underbrush\\-generate(1)"));
    assert!(page("underbrush-generate.1").contains("\\-\\-reaches"));
}

/// Tests that examples on manual pages are neither hyphenated nor justified, so that they can be copied.
#[test]
fn examples_on_manual_pages_stay_whole() {
    let folder = tempfile::tempdir().unwrap();
    underbrush!["completions", "--manual", folder.path()].success();
    let page = std::fs::read_to_string(folder.path().join("underbrush-classify.1")).unwrap();
    let (_, examples) = page.split_once(".SH EXTRA\n.nh\n.ad l\n").unwrap();
    assert!(examples.contains("sensed_force_n"), "{examples}");
}

/// Tests that a file in place of the folder for manual pages is bad input.
#[test]
fn manual_pages_need_a_folder() {
    let file = tempfile::NamedTempFile::new().unwrap();
    underbrush!["completions", "--manual", file.path()].refused(&["--manual: found a file", "allowed: a folder"]);
}
