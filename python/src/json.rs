//! Results as plain Python objects: dictionaries, lists, numbers and texts, as `--json` prints them.

use pyo3::PyTypeInfo;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use underbrush_recording::Fault;

use crate::{Answer, Failure};

/// A result as Python objects. Numbers that are not finite become `None`, as in JSON.
pub fn to_python<'py>(py: Python<'py>, result: &impl Serialize) -> Answer<'py> {
    Ok(object(py, &value(result)?)?)
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
    let text = serde_json::to_string(value).map_err(Failure::run)?;
    Ok((py.get_type::<C>().getattr("_from_json")?, (text,)))
}

/// A value from the JSON in a pickle.
pub fn unpickled<T: DeserializeOwned>(json: &[u8]) -> Result<T, Failure> {
    serde_json::from_slice(json).map_err(|error| Fault::Usage(error.to_string()).into())
}

fn object<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Null => py.None().into_bound(py),
        Value::Bool(flag) => flag.into_pyobject(py)?.to_owned().into_any(),
        Value::String(text) => text.into_pyobject(py)?.into_any(),
        Value::Number(number) => match (number.as_u64(), number.as_i64()) {
            (Some(whole), _) => whole.into_pyobject(py)?.into_any(),
            (None, Some(whole)) => whole.into_pyobject(py)?.into_any(),
            (None, None) => number.as_f64().unwrap_or(f64::NAN).into_pyobject(py)?.into_any(),
        },
        Value::Array(items) => {
            let items: PyResult<Vec<_>> = items.iter().map(|item| object(py, item)).collect();
            PyList::new(py, items?)?.into_any()
        }
        Value::Object(entries) => {
            let dict = PyDict::new(py);
            entries.iter().try_for_each(|(key, entry)| dict.set_item(key, object(py, entry)?))?;
            dict.into_any()
        }
    })
}
