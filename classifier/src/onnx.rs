//! Networks trained elsewhere: a model in the ONNX format, from scikit-learn or PyTorch, as a classifier of contacts.
//!
//! The metadata of the file say what it expects:
//!
//! | key | value |
//! |---|---|
//! | `underbrush.features` | names of the features of a sample, separated by commas, as in `train --features` |
//! | `underbrush.window` | number of samples |
//! | `underbrush.categories` | names in alphabetical order, separated by commas |
//! | `underbrush.output` | `probabilities` (if left out) or `log-odds` |
//!
//! The input is one tensor of 32-bit floats of shape (1, window × features), sample by sample, or (1, window,
//! features). A contact shorter than the window, or not yet as long, is padded with its last sample, and samples after
//! the window are ignored. The first output of 32-bit floats with one value per category is the answer. An invalid
//! answer, such as NaN or probabilities that do not sum to 1, is an error.

use std::fmt::{self, Display};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rten::{ModelMetadata, RunOptions, ThreadPool, Value as Tensor, ValueView};
use serde_json::Value;
use underbrush_recording::{Category, InputError, JSON_BYTES, Sample, math, open_regular, stop::panic_text};

use crate::estimator::{Classifier, ContactScorer, Independent, OnlineScorer};
use crate::{FeatureError, FeatureSet, ModelError, SampleFault};

/// Smaller probabilities count as this, so that no category is impossible.
const SMALLEST_PROBABILITY: f64 = 1e-9;
/// How far probabilities and their sum may be off. Choice: far above the rounding of 32-bit floats, and far below what
/// matters.
const PROBABILITY_TOLERANCE: f64 = 1e-3;

/// Reads and checks a model.
///
/// # Errors
/// [`InputError`] if the file is not an ONNX model, lacks a key, uses an unknown operator, or has inputs or outputs of
/// other shapes.
pub fn load(path: &Path) -> Result<Box<dyn Classifier>, InputError> {
    let not_onnx = |found: String| {
        let remedy = "export the model again, with the probabilities as its only output and with standard operators, as \
                      examples/onnx/train.py does";
        InputError::new(path, "file", found, "an ONNX model of numbers, with operators that rten knows", remedy)
    };
    let length = open_regular(path, "an ONNX model", "check the path")?.metadata();
    let length = length.map_err(|error| not_onnx(error.to_string()))?.len();
    JSON_BYTES.check(path, "file", length)?;
    let model = guarded(|| rten::Model::load_file(path)).map_err(not_onnx)?;
    let expected = Expected::read(path, model.metadata())?;
    let (window, features) = (expected.window, expected.features.dimension());
    let shape = match model.input_shape(0).map_or(0, |shape| shape.len()) {
        3 => vec![1, window, features],
        _ => vec![1, window * features],
    };
    let pool = Arc::new(ThreadPool::with_num_threads(rayon::current_num_threads()));
    let network = Network { model, pool, shape, output: 0 };
    let zeros = vec![0.0; window * features];
    let outputs = network.run(&zeros).map_err(|found| {
        let allowed = format!("an input of shape {:?}, as the metadata say", network.shape);
        let remedy = "export the model for these shapes and with standard operators (skl2onnx: black_op={'Scaler'}), or correct \
                      its metadata";
        InputError::new(path, "input", found, allowed, remedy)
    })?;
    let categories = expected.categories.len();
    let output = outputs.iter().position(|output| numbers(output).is_some_and(|numbers| numbers.len() == categories));
    let output = output.ok_or_else(|| {
        let allowed = format!("an output of {categories} 32-bit floats, one per category");
        let remedy = "export probabilities as a plain tensor (skl2onnx: options={'zipmap': False})";
        InputError::new(path, "output", format!("{outputs:?}"), allowed, remedy)
    })?;
    let network = Network { output, ..network };
    Ok(Box::new(OnnxClassifier(Arc::new(Loaded { path: path.to_owned(), expected, network }))))
}

/// Runs a step of rten, and turns an error or a panic into text: bad input must never end the program.
fn guarded<T, E: Display>(step: impl FnOnce() -> Result<T, E>) -> Result<T, String> {
    match catch_unwind(AssertUnwindSafe(step)) {
        Ok(result) => result.map_err(|error| error.to_string()),
        Err(panic) => Err(panic_text(panic.as_ref()).unwrap_or("a failure that says nothing more").to_owned()),
    }
}

/// The values of an output, if it is a tensor of 32-bit floats.
fn numbers(output: &Tensor) -> Option<Vec<f32>> {
    output.as_tensor_view::<f32>().map(|view| view.iter().copied().collect())
}

/// The network, ready to run.
struct Network {
    model: rten::Model,
    /// As many threads as the program uses.
    pool: Arc<ThreadPool>,
    shape: Vec<usize>,
    /// Which of the outputs is the answer.
    output: usize,
}

impl Network {
    fn run(&self, input: &[f32]) -> Result<Vec<Tensor>, String> {
        let ids = self.model.input_ids();
        let [id] = ids else { return Err(format!("{} inputs in place of one", ids.len())) };
        let input = guarded(|| ValueView::from_shape(&self.shape, input))?;
        let options = RunOptions::default().with_thread_pool(Some(Arc::clone(&self.pool)));
        guarded(|| self.model.run(vec![(*id, input.into())], self.model.output_ids(), Some(options)))
    }
}

/// A model read from a file.
struct Loaded {
    path: PathBuf,
    expected: Expected,
    network: Network,
}

impl fmt::Debug for Loaded {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.expected, formatter)
    }
}

impl Loaded {
    /// Runs the network on the samples of a window and writes one number per category to `answer`.
    fn answer(&self, input: &[f32], answer: &mut [f64]) -> Result<(), InputError> {
        let count = answer.len();
        let outputs = self.network.run(input).map_err(|found| {
            let allowed = "a network that runs with any forces and motions";
            let remedy = "correct the network so that it runs with such numbers, and export it again";
            InputError::new(&self.path, "network", format!("a failure: {found}"), allowed, remedy)
        })?;
        let output = &outputs[self.network.output];
        let values = numbers(output).filter(|values| values.len() == count).ok_or_else(|| {
            let allowed = format!("{count} 32-bit floats, one per category, as when the file was read");
            let remedy = "export the network with an output whose shape does not depend on the input";
            InputError::new(&self.path, "output", format!("{output:?}"), allowed, remedy)
        })?;
        answer.iter_mut().zip(values).for_each(|(place, value)| *place = f64::from(value));
        if self.expected.is_probability {
            let is_probability = |value: &f64| (-PROBABILITY_TOLERANCE..=1.0 + PROBABILITY_TOLERANCE).contains(value);
            if !answer.iter().all(is_probability) || (answer.iter().sum::<f64>() - 1.0).abs() > PROBABILITY_TOLERANCE {
                let allowed =
                    format!("probabilities: numbers from 0 to 1 that sum to 1 within {PROBABILITY_TOLERANCE}");
                let remedy =
                    "export a network that ends in a softmax, or set its metadata underbrush.output to log-odds";
                return Err(InputError::new(&self.path, "output", format!("{answer:?}"), allowed, remedy));
            }
        } else if !answer.iter().all(|value| value.is_finite()) {
            let remedy = "correct the network, such as a division by zero or an overflow in it, and export it again";
            return Err(InputError::new(&self.path, "output", format!("{answer:?}"), "finite log-odds", remedy));
        }
        Ok(())
    }
}

#[derive(Debug)]
struct OnnxClassifier(Arc<Loaded>);

impl Classifier for OnnxClassifier {
    fn name(&self) -> &'static str {
        "onnx"
    }

    fn features(&self) -> FeatureSet {
        self.0.expected.features
    }

    fn categories(&self) -> Vec<String> {
        self.0.expected.categories.clone()
    }

    fn online_scorer(&self, contacts: usize) -> Box<dyn OnlineScorer> {
        let fresh = Contact { model: Arc::clone(&self.0), samples: Vec::new() };
        Box::new(Independent::new(fresh, contacts))
    }

    /// An ONNX model is its own file; it has no entries in a file of this program.
    fn file_entries(&self) -> Vec<(&'static str, Value)> {
        Vec::new()
    }
}

/// One contact so far.
#[derive(Clone, Debug)]
struct Contact {
    model: Arc<Loaded>,
    /// The samples of the window so far, one after the other.
    samples: Vec<f64>,
}

impl ContactScorer for Contact {
    fn push(&mut self, sample: &Sample) -> Result<bool, SampleFault> {
        let Expected { features, window, .. } = &self.model.expected;
        features.push_within(*window, &mut self.samples, sample)
    }

    fn scores(&self, scores: &mut [f64]) -> Result<(), ModelError> {
        let Expected { features, window, is_probability, .. } = &self.model.expected;
        let dimension = features.dimension();
        let mut input: Vec<f32> = self.samples.iter().map(|value| *value as f32).collect();
        while !input.is_empty() && input.len() < window * dimension {
            input.extend_from_within(input.len() - dimension..);
        }
        self.model.answer(&input, scores)?;
        if *is_probability {
            scores.iter_mut().for_each(|score| *score = math::ln(score.max(SMALLEST_PROBABILITY)));
        }
        Ok(())
    }
}

/// Largest window, samples. Choice: ten seconds at 100 Hz.
const LARGEST_WINDOW: usize = 1000;

/// What the metadata say.
#[derive(Debug)]
struct Expected {
    features: FeatureSet,
    window: usize,
    categories: Vec<String>,
    is_probability: bool,
}

impl Expected {
    fn read(path: &Path, metadata: &ModelMetadata) -> Result<Self, InputError> {
        let fail = |key: &str, found: &str, allowed: &str| {
            let remedy = "set the model's metadata_props when you export it";
            InputError::new(path, format!("metadata {key}"), found, allowed, remedy)
        };
        let need = |key: &str, allowed: &str| metadata.get(key).ok_or_else(|| fail(key, "nothing", allowed));
        let features = need("underbrush.features", "names of features, separated by commas")?;
        let window = need("underbrush.window", "a number of samples")?;
        let categories = need("underbrush.categories", "names in alphabetical order, separated by commas")?;
        let categories: Vec<String> = categories.split(',').map(|name| name.trim().to_owned()).collect();
        if categories.len() < 2 || !categories.is_sorted_by(|a, b| a < b) || categories[0].is_empty() {
            let allowed = "two or more names in alphabetical order, none twice";
            return Err(fail("underbrush.categories", &categories.join(","), allowed));
        }
        if let Some((name, allowed)) = categories.iter().find_map(|name| Some((name, Category::name_fault(name)?))) {
            return Err(fail("underbrush.categories", name, allowed));
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
            is_probability: match metadata.get("underbrush.output") {
                None | Some("probabilities") => true,
                Some("log-odds") => false,
                Some(other) => return Err(fail("underbrush.output", other, "probabilities or log-odds")),
            },
        })
    }
}
