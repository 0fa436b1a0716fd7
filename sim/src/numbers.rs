//! Options that a file may set. Each is declared once, with its default and, if it is a number, its limits.

use schemars::Schema;
use underbrush_recording::Limits;

/// A number with its key and its limits.
pub(crate) type Number = (&'static str, f64, Limits);

/// Declares options: `key: type = default;`, or `key: type = default, limits;` for a number within limits. Makes the struct,
/// its defaults, and the list of its numbers.
macro_rules! options {
    ($(#[$attribute:meta])* pub struct $options:ident {
        $($(#[$of_field:meta])* $name:ident: $type:ty = $default:expr $(, $limits:expr)?;)+
    }) => {
        $(#[$attribute])*
        pub struct $options {
            $($(#[$of_field])* pub $name: $type,)+
        }

        impl Default for $options {
            fn default() -> Self {
                $options { $($name: $default,)+ }
            }
        }

        impl $options {
            /// The numbers with their keys and limits.
            pub(crate) fn numbers(&self) -> Vec<$crate::numbers::Number> {
                vec![$($((stringify!($name), f64::from(self.$name), $limits),)?)+]
            }
        }
    };
}
pub(crate) use options;

/// Puts the limits of numbers into the schema of their struct. A value that switches an effect off is within the range.
pub(crate) fn with_limits(numbers: Vec<Number>) -> impl FnMut(&mut Schema) {
    move |schema| {
        let Some(properties) = schema.get_mut("properties") else { return };
        for (key, _, Limits { min, max, off, .. }) in &numbers {
            properties[*key]["minimum"] = off.map_or(*min, |off| off.min(*min)).into();
            if off.is_none_or(f64::is_finite) {
                properties[*key]["maximum"] = (*max).into();
            }
        }
    }
}
