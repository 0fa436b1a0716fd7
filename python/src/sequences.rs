//! Makes trials from sequences of features.

use pyo3::prelude::*;
use underbrush_classifier::feature::FeatureSet;
use underbrush_recording::{Category, Region, Sample, Trial, limits};

use crate::{Failure, array};

/// One sample of the sequence with this name.
///
/// # Errors
/// `Fault::Input` for an area that is no number of taxels.
fn sample(name: &str, set: &FeatureSet, numbers: &[f64], place: usize) -> Result<Sample, Failure> {
    let mut sample =
        Sample { time_s: place as f64 * underbrush_recording::FRAME_PERIOD_S, force_n: 0.0, ..Sample::default() };
    let mut region = Region { taxels: 1, largest_force_n: 0.0, force_sum_n: 0.0 };
    for (feature, number) in set.iter().zip(numbers) {
        match feature.column {
            "force_n" => sample.force_n = *number,
            "motion_m" => sample.motion_m = Some(*number),
            "region_taxels" if number.fract() != 0.0 || !limits::REGION_TAXELS.hold(*number) => {
                let found = format!("{number} for {} in sample {place}", feature.name);
                let allowed = format!("whole numbers, {}", limits::REGION_TAXELS);
                return Err(Failure::argument(name, found, allowed, "give numbers of taxels"));
            }
            "region_taxels" => region.taxels = *number as u32,
            "region_largest_force_n" => region.largest_force_n = *number,
            "region_force_sum_n" => region.force_sum_n = *number,
            column => sample.channels.push(column, *number),
        }
    }
    if set.of_region().next().is_some() {
        sample.region = Some(region);
    }
    Ok(sample)
}

/// A category that a table may hold.
///
/// # Errors
/// `Fault::Input` for any other text.
pub fn checked(category: Option<String>) -> Result<Option<String>, Failure> {
    match category.as_deref().and_then(|name| Some((name, Category::name_fault(name)?))) {
        Some((name, allowed)) => Err(Failure::argument("categories", format!("{name:?}"), allowed, "rename it")),
        None => Ok(category),
    }
}

/// Trials from sequences of features, one array for each. Their times are those of samples at 100 Hz.
///
/// # Errors
/// `Fault::Input` for a sequence of the wrong shape, an empty one, or one with NaN.
pub fn of_sequences(
    sequences: &[Bound<'_, PyAny>],
    set: &FeatureSet,
    categories: Option<Vec<Option<String>>>,
    groups: Option<Vec<u64>>,
) -> Result<Vec<Trial>, Failure> {
    let count = sequences.len();
    Failure::unless_one_each("categories", categories.as_ref().map_or(count, Vec::len), count, "sequence")?;
    Failure::unless_one_each("groups", groups.as_ref().map_or(count, Vec::len), count, "sequence")?;
    let width = set.dimension();
    let one = |(index, value): (usize, &Bound<'_, PyAny>)| {
        let name = format!("sequence {index}");
        let is_flat = width == 1 && value.getattr("ndim").and_then(|ndim| ndim.extract::<usize>()).unwrap_or(1) == 1;
        let shape: &[Option<usize>] = if is_flat { &[None] } else { &[None, Some(width)] };
        let numbers = array::finite(value, &name, shape)?;
        if numbers.is_empty() {
            return Err(Failure::argument(name, "no samples", "at least one sample", "leave it out"));
        }
        let samples = numbers.chunks_exact(width).enumerate().map(|(place, row)| sample(&name, set, row, place));
        let category = categories.as_ref().and_then(|categories| categories[index].clone());
        Ok(Trial {
            trial: index as u64,
            category: checked(category)?,
            reach: groups.as_ref().map(|groups| groups[index]),
            samples: samples.collect::<Result<_, Failure>>()?,
            ..Trial::default()
        })
    };
    sequences.iter().enumerate().map(one).collect()
}
