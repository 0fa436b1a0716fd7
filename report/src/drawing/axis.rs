//! Axes: positions of values, and ticks.

use underbrush_recording::math;

/// One axis of a chart.
///
/// ```
/// use underbrush_report::drawing::{Axis, Scale};
///
/// assert_eq!(Axis::names("verdict", ["leaf", "trunk"]).scale, Scale::Names(vec!["leaf".into(), "trunk".into()]));
/// assert_eq!(Axis::from_zero("force / N").scale, Scale::Linear { low: Some(0.0), high: None });
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// The quantity with its unit, such as `force / N`.
    pub label: String,
    /// How values are placed.
    pub scale: Scale,
}

/// How values are placed along an axis.
#[derive(Clone, Debug, PartialEq)]
pub enum Scale {
    /// Linear, over all data; extended to the ends that are given.
    Linear {
        /// A low end that is always shown.
        low: Option<f64>,
        /// A high end that is always shown.
        high: Option<f64>,
    },
    /// Logarithmic; values not above 0 are left out.
    Logarithmic,
    /// Names, at 0, 1, 2, …
    Names(Vec<String>),
}

impl Axis {
    /// A linear axis that shows at least these values.
    pub fn spanning(label: impl Into<String>, low: f64, high: f64) -> Self {
        Axis { label: label.into(), scale: Scale::Linear { low: Some(low), high: Some(high) } }
    }

    /// A linear axis that begins at 0.
    pub fn from_zero(label: impl Into<String>) -> Self {
        Axis { label: label.into(), scale: Scale::Linear { low: Some(0.0), high: None } }
    }

    /// A logarithmic axis.
    pub fn logarithmic(label: impl Into<String>) -> Self {
        Axis { label: label.into(), scale: Scale::Logarithmic }
    }

    /// An axis of names.
    pub fn names<T: Into<String>>(label: impl Into<String>, names: impl IntoIterator<Item = T>) -> Self {
        Axis { label: label.into(), scale: Scale::Names(names.into_iter().map(Into::into).collect()) }
    }
}

/// A scale fitted to data.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Fitted {
    low: f64,
    high: f64,
    /// The largest value of the data.
    max: f64,
    logarithmic: bool,
    /// Values of the ticks with their labels.
    pub(super) ticks: Vec<(f64, String)>,
}

impl Fitted {
    /// Fits a scale to the finite values, with about `steps` intervals between ticks.
    pub(super) fn new(scale: &Scale, values: impl Iterator<Item = f64>, steps: f64) -> Self {
        let logarithmic = *scale == Scale::Logarithmic;
        let usable = values.filter(|value| value.is_finite() && (!logarithmic || *value > 0.0));
        let (min, max) =
            usable.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), value| (min.min(value), max.max(value)));
        let (min, max) = if min > max { (1.0, 1.0) } else { (min, max) };
        let (low, high, max, ticks): (f64, f64, f64, Vec<(f64, String)>) = match scale {
            Scale::Names(names) => {
                let ticks = names.iter().enumerate().map(|(place, name)| (place as f64, name.clone()));
                (-0.5, (names.len().max(1) as f64) - 0.5, f64::INFINITY, ticks.collect())
            }
            Scale::Logarithmic => {
                let (low, high) = (math::log10(min).floor(), math::log10(max).ceil());
                let high = if high > low { high } else { low + 1.0 };
                let every = ((high - low) / steps).ceil().max(1.0) as usize;
                let exponents = (low as i32..=high as i32).step_by(every);
                let ticks = exponents.map(|exponent| (10_f64.powi(exponent), power_of_ten(exponent)));
                (low, high, f64::INFINITY, ticks.collect())
            }
            Scale::Linear { low, high } => {
                let low = low.map_or(min, |low| low.min(min));
                let high = high.map_or(max, |high| high.max(max));
                let width = if high > low { high - low } else { low.abs().max(1.0) };
                let step = round_step(width / steps);
                let (first, last) = ((low / step).floor(), ((low + width) / step - 1e-9).ceil());
                let decimals = (-math::log10(step).floor()).clamp(0.0, 9.0) as usize;
                let count = (last - first).clamp(1.0, 50.0) as usize;
                let values = (0..=count).map(|index| (first + index as f64) * step);
                let ticks = values.map(|value| (value, format!("{:.decimals$}", value + 0.0)));
                (first * step, last * step, low + width, ticks.collect())
            }
        };
        Fitted { low, high, max, logarithmic, ticks }
    }

    /// The same scale, but ending with the data instead of at the next tick.
    pub(super) fn tight(mut self) -> Self {
        if self.max < self.high {
            self.high = self.max;
            self.ticks.retain(|(value, _)| *value <= self.max);
        }
        self
    }

    /// The position of a value, 0 at the low end and 1 at the high end; `None` for a value that the scale cannot show.
    pub(super) fn share(&self, value: f64) -> Option<f64> {
        let value = if self.logarithmic { math::log10(value) } else { value };
        let share = (value - self.low) / (self.high - self.low);
        share.is_finite().then_some(share.clamp(0.0, 1.0))
    }
}

/// The next larger step that is 1, 2 or 5 times a power of ten.
fn round_step(step: f64) -> f64 {
    let power = math::powf(10_f64, math::log10(step).floor());
    let factor = [1.0, 2.0, 5.0].into_iter().find(|factor| factor * power >= step * 0.999);
    factor.unwrap_or(10.0) * power
}

fn power_of_ten(exponent: i32) -> String {
    match exponent {
        0..=4 => format!("{}", 10_i64.pow(exponent.unsigned_abs())),
        -3..=-1 => format!("{:.*}", exponent.unsigned_abs() as usize, 10_f64.powi(exponent)),
        _ => format!("1e{exponent}"),
    }
}
