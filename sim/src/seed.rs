//! Random numbers: one `u64` seed gives every reach its own named streams.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The stream for one purpose (such as `"clutter"`, `"goals"` or `"sensor"`) of one reach of one scene, which is named by
/// [`Scene::stream`](crate::scene::Scene::stream).
///
/// A stream depends only on these four arguments, so threads, shards and other scenes do not change it.
pub fn stream(seed: u64, scene: &str, reach_index: u64, purpose: &str) -> ChaCha8Rng {
    let mut hasher = blake3::Hasher::new_derive_key("underbrush 2026 random streams");
    hasher.update(&seed.to_le_bytes());
    hasher.update(&reach_index.to_le_bytes());
    // The length keeps ("ab", "c") apart from ("a", "bc").
    hasher.update(&(scene.len() as u64).to_le_bytes());
    hasher.update(scene.as_bytes());
    hasher.update(purpose.as_bytes());
    ChaCha8Rng::from_seed(*hasher.finalize().as_bytes())
}

#[cfg(test)]
mod tests {
    use super::stream;
    use rand::Rng;

    /// Pins that a change of any of the four arguments gives another stream, and that the same arguments give the same
    /// stream.
    #[test]
    fn streams_differ_in_every_part() {
        let first = |seed, scene, reach, purpose| stream(seed, scene, reach, purpose).next_u64();
        let base = first(1, "leaf", 2, "clutter");
        assert_eq!(base, first(1, "leaf", 2, "clutter"));
        for other in [
            first(2, "leaf", 2, "clutter"),
            first(1, "trunk", 2, "clutter"),
            first(1, "leaf", 3, "clutter"),
            first(1, "leaf", 2, "goals"),
            first(1, "leafc", 2, "lutter"),
        ] {
            assert_ne!(base, other);
        }
    }
}
