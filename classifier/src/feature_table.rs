//! Lists of computed features that say everything about a feature in one place.

/// A function that computes features, from a list with an entry for each: its name, what else is known of it, and how it is
/// computed. The names and what else is known become constants beside the function.
macro_rules! features {
    (
        $(#[$column_doc:meta])* const $column:ident: $known:ty;
        $(#[$doc:meta])* $vis:vis fn values(&$this:ident $(, $argument:ident: $type:ty)* $(,)?) {
            $(let $local:pat = $first:expr;)*
            $(($name:literal, $of_name:expr, $value:expr),)*
        }
    ) => {
        /// Number of features.
        pub const COUNT: usize = [$($name),*].len();

        /// Names of the features, in order.
        pub const NAMES: [&'static str; Self::COUNT] = [$($name),*];

        $(#[$column_doc])*
        pub const $column: [$known; Self::COUNT] = [$($of_name),*];

        $(#[$doc])*
        $vis fn values(&$this $(, $argument: $type)*) -> [f64; Self::COUNT] {
            $(let $local = $first;)*
            [$($value),*]
        }
    };
}
pub(crate) use features;
