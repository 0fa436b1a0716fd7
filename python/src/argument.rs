//! Numbers and lists as arguments. To Python, truth values are numbers, too, and its errors about numbers that are too large and
//! about texts in place of lists name neither the argument nor what is allowed.

use std::path::PathBuf;

use pyo3::prelude::*;

use crate::Failure;

/// What an argument can be read as.
pub trait Argument: Sized {
    /// The value of the argument with this name.
    ///
    /// # Errors
    /// `Fault::Input` with what is allowed.
    fn of(name: &str, value: &Bound<'_, PyAny>) -> Result<Self, Failure>;
}

/// What is allowed where a count, an index or a seed is expected.
const WHOLE: &str = "a whole number from 0 to 18446744073709551615";

macro_rules! of_one_value {
    ($($kind:ty => $allowed:expr),*) => {
        $(impl Argument for $kind {
            fn of(name: &str, value: &Bound<'_, PyAny>) -> Result<Self, Failure> {
                match value.extract::<$kind>() {
                    // NumPy has truth values of its own.
                    Ok(own) if value.extract::<bool>().is_err() => Ok(own),
                    _ => Err(Failure::argument(name, value.to_string(), $allowed, "change it")),
                }
            }
        })*
    };
}
of_one_value!(f64 => "a number", u64 => WHOLE, usize => WHOLE, String => "a text", PathBuf => "a path");

impl<T: Argument> Argument for Option<T> {
    fn of(name: &str, value: &Bound<'_, PyAny>) -> Result<Self, Failure> {
        if value.is_none() { Ok(None) } else { T::of(name, value).map(Some) }
    }
}

impl<T: Argument> Argument for Vec<T> {
    fn of(name: &str, value: &Bound<'_, PyAny>) -> Result<Self, Failure> {
        let items = value.extract::<Vec<Bound<'_, PyAny>>>();
        let items = items.map_err(|_| Failure::argument(name, value.to_string(), "a list", "give a list"))?;
        items.iter().map(|item| T::of(name, item)).collect()
    }
}

/// Functions that read arguments, for `from_py_with`, which does not tell them the names.
macro_rules! arguments {
    ($($name:ident),* $(,)?) => {
        $(
            /// The argument of this name.
            pub fn $name<T: Argument>(value: &Bound<'_, PyAny>) -> PyResult<T> {
                Ok(T::of(stringify!($name), value)?)
            }
        )*
    };
}
arguments!(
    campaigns,
    counts,
    false_positive_rate,
    folds,
    frame,
    frames,
    groups,
    height,
    index,
    jobs,
    limit_wrong,
    min_samples,
    num_envs,
    only,
    outlier_prior,
    parts,
    reaches,
    samples,
    seed,
    seeds,
    threshold_n,
    time_s,
    tolerance_scale,
    vertical_fov_deg,
    width,
);
