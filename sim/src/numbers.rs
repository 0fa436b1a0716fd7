//! Options that a file may set. Each is declared once, with its default and, if it is a number, its limits.

use underbrush_recording::Limits;

/// A number with its key and its limits.
pub(crate) type Number = (&'static str, f64, Limits);

/// Declares options: `key: type = default;`, or `key: type = default, limits;` for a number within limits. Makes the struct,
/// with the limits in its schema, its defaults, and the list of its numbers.
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
            pub(crate) fn numbers(&self) -> Vec<$crate::numbers::Number> {
                vec![$($((stringify!($name), f64::from(self.$name), $limits),)?)+]
            }
        }
    };
}
pub(crate) use options;
