//! The columns of frames: names, types and widths as LeRobotDataset v3.0 requires.

use std::sync::Arc;

use arrow_array::{Array, ArrayRef, FixedSizeListArray, Float64Array};
use arrow_schema::{DataType, Field, Schema, SchemaRef};
use parquet::errors::ParquetError;

use super::dictionary::{FRAMES, RECORDING_TRUTH};
use crate::SkinLayout;

/// Names of the numbers in a pose column.
const POSE_NAMES: [&str; 7] = ["x_m", "y_m", "z_m", "qx", "qy", "qz", "qw"];

/// One column, with one or several numbers per row.
#[derive(Clone, Debug)]
pub(super) struct Feature {
    /// Name of the column, without "/".
    pub(super) name: String,
    /// Type of one number.
    pub(super) number: DataType,
    /// Numbers per row; 1 is a plain column.
    pub(super) width: usize,
    /// Names of the numbers, unless they are taxels.
    pub(super) names: Option<Vec<String>>,
}

impl Feature {
    fn new(name: impl Into<String>, number: DataType, width: usize) -> Self {
        Feature {
            name: name.into(),
            number,
            width,
            names: None,
        }
    }

    fn named(mut self, names: &[impl ToString]) -> Self {
        self.names = Some(names.iter().map(ToString::to_string).collect());
        self
    }

    /// The element of a list column.
    pub(super) fn element(&self) -> Field {
        Field::new("item", self.number.clone(), true)
    }

    fn field(&self) -> Field {
        let data_type = match i32::try_from(self.width) {
            Ok(width) if width > 1 => DataType::FixedSizeList(Arc::new(self.element()), width),
            _ => self.number.clone(),
        };
        let metadata = FRAMES
            .metadata(&self.name)
            .or_else(|| RECORDING_TRUTH.metadata(&self.name));
        Field::new(&self.name, data_type, true).with_metadata(metadata.unwrap_or_default())
    }
}

/// The columns of frames in data sets and recordings, in file order: what a robot could know. `frames.rs` fills them in
/// the same order.
pub(super) fn features(joint_names: &[String], layout: &SkinLayout) -> Vec<Feature> {
    use DataType::{Float32, Float64, Int32, Int64};
    let joints = joint_names.len();
    let mut features = vec![
        Feature::new("timestamp", Float32, 1),
        Feature::new("frame_index", Int64, 1),
        Feature::new("episode_index", Int64, 1),
        Feature::new("index", Int64, 1),
        Feature::new("task_index", Int64, 1),
        Feature::new("time_s", Float64, 1),
        Feature::new("observation.state", Float64, joints).named(joint_names),
        Feature::new("observation.velocity", Float64, joints).named(joint_names),
        Feature::new("observation.torque", Float64, joints).named(joint_names),
        Feature::new("action", Float64, joints).named(joint_names),
        Feature::new("observation.tip_pose", Float64, 7).named(&POSE_NAMES),
        Feature::new("goal_position", Float64, 3).named(&POSE_NAMES[..3]),
        Feature::new("goal_index", Int32, 1),
    ];
    for patch in &layout.patches {
        let name = |feature: PatchFeature| feature.column(&patch.name);
        let count = patch.taxels.len();
        features.extend([
            Feature::new(name(PatchFeature::Pose), Float64, 7).named(&POSE_NAMES),
            Feature::new(name(PatchFeature::Tactile), Float64, count),
        ]);
    }
    features
}

/// The columns of ground truth that follow in the file of a single recording. `truth_columns.rs` fills them in the same
/// order.
pub(super) fn truth_features(layout: &SkinLayout) -> Vec<Feature> {
    use DataType::{Float64, Int8, Int16};
    let patches = layout.patches.iter().flat_map(|patch| {
        let name = |feature: PatchFeature| feature.column(&patch.name);
        let count = patch.taxels.len();
        [
            Feature::new(name(PatchFeature::NormalForce), Float64, count),
            Feature::new(name(PatchFeature::ShearForce), Float64, 2 * count),
            Feature::new(name(PatchFeature::Object), Int16, count),
            Feature::new(name(PatchFeature::Category), Int8, count),
            Feature::new(name(PatchFeature::ContactForce), Float64, 3).named(&["x_n", "y_n", "z_n"]),
        ]
    });
    patches.collect()
}

/// The columns of each patch.
#[derive(Clone, Copy)]
pub(super) enum PatchFeature {
    /// Pose of the patch's link, world frame.
    Pose,
    /// Sensed normal force of each taxel, N.
    Tactile,
    /// True normal force of each taxel, N.
    NormalForce,
    /// True shear force of each taxel along its two tangents, N.
    ShearForce,
    /// Index of the object on each taxel, −1 for none.
    Object,
    /// Code of that object's category, −1 for none.
    Category,
    /// Sum of the solver's contact forces on the patch, N, world frame.
    ContactForce,
}

impl PatchFeature {
    /// The name of the column of a patch.
    pub(super) fn column(self, patch: &str) -> String {
        let prefix = match self {
            PatchFeature::Pose => "observation.patch_pose",
            PatchFeature::Tactile => "observation.tactile",
            PatchFeature::NormalForce => "truth.normal_force",
            PatchFeature::ShearForce => "truth.shear_force",
            PatchFeature::Object => "truth.object",
            PatchFeature::Category => "truth.category",
            PatchFeature::ContactForce => "truth.contact_force",
        };
        format!("{prefix}.{patch}")
    }
}

/// The Arrow fields of the columns.
pub(super) fn fields(features: &[Feature]) -> Vec<Field> {
    features.iter().map(Feature::field).collect()
}

/// The Arrow schema of the columns.
pub(super) fn schema(features: &[Feature]) -> SchemaRef {
    Arc::new(Schema::new(fields(features)))
}

/// Arrays of columns in the order of their features.
pub(super) struct ColumnBuilder {
    features: std::vec::IntoIter<Feature>,
    columns: Vec<ArrayRef>,
}

impl ColumnBuilder {
    /// Starts with the first feature.
    pub(super) fn new(features: Vec<Feature>) -> Self {
        ColumnBuilder {
            columns: Vec::with_capacity(features.len()),
            features: features.into_iter(),
        }
    }

    /// Adds the next column from its numbers, row by row.
    pub(super) fn push(&mut self, numbers: impl Array + 'static) -> Result<(), ParquetError> {
        let numbers: ArrayRef = Arc::new(numbers);
        let column = match self.features.next() {
            Some(feature) if feature.width > 1 => {
                let width = i32::try_from(feature.width).map_err(|error| ParquetError::General(error.to_string()))?;
                Arc::new(FixedSizeListArray::try_new(
                    Arc::new(feature.element()),
                    width,
                    numbers,
                    None,
                )?)
            }
            _ => numbers,
        };
        self.columns.push(column);
        Ok(())
    }

    /// Adds the next column in double precision from its numbers, row by row.
    pub(super) fn push_f64(&mut self, numbers: impl IntoIterator<Item = f64>) -> Result<(), ParquetError> {
        self.push(Float64Array::from_iter_values(numbers))
    }

    /// The finished arrays.
    pub(super) fn finish(self) -> Vec<ArrayRef> {
        self.columns
    }
}
