//! The check itself, on crates of a few lines.

use super::cycles::{Cycle, arrows, cycles};
use super::*;

fn sources(files: &[(&str, &str)]) -> Sources {
    let module = |name: &str| name.split('/').filter(|part| !part.is_empty()).map(String::from).collect();
    let source = |(name, text): &(&str, &str)| (module(name), (PathBuf::from(name), (*text).to_string()));
    files.iter().map(source).collect()
}

fn named(files: &[(&str, &str)]) -> Vec<String> {
    let pairs = arrows(&sources(files)).into_keys();
    pairs.map(|(from, to)| format!("{} {}", from.join("/"), to.join("/"))).collect()
}

/// Tests that every way in which a module can name another module of its crate is read.
#[test]
fn every_style_of_import_is_read() {
    for text in [
        "use crate::b::Thing;",
        "pub use crate::{b::{self, Thing}, Other};",
        "use super::b;",
        "use super::{b::Thing as Renamed, Other};",
        "pub(crate) use super::super::a::super_is_resolved::{self as _}; use super::b::*;",
        "fn f() { crate::b::f(); }",
        "fn f() { let x: Vec<super::b::Thing> = vec![]; }",
        "fn f() { println!(\"{}\", crate::b::NUMBER); }",
        "macro_rules! m { () => { $crate::b::f() }; }",
        "mod inside { use super::super::b::Thing; }",
        "fn f() { use crate::b::Thing; }",
        // The root re-exports it.
        "use crate::Shown;",
    ] {
        let found = named(&[("", "mod a; mod b; pub use b::Shown;"), ("a", text), ("b", "")]);
        assert_eq!(found, ["a b"], "{text}");
    }
    // From a submodule, and through the parent's private import.
    for text in ["use super::super::b::Thing;", "use super::Thing;", "fn f() { self::super::Thing::new() }"] {
        let found = named(&[("", ""), ("a", "use crate::b::Thing;"), ("a/c", text), ("b", "")]);
        assert_eq!(found, ["a b"], "{text}");
        let found = named(&[("", ""), ("a", ""), ("a/c", "use super::super::b::Thing;"), ("b", "")]);
        assert_eq!(found, ["a b"]);
    }
}

/// Tests that these are not read as dependencies between siblings: tests, comments, strings, other crates, and a parent
/// and its own submodules.
#[test]
fn what_is_no_import_is_not_read() {
    for text in [
        "#[cfg(test)]\nmod tests { use crate::b::Thing; }",
        "#[cfg(test)]\nuse crate::b::Thing;\n",
        "// use crate::b::Thing;",
        "/// See [`crate::b::Thing`].\nfn f() {}",
        "const TEXT: &str = \"use crate::b::Thing;\";",
        "use other::b::Thing;",
        "pub(crate) fn f() {}",
    ] {
        assert_eq!(named(&[("", ""), ("a", text), ("b", "")]), [""; 0], "{text}");
    }
    let parent = [("", ""), ("a", "mod c; use c::f; pub struct A;"), ("a/c", "use super::A;")];
    assert_eq!(named(&parent), [""; 0]);
}

/// Tests that a cycle is found wherever it closes: between two files, through a third, deep in folders, and through a
/// re-export; and that a graph without one has none.
#[test]
fn cycles_are_found_and_named() {
    let found = |files: &[(&str, &str)]| -> Vec<String> {
        let of_cycle = |cycle: Cycle| cycle.modules.iter().map(|module| module.join("/")).collect::<Vec<_>>().join(" ");
        cycles(&sources(files)).into_iter().map(of_cycle).collect()
    };
    let root = ("", "");
    assert_eq!(found(&[root, ("a", "use crate::b::B;"), ("b", "use super::a::A;")]), ["a b"]);
    let through_third = [root, ("a", "use crate::b::B;"), ("b", "use crate::c::C;"), ("c", "fn f() { crate::a::f() }")];
    assert_eq!(found(&through_third), ["a b c"]);
    let between_folders = [root, ("a", ""), ("a/x", "use crate::b::y::Y;"), ("b", "use crate::a::A;"), ("b/y", "")];
    assert_eq!(found(&between_folders), ["a b"]);
    let siblings = [root, ("a", ""), ("a/x", "use super::y::Y;"), ("a/y", "use super::x::X;")];
    assert_eq!(found(&siblings), ["a/x a/y"]);
    let shown = [root, ("a", "pub use x::X;"), ("a/x", "use super::y::Y;"), ("a/y", "use super::X;")];
    assert_eq!(found(&shown), ["a/x a/y"]);
    let one_way = [root, ("a", "use crate::{b::B, c::C};"), ("b", "use crate::c::C;"), ("c", "")];
    assert_eq!(found(&one_way), [""; 0]);
    let text = cycles(&sources(&siblings))[0].to_string();
    assert!(text.contains("a/x needs a/y") && text.contains("names crate::a::y::Y"), "{text}");
}

/// Tests that the sources of the project itself are read: every crate, and arrows that are known to be there.
#[test]
fn the_projects_own_imports_are_read() {
    let crates = crates(Path::new(env!("CARGO_MANIFEST_DIR")));
    let names: Vec<&str> = crates.iter().map(|(name, _)| name.as_str()).collect();
    for name in ["classifier", "oracles", "recording", "sim", "underbrush", "validation"] {
        assert!(names.contains(&name), "{name} is not in {names:?}");
    }
    let (_, sim) = crates.iter().find(|(name, _)| name == "sim").unwrap();
    let arrows = arrows(&read(sim));
    let has = |from: &str, to: &str| arrows.contains_key(&(vec![from.to_string()], vec![to.to_string()]));
    assert!(has("reach", "controller") && has("clutter", "scene") && !has("scene", "reach"));
}
