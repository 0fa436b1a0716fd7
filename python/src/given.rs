//! Arguments that several functions take, and Python objects read as the options of the libraries, which have the names and the
//! defaults.

use std::fmt;
use std::path::Path;

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyInt};
use serde::de::value::{MapAccessDeserializer, SeqDeserializer};
use serde::de::{
    DeserializeOwned, DeserializeSeed, Deserializer, Error, Expected, IntoDeserializer, MapAccess, Unexpected, Visitor,
};
use serde::forward_to_deserialize_any;
use underbrush_classifier::trial::{TrialOptions, Unit};
use underbrush_classifier::{Decision, FeatureSet, Rule, Scores};
use underbrush_recording::disk::{check_free, write_file};

use crate::Failure;
use crate::argument::Argument;

/// Features from a list of names, or from one text in which commas or plus signs separate the names.
///
/// # Errors
/// `Fault::Usage` for an unknown or repeated feature.
pub fn features(value: Option<&Bound<'_, PyAny>>) -> Result<Option<FeatureSet>, Failure> {
    let Some(value) = value else { return Ok(None) };
    if let Ok(text) = value.extract::<String>() {
        return Ok(Some(text.parse()?));
    }
    Ok(Some(FeatureSet::from_names(&Vec::<String>::of("features", value)?)?))
}

/// How trials are cut.
///
/// # Errors
/// `Fault::Input` for an unknown name, and for `wrap` where it has no effect.
pub fn cutting(options: Option<&Bound<'_, PyDict>>) -> Result<TrialOptions, Failure> {
    let options: TrialOptions = self::options(options)?;
    if options.wrap.is_some() && options.by == Unit::Taxel {
        return Err(Failure::argument("wrap", "given with by=\"taxel\"", "only for by=\"component\"", "leave it out"));
    }
    Ok(options)
}

/// How scores become verdicts: `argmax`, `paper`, a margin in nats below which a verdict is uncertain, or a pair of
/// them (uncertain below the first, a category above the second, an outlier in between). `None` is the model's own
/// rule.
///
/// # Errors
/// `Fault::Input` for anything else, and for thresholds that do not apply to the scores.
pub fn decision(value: Option<&Bound<'_, PyAny>>, scores: &Scores<'_>) -> Result<Decision, Failure> {
    let Some(value) = value else { return Ok(scores.decision(None)?) };
    let rule = match value.extract::<String>().as_deref() {
        Ok("argmax") => Rule::Argmax,
        Ok("paper") => scores.paper()?,
        _ => {
            if let Ok(margin) = f64::of("decision", value) {
                Rule::UncertainBelow { margin }
            } else if let Some(&[uncertain_below, category_above]) = Vec::<f64>::of("decision", value).ok().as_deref() {
                Rule::OutlierBand { uncertain_below, category_above }
            } else {
                let allowed = "\"argmax\", \"paper\", a margin in nats, or a pair (uncertain below, category above)";
                return Err(Failure::argument("decision", value.to_string(), allowed, "choose one of them"));
            }
        }
    };
    Ok(scores.decision(Some(rule))?)
}

/// Writes the text of a file. Only with `force` is a file overwritten.
pub fn save(path: &Path, force: bool, text: &str) -> Result<(), Failure> {
    check_free(path, force)?;
    Ok(write_file(path, text.as_bytes())?)
}

/// Options from the arguments of a call by name. `None` stands for the default.
///
/// # Errors
/// A `TypeError` for an unknown name or an object that no option can be, `Fault::Input` for a value that is not allowed.
pub fn options<T: DeserializeOwned>(arguments: Option<&Bound<'_, PyDict>>) -> Result<T, Failure> {
    let given: Vec<_> = arguments.into_iter().flatten().filter(|(_, value)| !value.is_none()).collect();
    T::deserialize(MapAccessDeserializer::new(Entries::new(given, 0))).map_err(Failure::from)
}

/// The value of an argument with this name.
///
/// # Errors
/// `Fault::Input` with the names that exist.
pub fn named<T: DeserializeOwned>(argument: &str, name: &str) -> Result<T, Failure> {
    T::deserialize(name.into_deserializer()).map_err(|refused: Refused| refused.within(argument).into())
}

/// A dictionary as a type of the libraries. Errors as for [`options`].
pub fn dictionary<T: DeserializeOwned>(dict: &Bound<'_, PyDict>) -> Result<T, Refused> {
    T::deserialize(Given { object: dict.clone().into_any(), depth: 0 })
}

/// Why an object is refused.
#[derive(Debug)]
pub enum Refused {
    /// No option can be it.
    Type(String),
    /// The value of the entry with this name is not allowed. If the name is empty, there is no such entry.
    Value { entry: String, found: String, allowed: String },
}

impl Refused {
    fn value(found: impl fmt::Display, allowed: impl fmt::Display) -> Self {
        Refused::Value { entry: String::new(), found: found.to_string(), allowed: allowed.to_string() }
    }

    /// The same in the entry with this name.
    fn within(self, name: &str) -> Self {
        match self {
            Refused::Type(text) => Refused::Type(format!("{name}: {text}")),
            Refused::Value { entry, found, allowed } => {
                let entry = if entry.is_empty() { name.to_owned() } else { format!("{name}.{entry}") };
                Refused::Value { entry, found, allowed }
            }
        }
    }
}

impl fmt::Display for Refused {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refused::Type(text) => f.write_str(text),
            Refused::Value { entry, found, allowed } => write!(f, "{entry}: found {found}; allowed: {allowed}"),
        }
    }
}

impl std::error::Error for Refused {}

impl Error for Refused {
    fn custom<T: fmt::Display>(text: T) -> Self {
        Refused::Type(text.to_string())
    }

    fn invalid_type(found: Unexpected<'_>, allowed: &dyn Expected) -> Self {
        Refused::invalid_value(found, allowed)
    }

    fn invalid_value(found: Unexpected<'_>, allowed: &dyn Expected) -> Self {
        // serde names Rust's types.
        match allowed.to_string().as_str() {
            "usize" | "u64" | "u32" => Refused::value(found, "a whole number from 0"),
            "f64" => Refused::value(found, "a number"),
            allowed if allowed.starts_with("struct ") => Refused::value(found, "a dictionary"),
            allowed => Refused::value(found, allowed),
        }
    }

    fn unknown_variant(found: &str, allowed: &'static [&'static str]) -> Self {
        Refused::value(format!("{found:?}"), allowed.join(", "))
    }

    fn unknown_field(found: &str, allowed: &'static [&'static str]) -> Self {
        Refused::value(found, allowed.join(", "))
    }
}

impl From<Refused> for Failure {
    fn from(refused: Refused) -> Self {
        match refused {
            Refused::Type(text) => PyTypeError::new_err(text).into(),
            Refused::Value { entry, found, .. } if entry.is_empty() => {
                PyTypeError::new_err(format!("got an unexpected keyword argument '{found}'")).into()
            }
            Refused::Value { entry, found, allowed } => Failure::argument(entry, found, allowed, "change it"),
        }
    }
}

/// Dictionaries and lists within each other, of which options have a few. One that holds itself has no end.
const MOST_NESTED: usize = 16;

/// A Python object. Numbers may be those of NumPy.
struct Given<'py> {
    object: Bound<'py, PyAny>,
    /// In how many dictionaries and lists it is.
    depth: usize,
}

impl<'py> IntoDeserializer<'_, Refused> for Given<'py> {
    type Deserializer = Given<'py>;

    fn into_deserializer(self) -> Given<'py> {
        self
    }
}

impl<'de> Deserializer<'de> for Given<'_> {
    type Error = Refused;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        let Given { object, depth } = self;
        if depth > MOST_NESTED {
            Err(Refused::Type(format!("found more than {MOST_NESTED} dictionaries and lists within each other")))
        } else if object.is_none() {
            visitor.visit_unit()
        } else if let Ok(dict) = object.cast::<PyDict>() {
            visitor.visit_map(Entries::new(dict.iter().collect(), depth))
        } else if let Ok(text) = object.extract() {
            visitor.visit_string(text)
        } else if let Ok(flag) = object.extract() {
            // Truth values come first, because they are also numbers in Python.
            visitor.visit_bool(flag)
        } else if let Ok(number) = object.extract() {
            visitor.visit_i64(number)
        } else if let Ok(number) = object.extract() {
            visitor.visit_u64(number)
        } else if object.is_instance_of::<PyInt>() {
            // Python would round it to a floating-point number.
            Err(Refused::value(object, "a whole number of at most 64 bits"))
        } else if let Ok(number) = object.extract() {
            visitor.visit_f64(number)
        } else if let Ok(items) = object.extract::<Vec<Bound<'_, PyAny>>>() {
            let within = |object| Given { object, depth: depth + 1 };
            visitor.visit_seq(SeqDeserializer::new(items.into_iter().map(within)))
        } else {
            Err(Refused::Type(format!("found {object}")))
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Refused> {
        if self.object.is_none() { visitor.visit_none() } else { visitor.visit_some(self) }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        names: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Refused> {
        let name: String = self.object.extract().map_err(|_| Refused::value(&self.object, names.join(", ")))?;
        visitor.visit_enum(name.into_deserializer())
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf unit unit_struct newtype_struct
        seq tuple tuple_struct map struct identifier ignored_any
    }
}

/// The entries of a dictionary. Errors name the entry.
struct Entries<'py> {
    left: std::vec::IntoIter<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    value: Option<(String, Bound<'py, PyAny>)>,
    /// In how many dictionaries and lists the dictionary is.
    depth: usize,
}

impl<'py> Entries<'py> {
    fn new(all: Vec<(Bound<'py, PyAny>, Bound<'py, PyAny>)>, depth: usize) -> Self {
        Entries { left: all.into_iter(), value: None, depth }
    }
}

impl<'de> MapAccess<'de> for Entries<'_> {
    type Error = Refused;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Refused> {
        let Some((key, value)) = self.left.next() else { return Ok(None) };
        let name: String = key.extract().map_err(|_| Refused::Type(format!("the key {key}")))?;
        self.value = Some((name.clone(), value));
        seed.deserialize(name.into_deserializer()).map(Some)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Refused> {
        let (name, object) = self.value.take().ok_or_else(|| Refused::custom("a value without a key"))?;
        let given = Given { object, depth: self.depth + 1 };
        seed.deserialize(given).map_err(|refused| refused.within(&name))
    }
}
