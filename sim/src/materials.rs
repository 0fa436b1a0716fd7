//! Constants of contacts that a scene can set or draw for each reach, and the file with their values, ranges and sources.

use std::collections::BTreeMap;
use std::path::Path;

use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::{InputError, Limits, TEXT_BYTES, parse_toml, read_text, short};

use crate::arm::{Arm, limits};
use crate::range::{Draw, DrawError, Limited, Within};

macro_rules! materials {
    ($($(#[doc = $text:literal])+ $name:ident: $limits:expr;)+) => {
        /// Constants of the contact between arm and objects. Each that is given replaces that of the arm's files or of the
        /// objects in every reach, and is drawn anew for each if it is a range.
        #[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields, default)]
        pub struct MaterialsSection {
            $($(#[doc = $text])+ #[schemars(transform = Within($limits))] pub $name: Option<Draw>,)+
        }

        /// The constants of one reach; `None` for those that the scene does not mention.
        #[derive(Clone, Copy, Debug, Default, PartialEq)]
        pub struct Materials {
            $($(#[doc = $text])+ pub $name: Option<f64>,)+
        }

        impl MaterialsSection {
            /// The ranges that are given, with their names and limits.
            pub fn quantities(&self) -> Vec<Limited> {
                let all = [$((stringify!($name), self.$name, $limits)),+].into_iter();
                all.filter_map(|(name, draw, limits)| Some(Limited { name, draw: draw?, limits })).collect()
            }

            /// Draws the constants of a reach.
            ///
            /// # Errors
            /// If a range holds (almost) no physical values.
            pub fn draw(&self, random: &mut ChaCha8Rng) -> Result<Materials, DrawError> {
                let mut draw = |name, range: Option<Draw>, limits| {
                    let value = range.map(|range| range.draw(random, limits));
                    value.transpose().map_err(|error| DrawError { name, ..error })
                };
                Ok(Materials { $($name: draw(stringify!($name), self.$name, $limits)?),+ })
            }
        }

        impl Materials {
            /// The constants that are set, by name.
            pub fn values(&self) -> impl Iterator<Item = (&'static str, f64)> {
                [$((stringify!($name), self.$name)),+].into_iter().filter_map(|(name, value)| Some((name, value?)))
            }
        }

        /// The constants with their limits, in the order in which they are drawn.
        pub const CONSTANTS: &[(&str, Limits)] = &[$((stringify!($name), $limits)),+];
    };
}

materials! {
    /// Foundation modulus of the skin, N/m³: pressure per depth.
    skin_modulus_n_per_m3: limits::SKIN_N_PER_M3;
    /// Thickness of the skin, m: the most by which it gives way.
    skin_thickness_m: limits::LAYER_M;
    /// Loss time of the skin, s.
    skin_loss_time_s: limits::LOSS_TIME_S;
    /// Coefficient of friction of the arm's surface. A contact has the mean of its two surfaces.
    arm_friction: limits::FRICTION;
    /// Coefficient of friction of leaves, trunks, foam blocks and foam rolls.
    object_friction: limits::FRICTION;
    /// Coefficient of friction of the table.
    table_friction: limits::FRICTION;
    /// The share of the pressure on the gaps between taxels on a cylinder that the cover passes on to them.
    skin_gap_share: limits::SHARE;
}

impl Materials {
    /// Gives the arm these constants.
    pub fn apply_to(&self, arm: &mut Arm) {
        arm.skin.stiffness_n_per_m3 = self.skin_modulus_n_per_m3.unwrap_or(arm.skin.stiffness_n_per_m3);
        arm.skin.thickness_m = self.skin_thickness_m.or(arm.skin.thickness_m);
        arm.skin.loss_time_s = self.skin_loss_time_s.unwrap_or(arm.skin.loss_time_s);
        arm.friction = self.arm_friction.unwrap_or(arm.friction);
        if let Some(gap_share) = self.skin_gap_share {
            arm.skin.surfaces.iter_mut().for_each(|surface| surface.gap_share = gap_share);
        }
    }
}

/// One constant of a file of materials.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Constant {
    /// The value that is used unless it is drawn.
    pub value: f64,
    /// The smallest and the largest plausible value.
    pub range: [f64; 2],
    /// Where value and range come from.
    pub source: String,
    /// What depends on it.
    pub affects: String,
}

/// A file of materials: constants by name.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialFile {
    /// The constants.
    pub constants: BTreeMap<String, Constant>,
}

impl MaterialFile {
    /// The file that ships.
    ///
    /// ```
    /// use underbrush_sim::materials::{CONSTANTS, MaterialFile};
    ///
    /// let file = MaterialFile::shipped()?;
    /// assert!(CONSTANTS.iter().all(|(name, _)| file.constants.contains_key(*name)));
    /// # Ok::<(), underbrush_recording::InputError>(())
    /// ```
    ///
    /// # Errors
    /// Never: the file is part of the build, and tests read it.
    pub fn shipped() -> Result<MaterialFile, InputError> {
        MaterialFile::parse("materials.toml".as_ref(), include_str!("../materials.toml"))
    }

    /// Reads and checks a file. It need not have all constants.
    ///
    /// # Errors
    /// When the file cannot be read, is not TOML, has unknown keys, or a value that is outside its limits or its range.
    pub fn load(path: &Path) -> Result<MaterialFile, InputError> {
        let remedy = "copy sim/materials.toml and change it";
        MaterialFile::parse(path, &read_text(path, &TEXT_BYTES, "a readable file of materials", remedy)?)
    }

    /// The text of the file.
    pub fn text(&self) -> String {
        // Numbers and plain texts serialize.
        toml::to_string(&self.constants).unwrap_or_default()
    }

    fn parse(path: &Path, text: &str) -> Result<MaterialFile, InputError> {
        let allowed = "tables [NAME] with value, range, source and affects";
        let constants: BTreeMap<String, Constant> = parse_toml(path, text, "materials", allowed)?;
        for (name, Constant { value, range: [low, high], .. }) in &constants {
            let fault =
                |found: String, allowed: String| Err(InputError::new(path, name, found, allowed, "correct this table"));
            let Some((_, limits)) = CONSTANTS.iter().find(|(known, _)| known == name) else {
                let known: Vec<&str> = CONSTANTS.iter().map(|(name, _)| *name).collect();
                return fault("an unknown constant".into(), known.join(", "));
            };
            if let Some((found, allowed)) = Draw::Uniform(*low, *high).fault(*limits) {
                return fault(found, allowed);
            }
            if !(low..=high).contains(&value) {
                return fault(short(*value), format!("a value within its range, {} to {}", short(*low), short(*high)));
            }
        }
        Ok(MaterialFile { constants })
    }

    /// The section `[materials]` of a scene file: every constant is drawn from its range, or else has its value.
    pub fn section(&self, draws: bool) -> String {
        let line = |(name, Constant { value, range: [low, high], .. }): (&String, &Constant)| match draws {
            true => format!("{name} = {{ uniform = [{low:e}, {high:e}] }}\n"),
            false => format!("{name} = {value:e}\n"),
        };
        let lines: String = self.constants.iter().map(line).collect();
        format!("[materials]\n{lines}")
    }
}

#[cfg(test)]
mod tests;
