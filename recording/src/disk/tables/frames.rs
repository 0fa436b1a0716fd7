//! The table of frames: the part that a robot could know. Each column is described together with the code that reads
//! its values from a reach and writes them into one. Names, types and widths are those that LeRobotDataset v3.0
//! requires.
//!
//! A frame lists only taxels with a force, while a column holds every taxel of its patch, with 0 N for the others. True
//! forces are stored separately (`truth_columns.rs` in a recording, `truth/` in a data set).

use std::ops::Range;

use glam::DVec3;

use crate::disk::table::{Batch, Column, Described, Rows, Type, Value, Values, Want, Width};
use crate::{Frame, Pose, Recording, Result, SkinLayout, TaxelReading, TrackPoint};

/// The column of contacts, which files of early builds do not have.
const CONTACT_POINTS: &str = "truth.contact_points";

/// Names of the numbers in a pose column.
const POSE: Width = Width::Named(&["x_m", "y_m", "z_m", "qx", "qy", "qz", "qw"]);
const POSITION: Width = Width::Named(&["x_m", "y_m", "z_m"]);

/// The position of a reach in a data set; the default is the position of a single reach.
#[derive(Clone, Copy, Default)]
pub(crate) struct Numbering {
    /// The episode.
    pub(crate) episode: usize,
    /// Index of its first frame among all frames of the set.
    pub(crate) first_index: usize,
    /// The task.
    pub(crate) task: i64,
}

/// A checked recording, whose frames are rows.
pub(crate) struct ReachRows<'a> {
    pub(crate) recording: &'a Recording,
    pub(crate) numbering: Numbering,
    /// The points of all tracks with their bodies, frame by frame.
    pub(crate) moves: Vec<(usize, TrackPoint)>,
}

impl ReachRows<'_> {
    /// The frame of a place.
    pub(crate) fn frame(&self, place: Place) -> &Frame {
        &self.recording.frames[place.frame]
    }
}

/// Where a value stands: the index of the frame, and of the patch for columns of patches.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub(crate) frame: usize,
    pub(crate) patch: usize,
}

/// What a value is, and what it may be.
pub(crate) type ColumnFault = (String, String);

/// Makes the column of a feature in some frames.
type Give = fn(&ReachRows, Range<usize>, &Feature) -> Column;
/// Adds the values of a column to a patch in the frames from this one on.
type Take = fn(&mut Recording, usize, usize, &Column) -> Result<(), ColumnFault>;

/// A column of frames.
pub(crate) struct FrameColumn {
    pub(crate) described: Described,
    pub(crate) give: Give,
    /// `None` if the values follow from others.
    pub(crate) take: Option<Take>,
}

/// Makes a column from a function that fills a row, which has the column's width and zeros.
pub(crate) fn give_rows<T: Value>(
    rows: &ReachRows,
    frames: Range<usize>,
    feature: &Feature,
    give: fn(&ReachRows, Place, &mut [T]),
) -> Column {
    let width = feature.width.unwrap_or(1);
    let mut values = vec![T::default(); width * frames.len()];
    for (frame, row) in frames.zip(values.chunks_exact_mut(width)) {
        give(rows, Place { frame, patch: feature.patch }, row);
    }
    Column::fixed(&feature.name, width, values)
}

/// Makes a column from a function that appends a list.
pub(crate) fn give_lists<T: Value>(
    rows: &ReachRows,
    frames: Range<usize>,
    feature: &Feature,
    give: fn(&ReachRows, Place, &mut Vec<T>),
) -> Column {
    let (mut values, mut ends) = (Vec::new(), Vec::new());
    for frame in frames {
        give(rows, Place { frame, patch: feature.patch }, &mut values);
        ends.push(values.len());
    }
    let present = vec![true; ends.len()];
    let rows = Rows::Lists { ends, present };
    Column { rows, ..Column::fixed(&feature.name, 1, values) }
}

/// Adds the values of a column row by row.
pub(crate) fn take_rows<T: Value>(
    recording: &mut Recording,
    first: usize,
    patch: usize,
    column: &Column,
    take: fn(&mut Recording, Place, &[T]) -> Result<(), ColumnFault>,
) -> Result<(), ColumnFault> {
    let place = |row: usize| Place { frame: first + row, patch };
    (0..column.count()).try_for_each(|row| take(recording, place(row), column.row(row).unwrap_or_default()))
}

/// Describes columns of frames: name, width, type, unit and text, how a row is filled or a list appended (`give`), and
/// how its values are added to a frame (`take`).
macro_rules! frame_columns {
    ($($name:literal: $width:expr, $value:ty, $unit:literal, $what:literal;
        $by:ident give $give:expr;
        $(take $take:expr;)?
    )*) => {
        &[$($crate::disk::tables::frames::FrameColumn {
            described: $crate::disk::table::row::Described {
                name: $name,
                value: <$value as $crate::disk::table::column::Value>::TYPE,
                width: $width,
                optional: false,
                unit: $unit,
                what: $what,
            },
            give: |rows, frames, feature| $crate::disk::tables::frames::$by::<$value>(rows, frames, feature, $give),
            take: frame_columns!(take $value $(, $take)?),
        }),*]
    };
    (take $value:ty) => { None };
    (take $value:ty, $take:expr) => {
        Some(|recording, first, patch, column| {
            $crate::disk::tables::frames::take_rows::<$value>(recording, first, patch, column, $take)
        })
    };
}
pub(crate) use frame_columns;

/// Sets a field.
pub(crate) fn set<T>(field: &mut T, value: T) -> Result<(), ColumnFault> {
    *field = value;
    Ok(())
}

/// The columns of frames in data sets and recordings.
pub(crate) static FRAME_COLUMNS: &[FrameColumn] = frame_columns! {
    // LeRobot computes the time stamp from the frame rate. The measured time has its own column, in full precision.
    "timestamp": Width::One, f32, "s", "frame_index / rate, as LeRobot defines it";
        give_rows give |rows, place, to| to.fill((place.frame as f64 / rows.recording.rate_hz) as f32);
    "frame_index": Width::One, i64, "", "index of the frame in its reach, from 0";
        give_rows give |_, place, to| to.fill(place.frame as i64);
        take |_, place, from| match usize::try_from(from[0]) == Ok(place.frame) {
            true => Ok(()),
            false => Err((from[0].to_string(), format!("{}, as rows are in the order of the frames", place.frame))),
        };
    "episode_index": Width::One, i64, "", "index of the reach, from 0";
        give_rows give |rows, _, to| to.fill(rows.numbering.episode as i64);
    "index": Width::One, i64, "", "index of the frame in the whole set, from 0";
        give_rows give |rows, place, to| to.fill((rows.numbering.first_index + place.frame) as i64);
    "task_index": Width::One, i64, "", "index of the task, a row of `meta/tasks.parquet`";
        give_rows give |rows, _, to| to.fill(rows.numbering.task);
    "time_s": Width::One, f64, "s", "time since the start of the reach";
        give_rows give |rows, place, to| to.fill(rows.frame(place).time_s);
        take |recording, place, from| set(&mut recording.frames[place.frame].time_s, from[0]);
    "observation.state": Width::Joints, f64, "rad", "joint angles";
        give_rows give |rows, place, to| to.copy_from_slice(&rows.frame(place).joint_angle_rad);
        take |recording, place, from| set(&mut recording.frames[place.frame].joint_angle_rad, from.to_vec());
    "observation.velocity": Width::Joints, f64, "rad/s", "joint velocities";
        give_rows give |rows, place, to| to.copy_from_slice(&rows.frame(place).joint_velocity_rad_per_s);
        take |recording, place, from| set(&mut recording.frames[place.frame].joint_velocity_rad_per_s, from.to_vec());
    "observation.torque": Width::Joints, f64, "N m", "joint torques of springs and dampers, without gravity, under the `action` of the frame before";
        give_rows give |rows, place, to| to.copy_from_slice(&rows.frame(place).joint_torque_nm);
        take |recording, place, from| set(&mut recording.frames[place.frame].joint_torque_nm, from.to_vec());
    "action": Width::Joints, f64, "rad", "equilibrium angles of the joint springs, which the controller gives in this frame";
        give_rows give |rows, place, to| to.copy_from_slice(&rows.frame(place).equilibrium_angle_rad);
        take |recording, place, from| set(&mut recording.frames[place.frame].equilibrium_angle_rad, from.to_vec());
    "observation.tip_pose": POSE, f64, "m, 1", "pose of the end effector in the world frame: x y z, quaternion x y z w";
        give_rows give |rows, place, to| to.copy_from_slice(&rows.frame(place).end_effector_pose_world.numbers());
        take |recording, place, from| set(&mut recording.frames[place.frame].end_effector_pose_world, Pose::from_numbers(from));
    "goal_position": POSITION, f64, "m", "current goal of the end effector, world frame";
        give_rows give |rows, place, to| rows.frame(place).goal_position_world.write_to_slice(to);
        take |recording, place, from| {
            set(&mut recording.frames[place.frame].goal_position_world, DVec3::from_slice(from))
        };
    "goal_index": Width::One, i32, "", "index of the current goal in the reach, from 0";
        give_rows give |rows, place, to| to.fill(rows.frame(place).goal_index.into());
        take |recording, place, from| {
            let index = u16::try_from(from[0]).map_err(|_| (from[0].to_string(), "0 to 65535".into()))?;
            set(&mut recording.frames[place.frame].goal_index, index)
        };
    "observation.patch_pose.PATCH": POSE, f64, "m, 1", "pose of the link under the patch in the world frame: x y z, \
            quaternion x y z w";
        give_rows give |rows, place, to| to.copy_from_slice(&rows.frame(place).patch_pose_world[place.patch].numbers());
        take |recording, place, from| {
            set(&mut recording.frames[place.frame].patch_pose_world[place.patch], Pose::from_numbers(from))
        };
    "observation.tactile.PATCH": Width::Taxels(1), f32, "N", "normal force that each taxel reports, by taxel index";
        give_rows give |rows, place, to| give_readings(rows, place, to, |reading| reading.sensed_force_n as f32);
        take |recording, place, from| {
            let forces = from.iter().map(|force_n| f64::from(*force_n)).enumerate();
            for (taxel, force_n) in forces.filter(|(_, force_n)| !is_nothing(*force_n)) {
                reading_of(recording, place, taxel).sensed_force_n = force_n;
            }
            Ok(())
        };
};

/// A column of the frames of a robot: of one of its patches, if the column belongs to patches.
#[derive(Clone)]
pub(crate) struct Feature {
    pub(crate) column: &'static FrameColumn,
    /// Name of the column, without "/".
    pub(crate) name: String,
    patch: usize,
    /// Numbers in a row; `None` for lists.
    pub(crate) width: Option<usize>,
    /// Names of the numbers, unless they are taxels.
    pub(crate) names: Option<Vec<String>>,
}

impl Feature {
    fn new(column: &'static FrameColumn, joint_names: &[String], layout: &SkinLayout, patch: usize) -> Self {
        let own = layout.patches.get(patch);
        let texts = |names: &[&str]| Some(names.iter().map(ToString::to_string).collect());
        let (width, names) = match column.described.width {
            Width::One => (Some(1), None),
            Width::List => (None, None),
            Width::Joints => (Some(joint_names.len()), Some(joint_names.to_vec())),
            Width::Named(names) => (Some(names.len()), texts(names)),
            Width::Taxels(each) => (own.map(|patch| each * patch.taxels.len()), None),
        };
        let name = column.described.name;
        let prefix = name.strip_suffix("PATCH").zip(own);
        let name = prefix.map_or(name.into(), |(prefix, own)| prefix.to_owned() + &own.name);
        Feature { column, name, patch, width, names }
    }

    /// What a reader of frames needs of it.
    fn want(&self) -> Want {
        match self.column.take {
            Some(_) => self.width.map_or(Want::All, Want::Fixed),
            None => Want::Nothing,
        }
    }

    /// Adds the values of a batch to its frames, the first of which is `first`.
    fn take(&self, batch: &Batch, recording: &mut Recording, first: usize) -> Result<()> {
        let Some(take) = self.column.take else { return Ok(()) };
        let column = batch.column(&self.name)?;
        let described = &self.column.described;
        let single;
        let column = match (&column.values, described.value) {
            // Sets of version 0.1.0 have forces in double precision, and other programs may write all numbers so.
            (Values::Float64(values), Type::Float32) => {
                let values = Values::Float32(values.iter().map(|number| *number as f32).collect());
                single = Column { name: column.name.clone(), values, rows: column.rows.clone() };
                &single
            }
            _ => column,
        };
        let fits = column.fits(described.value, self.width, described.optional);
        fits.and_then(|()| take(recording, first, self.patch, column))
            .map_err(|(found, allowed)| batch.error(&self.name, found, allowed))
    }
}

/// The columns of the frames of a robot, in file order: those of a patch stand together.
pub(crate) fn features(columns: &'static [FrameColumn], joint_names: &[String], layout: &SkinLayout) -> Vec<Feature> {
    let of_patches = |column: &FrameColumn| column.described.name.ends_with("PATCH");
    let mut features = Vec::new();
    for group in columns.chunk_by(|a, b| of_patches(a) == of_patches(b)) {
        let patches = if of_patches(&group[0]) { layout.patches.len() } else { 1 };
        for patch in 0..patches {
            features.extend(group.iter().map(|column| Feature::new(column, joint_names, layout, patch)));
        }
    }
    features
}

/// The columns of some frames.
pub(crate) fn columns_of(features: &[Feature], rows: &ReachRows, frames: Range<usize>) -> Vec<Column> {
    features.iter().map(|feature| (feature.column.give)(rows, frames.clone(), feature)).collect()
}

/// What a reader of frames needs of the column with a name.
pub(crate) fn wanted(features: &[Feature]) -> impl Fn(&str) -> Want {
    move |name| features.iter().find(|feature| feature.name == name).map_or(Want::Nothing, Feature::want)
}

/// Appends the rows of a batch to the frames of a recording whose other fields are known. What the columns do not hold is
/// left out.
pub(crate) fn append_frames(features: &[Feature], batch: &Batch, recording: &mut Recording) -> Result<()> {
    let patches = recording.layout.patches.len();
    let first = recording.frames.len();
    recording.frames.resize(first + batch.rows, Frame::blank(patches));
    let mut there = features.iter().filter(|feature| feature.name != CONTACT_POINTS || batch.has(CONTACT_POINTS));
    there.try_for_each(|feature| feature.take(batch, recording, first))
}

/// The readings of the taxels of a patch in a frame.
pub(crate) fn readings_of(recording: &Recording, place: Place) -> impl Iterator<Item = &TaxelReading> {
    let of_patch = move |reading: &&TaxelReading| usize::from(reading.patch) == place.patch;
    recording.frames[place.frame].taxels.iter().filter(of_patch)
}

/// Writes the value of each reading of a patch to the place of its taxel in `to`.
pub(crate) fn give_readings<T>(rows: &ReachRows, place: Place, to: &mut [T], value: impl Fn(&TaxelReading) -> T) {
    for reading in readings_of(rows.recording, place) {
        to[usize::from(reading.taxel)] = value(reading);
    }
}

/// The reading of a taxel, which is added if the frame has none.
pub(crate) fn reading_of(recording: &mut Recording, place: Place, taxel: usize) -> &mut TaxelReading {
    let taxels = &mut recording.frames[place.frame].taxels;
    // Both fit, as the layout was checked.
    let key = (place.patch as u16, taxel as u16);
    let found = taxels.binary_search_by_key(&key, |reading| (reading.patch, reading.taxel));
    let position = found.unwrap_or_else(|position| {
        taxels.insert(position, TaxelReading { patch: key.0, taxel: key.1, ..TaxelReading::default() });
        position
    });
    &mut taxels[position]
}

/// Whether a number is the one stored for taxels that a frame does not list: 0, but not −0, so that reading is exact.
pub(crate) fn is_nothing(number: f64) -> bool {
    number.to_bits() == 0
}
