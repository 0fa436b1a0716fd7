//! Networks of others: a model in the ONNX format, trained with scikit-learn or PyTorch, as a classifier of contacts.
//!
//! The file says in its metadata what it expects:
//!
//! | key | value |
//! |---|---|
//! | `underbrush.features` | names of the features of a sample, separated by commas, as in `train --features` |
//! | `underbrush.window` | number of samples |
//! | `underbrush.categories` | names in alphabetical order, separated by commas |
//! | `underbrush.output` | `probabilities` (if left out) or `log-odds` |
//!
//! The input is one tensor of 32-bit floats of shape (1, window × features), sample by sample, or (1, window, features). A contact
//! shorter than the window, or not yet as long, is padded with its last sample, and samples after the window are ignored. The
//! first output of 32-bit floats with one value per category is the answer.

use std::path::Path;
use std::sync::Arc;

use serde_json::Value;
use tract_onnx::pb::ModelProto;
use tract_onnx::prelude::*;
use tract_onnx::tract_hir::infer::Factoid;
use underbrush_recording::{InputError, Sample};

use crate::estimator::{Classifier, ContactScorer, Independent, OnlineScorer};
use crate::feature::{FeatureError, FeatureSet, SampleFault};

/// Probabilities below this count as this, so that no category is impossible.
const SMALLEST_PROBABILITY: f64 = 1e-9;
/// Largest window, samples. Choice: ten seconds at 100 Hz.
const LARGEST_WINDOW: usize = 1000;

/// Reads and checks a model.
///
/// # Errors
/// [`InputError`] if the file is no ONNX model, lacks a key, uses an operator that is not known, or has inputs and outputs of
/// other shapes.
pub fn load(path: &Path) -> Result<Box<dyn Classifier>, InputError> {
    let fail = |field: &str, found: String, allowed: &str, remedy: &str| {
        InputError::new(path, field.to_owned(), found, allowed.to_owned(), remedy.to_owned())
    };
    let not_onnx = |error: TractError| {
        let allowed = "an ONNX model with operators that tract knows";
        fail("file", format!("{error:#}"), allowed, "export the model again")
    };
    let onnx = tract_onnx::onnx();
    let proto = onnx.proto_model_for_path(path).map_err(not_onnx)?;
    let expected = Expected::read(path, &proto)?;
    let model = onnx.model_for_proto_model(&proto).map_err(not_onnx)?;
    let rank = model.input_fact(0).ok().and_then(|fact| fact.shape.rank().concretize());
    let (window, features) = (expected.window, expected.features.dimension());
    let shape = match rank {
        Some(3) => vec![1, window, features],
        _ => vec![1, window * features],
    };
    let shaped = |model: InferenceModel| {
        let model = model.with_input_fact(0, f32::fact(&shape).into())?;
        model.into_optimized()?.into_runnable()
    };
    let network = Network {
        plan: shaped(model).map_err(|error| {
            let found = format!("{error:#}");
            let allowed = format!("an input of shape {shape:?}, as the metadata say");
            fail(
                "input",
                found,
                &allowed,
                "export the model for these shapes and with standard operators (skl2onnx: black_op={'Scaler'}), or correct its \
                 metadata",
            )
        })?,
        shape,
        output: 0,
    };
    let found = network.find_output(expected.categories.len()).map_err(|error| {
        let allowed = format!(
            "an output of {} 32-bit floats, one per category",
            expected.categories.len()
        );
        let remedy = "export probabilities as a plain tensor (skl2onnx: options={'zipmap': False})";
        fail("output", format!("{error:#}"), &allowed, remedy)
    })?;
    let network = Network {
        output: found,
        ..network
    };
    Ok(Box::new(OnnxClassifier(Arc::new((expected, network)))))
}

/// What the metadata say.
#[derive(Debug)]
struct Expected {
    features: FeatureSet,
    window: usize,
    categories: Vec<String>,
    is_probability: bool,
}

impl Expected {
    fn read(path: &Path, proto: &ModelProto) -> Result<Self, InputError> {
        let get = |key: &str| {
            proto
                .metadata_props
                .iter()
                .find(|own| own.key == key)
                .map(|own| own.value.as_str())
        };
        let fail = |key: &str, found: &str, allowed: &str| {
            let remedy = "set the model's metadata_props when you export it";
            InputError::new(
                path,
                format!("metadata {key}"),
                found.to_owned(),
                allowed.to_owned(),
                remedy.to_owned(),
            )
        };
        let need = |key: &str, allowed: &str| get(key).ok_or_else(|| fail(key, "nothing", allowed));
        let features = need("underbrush.features", "names of features, separated by commas")?;
        let window = need("underbrush.window", "a number of samples")?;
        let categories = need(
            "underbrush.categories",
            "names in alphabetical order, separated by commas",
        )?;
        let categories: Vec<String> = categories.split(',').map(|name| name.trim().to_owned()).collect();
        if categories.len() < 2 || !categories.is_sorted_by(|a, b| a < b) || categories[0].is_empty() {
            let allowed = "two or more names in alphabetical order, none twice";
            return Err(fail("underbrush.categories", &categories.join(","), allowed));
        }
        Ok(Expected {
            features: features
                .parse()
                .map_err(|error: FeatureError| fail("underbrush.features", features, &error.to_string()))?,
            window: match window.trim().parse() {
                Ok(samples) if (1..=LARGEST_WINDOW).contains(&samples) => samples,
                _ => return Err(fail("underbrush.window", window, "a whole number from 1 to 1000")),
            },
            categories,
            is_probability: match get("underbrush.output") {
                None | Some("probabilities") => true,
                Some("log-odds") => false,
                Some(other) => return Err(fail("underbrush.output", other, "probabilities or log-odds")),
            },
        })
    }
}

/// The network, ready to run.
struct Network {
    plan: Arc<TypedRunnableModel>,
    shape: Vec<usize>,
    /// Which of the outputs is the answer.
    output: usize,
}

impl Network {
    fn run(&self, input: &[f32]) -> TractResult<TVec<TValue>> {
        self.plan.run(tvec!(Tensor::from_shape(&self.shape, input)?.into()))
    }

    /// The first output of as many floats as categories.
    fn find_output(&self, categories: usize) -> TractResult<usize> {
        let outputs = self.run(&vec![0.0; self.shape.iter().product()])?;
        let fits = |output: &TValue| output.datum_type() == f32::datum_type() && output.len() == categories;
        let shapes: Vec<String> = outputs.iter().map(|output| format!("{output:?}")).collect();
        let found = outputs.iter().position(fits);
        found.ok_or_else(|| TractError::msg(format!("outputs {}", shapes.join(", "))))
    }
}

struct OnnxClassifier(Arc<(Expected, Network)>);

impl std::fmt::Debug for OnnxClassifier {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_tuple("OnnxClassifier").field(&self.0.0).finish()
    }
}

impl Classifier for OnnxClassifier {
    fn name(&self) -> &'static str {
        "onnx"
    }

    fn features(&self) -> FeatureSet {
        self.0.0.features
    }

    fn categories(&self) -> Vec<String> {
        self.0.0.categories.clone()
    }

    fn online_scorer(&self, contacts: usize) -> Box<dyn OnlineScorer> {
        let fresh = Contact {
            model: Arc::clone(&self.0),
            samples: Vec::new(),
        };
        Box::new(Independent::new(fresh, contacts))
    }

    /// An ONNX model is its own file; it has no entries in a file of this program.
    fn file_entries(&self) -> Vec<(&'static str, Value)> {
        Vec::new()
    }
}

/// One contact so far.
#[derive(Clone)]
struct Contact {
    model: Arc<(Expected, Network)>,
    /// The samples of the window so far, one after the other.
    samples: Vec<f64>,
}

impl std::fmt::Debug for Contact {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("Contact")
            .field("samples", &self.samples)
            .finish()
    }
}

impl ContactScorer for Contact {
    fn push(&mut self, sample: &Sample) -> Result<bool, SampleFault> {
        let Expected { features, window, .. } = &self.model.0;
        let (length, dimension) = (self.samples.len(), features.dimension());
        if length == window * dimension {
            return Ok(false);
        }
        self.samples.resize(length + dimension, 0.0);
        let read = features.read(sample, &mut self.samples[length..]);
        if read.is_err() {
            self.samples.truncate(length);
        }
        read.map(|()| true)
    }

    fn scores(&self, scores: &mut [f64]) {
        let (expected, network) = &*self.model;
        let dimension = expected.features.dimension();
        let mut input: Vec<f32> = self.samples.iter().map(|value| *value as f32).collect();
        while !input.is_empty() && input.len() < expected.window * dimension {
            input.extend_from_within(input.len() - dimension..);
        }
        // The shapes were tried when the model was loaded. A network that fails all the same says nothing.
        scores.fill(0.0);
        let Ok(outputs) = network.run(&input) else { return };
        let Ok(values) = outputs[network.output].to_plain_array_view::<f32>() else {
            return;
        };
        for (score, value) in scores.iter_mut().zip(values.iter()) {
            let value = f64::from(*value);
            *score = if expected.is_probability {
                value.max(SMALLEST_PROBABILITY).ln()
            } else {
                value
            };
        }
    }
}
