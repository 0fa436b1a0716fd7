//! Scene files that users wrote for earlier versions.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use super::Scene;

/// Pins that keys under their earlier names mean the same as under the present ones, and that an error about such a key
/// still names its line.
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
