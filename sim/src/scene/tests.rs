//! Scene files that users wrote for earlier versions, and the lines of errors.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use super::Scene;

/// Tests that keys under their earlier names mean the same as under the present ones, and that an error about such a
/// key still names its line.
#[test]
fn earlier_keys_are_still_read() {
    let scene = |prefix: &str, share: f64| {
        let text = format!(
            "summary = \"A test\"\n[sensor]\n{prefix}_share = {share}\n{prefix}_time_s = 3.0\n{prefix}_force_n = [0.03, 0.05]\n"
        );
        Scene::parse("test.toml", text)
    };
    let (earlier, present) = (scene("stray", 0.1).unwrap(), scene("spurious", 0.1).unwrap());
    assert_eq!(earlier.file.sensor, present.file.sensor);
    assert_eq!(present.file.sensor.spurious_force_n, [0.03, 0.05]);
    let error = scene("stray", 0.6).unwrap_err();
    assert_eq!((error.field.as_str(), error.line), ("sensor.spurious_share", Some(3)));
}

/// Tests that the line of an error about a group that is an inline table, or has dotted keys, is the group's own.
#[test]
fn groups_without_a_header_have_their_own_lines() {
    for text in [
        "goals = { count = 0 }\n[[objects.foam_block]]\ncount = 2\n",
        "goals.count = 2000\n[[objects.trunk]]\ncount = 2\n",
        "objects = { trunk = [ { count = 20000 } ] }\n[goals]\ncount = 3\n",
        "workspace.x_m = [0.5, 0.2]\n[goals]\nx_m = 0.5\n",
    ] {
        let error = Scene::parse("test.toml", format!("summary = \"A test\"\n{text}")).unwrap_err();
        assert_eq!(error.line, Some(2), "{error}");
    }
}
