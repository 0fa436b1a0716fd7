//! The name of the engine in data sets.

/// Pins that a data set names the engine version in Cargo.lock, so that an update cannot be forgotten.
#[test]
fn provenance_names_the_engine_of_the_lock_file() {
    let lock = include_str!("../../Cargo.lock");
    let package = lock
        .split("[[package]]")
        .find(|package| package.contains("\nname = \"rapier3d-f64\"\n"))
        .unwrap();
    let version = package
        .lines()
        .find_map(|line| line.strip_prefix("version = \"")?.strip_suffix('"'))
        .unwrap();
    let named = format!("rapier3d-f64 {version},");
    assert!(
        underbrush_sim::physics::ENGINE.starts_with(&named),
        "{} is not {named}",
        underbrush_sim::physics::ENGINE
    );
}
