//! Results as plain Python objects: dictionaries, lists, numbers and texts, as `--json` prints them.

use pyo3::PyTypeInfo;
use pyo3::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use underbrush_recording::{Fault, ObjectRecord};

use crate::{Answer, Failure};

/// A result as Python objects. Numbers that are not finite become `None`, as in JSON.
pub fn to_python<'py>(py: Python<'py>, result: &impl Serialize) -> Answer<'py> {
    // By way of a value, which widens numbers of single precision exactly; as text they would be rounded.
    Ok(py.import("json")?.call_method1("loads", (value(result)?.to_string(),))?)
}

/// Objects of the clutter as Python objects, each with the name of its category. Files also hold the codes of further categories.
pub fn objects<'py>(py: Python<'py>, objects: &[ObjectRecord]) -> Answer<'py> {
    let named = |object: &ObjectRecord| {
        let mut own = value(object)?;
        own["category"] = object.category.name().into();
        Ok(own)
    };
    to_python(py, &objects.iter().map(named).collect::<Result<Vec<_>, Failure>>()?)
}

/// A result as JSON, which can be sent to another thread.
pub fn value(result: &impl Serialize) -> Result<Value, Failure> {
    serde_json::to_value(result).map_err(Failure::run)
}

/// What a pickle of an object of the class `C` holds: a call of its `_from_json` with this value.
pub fn pickled<'py, C: PyTypeInfo>(
    py: Python<'py>,
    value: &impl Serialize,
) -> Result<(Bound<'py, PyAny>, (String,)), Failure> {
    Ok((py.get_type::<C>().getattr("_from_json")?, (serde_json::to_string(value).map_err(Failure::run)?,)))
}

/// A value from the JSON in a pickle.
pub fn unpickled<T: DeserializeOwned>(json: &[u8]) -> Result<T, Failure> {
    serde_json::from_slice(json).map_err(|error| Fault::Usage(error.to_string()).into())
}
