//! The scenes that ship, built into the library so that programs need no folder beside them. `sim/scenes` is a link to
//! the folder `scenes` of the repository, so that the package of this crate contains them.

macro_rules! shipped {
    ($($path:literal),* $(,)?) => {
        /// The scenes that ship: path below the folder `scenes`, and text.
        const SHIPPED: &[(&str, &str)] = &[$(($path, include_str!(concat!("../../scenes/", $path)))),*];
    };
}

shipped![
    "leaf.toml",
    "trunk.toml",
    "mixed.toml",
    "outlier.toml",
    "bottle.toml",
    "shrub.toml",
    "pot.toml",
    "loose.toml",
    "engineered/leaf-clump.toml",
    "engineered/leaf-right.toml",
    "engineered/leaf-row.toml",
    "engineered/leaf-stiff.toml",
    "engineered/leaf-tall.toml",
    "engineered/trunk-gate.toml",
    "engineered/trunk-post.toml",
    "engineered/trunk-right.toml",
    "engineered/trunk-row.toml",
    "engineered/trunk-thick.toml",
    "passage/hedge.toml",
    "passage/gate.toml",
    "varied/varied-leaves.toml",
    "varied/varied-trunks.toml",
    "auxiliary/soft-rolls.toml",
    "auxiliary/stiff-poles.toml",
    "auxiliary/free-cylinders.toml",
    "auxiliary/stalks.toml",
    "unknown/soft-roll.toml",
    "unknown/hard-roll.toml",
    "unknown/full-bottle.toml",
    "unknown/springy-branch.toml",
    "unknown/cloth-leaf.toml",
    "unknown/thick-post.toml",
];

/// The scenes that ship: name and text.
pub fn shipped_by_name() -> impl Iterator<Item = (&'static str, &'static str)> {
    SHIPPED.iter().map(|(path, text)| {
        let file = path.rsplit('/').next().unwrap_or(path);
        (file.trim_end_matches(".toml"), *text)
    })
}

/// The text of a scene, by its path in the folder `scenes`; `None` if no such scene ships.
pub fn shipped(path: &str) -> Option<&'static str> {
    SHIPPED.iter().find(|(name, _)| *name == path).map(|(_, text)| *text)
}
