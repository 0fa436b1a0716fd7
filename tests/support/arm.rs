//! A user's arm: Cody's files with another skin.

use std::path::{Path, PathBuf};

/// Writes Cody's files with a changed skin file to a folder, and a scene with trunks for this arm.
pub fn write(folder: &Path, skin: impl Fn(&str) -> String) -> PathBuf {
    let cody = Path::new(env!("CARGO_MANIFEST_DIR")).join("sim/arms/cody");
    for name in ["cody.toml", "cody.urdf", "cody.skin.toml"] {
        let text = std::fs::read_to_string(cody.join(name)).unwrap();
        let text = if name == "cody.skin.toml" { skin(&text) } else { text };
        std::fs::write(folder.join(name), text).unwrap();
    }
    let scene = format!("arm = \"cody.toml\"\n{}", super::scenes::TRUNKS_AT_FOREARM);
    super::scenes::write(folder, "foreign.toml", &scene)
}

/// The skin with its first patch renamed from `forearm` to `sleeve`.
pub fn renamed(skin: &str) -> String {
    skin.replacen("name = \"forearm\"", "name = \"sleeve\"", 1)
}

/// The skin with only the flipper, whose taxels form no grid.
pub fn flipper_alone(skin: &str) -> String {
    let forearm = skin.find("[[patch]]").unwrap();
    let flipper = skin.rfind("[[patch]]").unwrap();
    format!("{}{}", &skin[..forearm], &skin[flipper..])
}

/// The skin without patches.
pub fn bare(skin: &str) -> String {
    skin[..skin.find("[[patch]]").unwrap()].to_owned()
}
