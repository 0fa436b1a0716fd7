//! The scenes that ship, built into the library so that programs need no folder beside them. `sim/scenes` is a link to
//! the folder `scenes` of the repository, so that the package of this crate contains them.

macro_rules! shipped {
    ($($folder:literal: $($name:literal)*;)*) => {
        /// The scenes that ship: path below the folder `scenes`, and text.
        const SHIPPED: &[(&str, &str)] = &[$($((
            concat!($folder, $name, ".toml"),
            include_str!(concat!("../../scenes/", $folder, $name, ".toml")),
        ),)*)*];
    };
}
shipped! {
    "": "leaf" "trunk" "mixed" "outlier" "bottle" "shrub" "pot" "loose";
    "engineered/": "leaf-clump" "leaf-right" "leaf-row" "leaf-stiff" "leaf-tall"
        "trunk-gate" "trunk-post" "trunk-right" "trunk-row" "trunk-thick";
    "passage/": "hedge" "gate";
    "varied/": "varied-leaves" "varied-trunks";
    "auxiliary/": "soft-rolls" "stiff-poles" "free-cylinders" "stalks";
    "unknown/": "soft-roll" "hard-roll" "full-bottle" "springy-branch" "cloth-leaf" "thick-post";
}

/// The scenes that ship: name and text.
pub fn shipped_by_name() -> impl Iterator<Item = (&'static str, &'static str)> {
    SHIPPED.iter().map(|(path, text)| (path.rsplit('/').next().unwrap_or(path).trim_end_matches(".toml"), *text))
}

/// The text of a scene, by its path in the folder `scenes`; `None` if no such scene ships.
pub fn shipped(path: &str) -> Option<&'static str> {
    SHIPPED.iter().find(|(name, _)| *name == path).map(|(_, text)| *text)
}
