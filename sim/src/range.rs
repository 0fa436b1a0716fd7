//! The numbers of a scene file, each fixed or a range to draw from, where a group of objects may stand, and options with their
//! defaults and limits.

use std::fmt;

use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Uniform};
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use underbrush_recording::{Limits, short};

use crate::seed::{Normal, standard_normals};

mod schema;

pub use schema::{Within, schema_within};

/// Coordinates of objects, goals and the workspace, in the frame of the arm's base: the longest arms reach 3 to 4 m.
pub const PLACE_M: Limits = Limits::new(-5.0, 5.0, "m");

/// Rotation about the vertical: a full revolution in either direction.
pub const YAW_DEG: Limits = Limits::new(-360.0, 360.0, "deg");

/// A number as `0.3`, `{ uniform = [low, high] }` or `{ normal = [mean, standard_deviation] }`.
///
/// A normal draw is repeated until it falls within the field's physical limits (a truncated normal distribution).
///
/// ```
/// use underbrush_recording::Limits;
/// use underbrush_sim::range::Draw;
///
/// let mut random = underbrush_sim::seed::stream(1, "an example", 0, "heights");
/// const HEIGHT_M: Limits = Limits::new(0.05, 1.0, "m");
/// let height_m = Draw::Uniform(0.25, 0.40).draw(&mut random, HEIGHT_M)?;
/// assert!((0.25..=0.40).contains(&height_m));
/// // Outside its physical limits nothing is drawn.
/// assert!(Draw::Uniform(3.0, 4.0).draw(&mut random, HEIGHT_M).is_err());
/// # Ok::<(), underbrush_sim::range::DrawError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Draw {
    /// Always this value.
    Fixed(f64),
    /// Uniform between the two.
    Uniform(f64, f64),
    /// Normal with mean and standard deviation, truncated to the field's physical limits.
    Normal(f64, f64),
}

/// A range from which no value within the physical limits could be drawn.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{draw} gives no value from {low} to {high}")]
pub struct DrawError {
    /// The key of the range in its group of objects; empty outside of groups.
    pub name: &'static str,
    /// The range.
    pub draw: Draw,
    /// Smallest physical value.
    pub low: f64,
    /// Largest physical value.
    pub high: f64,
}

impl fmt::Display for Draw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Draw::Fixed(value) => write!(f, "{}", short(*value)),
            Draw::Uniform(low, high) => write!(f, "{{ uniform = [{}, {}] }}", short(*low), short(*high)),
            Draw::Normal(mean, spread) => write!(f, "{{ normal = [{}, {}] }}", short(*mean), short(*spread)),
        }
    }
}

/// A named range with the physical limits of its values.
pub struct Limited {
    /// Its key in the scene file.
    pub name: &'static str,
    /// The range.
    pub draw: Draw,
    /// Smallest and largest value that make physical sense.
    pub limits: Limits,
}

/// A number with its key and its limits.
pub(crate) type Number = (&'static str, f64, Limits);

/// Declares options that a file may set, each once: `key: type = default;`, or `key: type = default, limits;` for a number within
/// limits. Makes the struct, with the limits in its schema, its defaults, and the list of its numbers.
macro_rules! options {
    ($(#[$attribute:meta])* pub struct $options:ident {
        $($(#[$of_field:meta])* $name:ident: $type:ty = $default:expr $(, $limits:expr)?;)+
    }) => {
        $(#[$attribute])*
        pub struct $options {
            $(
                $(#[$of_field])*
                $(#[schemars(transform = $crate::range::Within($limits))])?
                pub $name: $type,
            )+
        }

        impl Default for $options {
            fn default() -> Self {
                $options { $($name: $default,)+ }
            }
        }

        impl $options {
            /// The numbers with their keys and limits.
            pub(crate) fn numbers(&self) -> Vec<$crate::range::Number> {
                vec![$($((stringify!($name), f64::from(self.$name), $limits),)?)+]
            }
        }
    };
}
pub(crate) use options;

/// Where the objects of one group may stand; the coordinates are those of their feet.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Placement {
    /// Coordinate x (forward), m, world frame; anywhere in the workspace if not given.
    #[schemars(transform = Within(PLACE_M))]
    pub x_m: Option<Draw>,
    /// Coordinate y (left), m, world frame; anywhere in the workspace if not given.
    #[schemars(transform = Within(PLACE_M))]
    pub y_m: Option<Draw>,
    /// Rotation about the vertical, degrees; any if not given.
    #[schemars(transform = Within(YAW_DEG))]
    pub yaw_deg: Option<Draw>,
}

/// A truncated normal draw is given up after this many attempts; the accepted share is then below about 0.5 %.
const DRAWS: usize = 1000;

impl Draw {
    /// The largest number that it is likely to give: of a normal distribution, two deviations above the mean.
    pub fn largest(&self) -> f64 {
        match *self {
            Draw::Fixed(value) => value,
            Draw::Uniform(_, high) => high,
            Draw::Normal(mean, deviation) => mean + 2.0 * deviation,
        }
    }

    /// Draws one value within `limits` (inclusive).
    ///
    /// # Errors
    /// When a fixed or uniform value lies outside the limits, or a normal one does so a thousand times in a row.
    pub fn draw(&self, random: &mut ChaCha8Rng, limits: Limits) -> Result<f64, DrawError> {
        let error = DrawError { name: "", draw: *self, low: limits.min, high: limits.max };
        let physical = |value: &f64| limits.hold(*value);
        match *self {
            Draw::Fixed(value) => Some(value).filter(physical).ok_or(error),
            Draw::Uniform(low, high) => {
                let uniform = Uniform::new_inclusive(low, high).map_err(|_| error.clone())?;
                Some(uniform.sample(random)).filter(physical).ok_or(error)
            }
            Draw::Normal(mean, deviation) => {
                let mut normal = || {
                    let mut pair = [[Normal::default(); 2]];
                    standard_normals(random, &mut pair);
                    mean + deviation * pair[0][0].value()
                };
                (0..DRAWS).map(|_| normal()).find(physical).ok_or(error)
            }
        }
    }

    /// What is wrong with this range for a field with these limits, if anything: `(found, allowed)`.
    pub fn fault(&self, limits: Limits) -> Option<(String, String)> {
        let Limits { min, max, .. } = limits;
        let within = |value: f64| value.is_finite() && limits.hold(value);
        let allowed = match *self {
            Draw::Uniform(low, high) if low > high => "the lower bound first".into(),
            // A wider distribution would be nearly uniform, and nearly all its draws would be rejected.
            Draw::Normal(_, deviation) if !(0.0..=max - min).contains(&deviation) => {
                format!("a standard deviation from 0 to {}", short(max - min))
            }
            Draw::Fixed(value) | Draw::Normal(value, _) if within(value) => return None,
            Draw::Uniform(low, high) if within(low) && within(high) => return None,
            _ => format!("values from {} to {}", short(min), short(max)),
        };
        Some((self.to_string(), allowed))
    }
}

impl<'de> Deserialize<'de> for Draw {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct DrawVisitor;
        impl<'de> Visitor<'de> for DrawVisitor {
            type Value = Draw;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number, { uniform = [low, high] } or { normal = [mean, standard_deviation] }")
            }
            fn visit_f64<E: Error>(self, value: f64) -> Result<Draw, E> {
                Ok(Draw::Fixed(value))
            }
            fn visit_i64<E: Error>(self, value: i64) -> Result<Draw, E> {
                Ok(Draw::Fixed(value as f64))
            }
            fn visit_u64<E: Error>(self, value: u64) -> Result<Draw, E> {
                Ok(Draw::Fixed(value as f64))
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Draw, A::Error> {
                let key: String = map.next_key()?.ok_or_else(|| A::Error::custom("an empty range"))?;
                let [first, second]: [f64; 2] = map.next_value()?;
                if let Some(extra) = map.next_key::<String>()? {
                    return Err(A::Error::custom(format!("`{extra}` beside `{key}`: a range has one key")));
                }
                match key.as_str() {
                    "uniform" => Ok(Draw::Uniform(first, second)),
                    "normal" => Ok(Draw::Normal(first, second)),
                    _ => Err(A::Error::unknown_field(&key, &["uniform", "normal"])),
                }
            }
        }
        deserializer.deserialize_any(DrawVisitor)
    }
}
