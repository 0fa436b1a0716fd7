//! Tells dependents where the sources of this crate are, because `underbrush-experiments` hashes them.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::metadata=folder={}", env!("CARGO_MANIFEST_DIR"));
}
