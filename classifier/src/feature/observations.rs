//! Matrices of observations.

use super::error::FeatureError;

/// One sequence of observations: a row-major matrix of samples × dimension, finite and never empty.
///
/// ```
/// use underbrush_classifier::feature::Observations;
///
/// // Three samples of force and motion.
/// let observations = Observations::new(2, vec![0.1, 0.0, 0.3, 0.001, 0.4, 0.002])?;
/// assert_eq!((observations.sample_count(), observations.sample(1)), (3, &[0.3, 0.001][..]));
/// # Ok::<(), underbrush_classifier::feature::FeatureError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Observations {
    dimension: usize,
    values: Vec<f64>,
}

impl Observations {
    /// Observations from a row-major matrix with `dimension` numbers per sample.
    ///
    /// # Errors
    /// [`FeatureError::BadMatrix`] if it is empty, ragged or not finite.
    pub fn new(dimension: usize, values: Vec<f64>) -> Result<Self, FeatureError> {
        let found = if dimension == 0 || values.is_empty() || !values.len().is_multiple_of(dimension) {
            format!("{} numbers", values.len())
        } else if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            format!("the number {value}")
        } else {
            return Ok(Observations { dimension, values });
        };
        Err(FeatureError::BadMatrix { found, dimension })
    }

    /// Number of features.
    pub fn dimension(&self) -> usize {
        self.dimension
    }

    /// Number of samples, at least 1.
    pub fn sample_count(&self) -> usize {
        self.values.len() / self.dimension
    }

    /// The sample with this index.
    ///
    /// # Panics
    /// Where `index` is not below [`Observations::sample_count`].
    pub fn sample(&self, index: usize) -> &[f64] {
        &self.values[index * self.dimension..(index + 1) * self.dimension]
    }

    /// The samples in time order.
    pub fn samples(&self) -> std::slice::ChunksExact<'_, f64> {
        self.values.chunks_exact(self.dimension)
    }

    /// The samples in time order, to be changed in place.
    pub(super) fn samples_mut(&mut self) -> std::slice::ChunksExactMut<'_, f64> {
        self.values.chunks_exact_mut(self.dimension)
    }
}
