//! The columns of ground truth that follow those of `frames.rs` in the file of a single recording: dense columns for
//! taxels, and lists for the bodies that moved.

use glam::{DVec3, Vec3};

use crate::disk::table::Width;
use crate::disk::tables::frames::{
    ColumnFault, FrameColumn, Place, ReachRows, frame_columns, give_readings, is_nothing, reading_of, readings_of, set,
};
use crate::{ContactPoint, Recording, TrackPoint};

/// "No object" and "no category".
pub(crate) const NONE: i8 = -1;

const FORCE: Width = Width::Named(&["x_n", "y_n", "z_n"]);

/// The columns.
pub(crate) static TRUTH_COLUMNS: &[FrameColumn] = frame_columns! {
    "truth.normal_force.PATCH": Width::Taxels(1), f64, "N", "true normal force on each taxel, before the sensor";
        give_rows give |rows, place, to| give_readings(rows, place, to, |reading| reading.true_normal_force_n);
        take |recording, place, from| {
            for (taxel, force_n) in from.iter().enumerate().filter(|(_, force_n)| !is_nothing(**force_n)) {
                reading_of(recording, place, taxel).true_normal_force_n = *force_n;
            }
            Ok(())
        };
    "truth.shear_force.PATCH": Width::Taxels(2), f64, "N", "true shear force along tangent and normal × tangent, taxel \
            by taxel";
        give_rows give |rows, place, to| {
            give_readings(rows, place, to.as_chunks_mut().0, |reading| reading.true_shear_force_n);
        };
        take |recording, place, from| {
            let forces = from.as_chunks().0.iter().enumerate();
            for (taxel, force_n) in forces.filter(|(_, force_n)| !force_n.iter().all(|number| is_nothing(*number))) {
                reading_of(recording, place, taxel).true_shear_force_n = *force_n;
            }
            Ok(())
        };
    "truth.object.PATCH": Width::Taxels(1), i16, "", "index of the object that presses each taxel; −1 for none";
        give_rows give |rows, place, to| {
            to.fill(NONE.into());
            // A checked recording has at most 32768 objects.
            give_readings(rows, place, to, |reading| reading.object.map_or(NONE.into(), |object| object as i16));
        };
        take |recording, place, from| {
            for (taxel, object) in from.iter().enumerate().filter(|(_, object)| **object != i16::from(NONE)) {
                let object = object_of(recording, (*object).into())?;
                reading_of(recording, place, taxel).object = object;
            }
            Ok(())
        };
    "truth.category.PATCH": Width::Taxels(1), i8, "", "category of that object";
        give_rows give |rows, place, to| {
            to.fill(NONE);
            let code = |object: u16| rows.recording.objects[usize::from(object)].category.code();
            give_readings(rows, place, to, |reading| reading.object.map_or(NONE, code));
        };
        // The category is that of the object, which was read before.
        take |recording, place, from| {
            for reading in readings_of(recording, place) {
                check_code(recording, reading.object, from[usize::from(reading.taxel)])?;
            }
            Ok(())
        };
    "truth.contact_force.PATCH": FORCE, f64, "N", "sum of the solver's contact forces on the patch, world frame";
        give_rows give |rows, place, to| rows.frame(place).contact_force_world[place.patch].write_to_slice(to);
        take |recording, place, from| {
            set(&mut recording.frames[place.frame].contact_force_world[place.patch], DVec3::from_slice(from))
        };
    "truth.contact_points": Width::List, f32, "N, m, m/s", "the contacts of the frame, 21 numbers each: \
            link, patch (−1 for none), object (−1 for the arm itself) and its body (indices of the bodies and objects of the file), then \
            position, normal, force, moment and slip (x y z each, world frame), depth and area";
        give_lists give |rows, place, to| {
            to.extend(rows.frame(place).contact_points.iter().flat_map(ContactPoint::numbers));
        };
        take add_contact_points;
    "truth.moved_body": Width::List, i32, "", "indices of the bodies whose pose differs from the previous frame";
        give_lists give |rows, place, to| to.extend(moves_in(rows, place).iter().map(|(body, _)| *body as i32));
        take add_moved_bodies;
    "truth.moved_pose": Width::List, f32, "m, 1", "their poses, seven numbers each: x y z and quaternion x y z w, world \
            frame, in steps of 1/8192";
        give_lists give |rows, place, to| {
            for (_, point) in moves_in(rows, place) {
                to.extend(point.position_world_m);
                to.extend(point.orientation_world);
            }
        };
        take add_poses;
};

/// The object with an index that a table holds.
pub(crate) fn object_of(recording: &Recording, index: i32) -> Result<Option<u16>, ColumnFault> {
    if index == i32::from(NONE) {
        return Ok(None);
    }
    let count = recording.objects.len();
    let known = u16::try_from(index).ok().filter(|object| usize::from(*object) < count);
    let allowed = || format!("−1 or an object from 0 to {}", count.saturating_sub(1));
    known.map(Some).ok_or_else(|| (index.to_string(), allowed()))
}

/// An error unless a code is that of the category of an object, if there is one.
pub(crate) fn check_code(recording: &Recording, object: Option<u16>, found: i8) -> Result<(), ColumnFault> {
    let Some(object) = object else { return Ok(()) };
    let expected = recording.objects[usize::from(object)].category.code();
    let allowed = || format!("{expected}, the category of object {object}");
    if found == expected { Ok(()) } else { Err((found.to_string(), allowed())) }
}

/// Numbers in a row of the column for a single recording.
const NUMBERS: usize = 21;

impl ContactPoint {
    /// All fields as numbers, in their order; a missing patch or object is −1.
    pub(crate) fn numbers(&self) -> [f32; NUMBERS] {
        let [position, normal, force, moment, slip] =
            [self.position_world, self.normal_world, self.force_world, self.moment_world, self.slip_world]
                .map(|vector| vector.to_array());
        let [patch, object] = [self.patch, self.object].map(|index| index.map_or(-1.0, f32::from));
        let mut numbers = [0.0; NUMBERS];
        numbers[..4].copy_from_slice(&[self.link.into(), patch, object, self.body.into()]);
        numbers[4..19].copy_from_slice([position, normal, force, moment, slip].as_flattened());
        numbers[19..].copy_from_slice(&[self.depth_m, self.area_m2]);
        numbers
    }

    /// The contact with these numbers; `None` if an index is not a whole number of its range.
    pub(crate) fn from_numbers(numbers: &[f32; NUMBERS]) -> Option<Self> {
        let index = |number: f32| (f32::from(number as u16) == number).then_some(number as u16);
        let optional = |number: f32| if number == -1.0 { Some(None) } else { index(number).map(Some) };
        let vector = |first: usize| Vec3::from_slice(&numbers[first..]);
        Some(ContactPoint {
            link: index(numbers[0])?,
            patch: optional(numbers[1])?,
            object: optional(numbers[2])?,
            body: index(numbers[3])?,
            position_world: vector(4),
            normal_world: vector(7),
            force_world: vector(10),
            moment_world: vector(13),
            slip_world: vector(16),
            depth_m: numbers[19],
            area_m2: numbers[20],
        })
    }
}

/// Adds the contacts of a frame.
fn add_contact_points(recording: &mut Recording, place: Place, from: &[f32]) -> Result<(), ColumnFault> {
    let (points, rest) = from.as_chunks();
    let points: Option<Vec<ContactPoint>> = points.iter().map(ContactPoint::from_numbers).collect();
    match points {
        Some(points) if rest.is_empty() => set(&mut recording.frames[place.frame].contact_points, points),
        _ => Err((format!("{} numbers", from.len()), "21 for each contact, the first four whole".into())),
    }
}

/// The points of all tracks with their bodies, frame by frame.
pub(crate) fn moves(recording: &Recording) -> Vec<(usize, TrackPoint)> {
    let bodies = recording.bodies.iter().enumerate();
    let mut moves: Vec<_> =
        bodies.flat_map(|(body, found)| found.track.iter().map(move |point| (body, *point))).collect();
    // A stable sort keeps the order of bodies within a frame.
    moves.sort_by_key(|(_, point)| point.frame);
    moves
}

/// The points of a frame.
fn moves_in<'a>(rows: &'a ReachRows, place: Place) -> &'a [(usize, TrackPoint)] {
    let before = |frame: usize| rows.moves.partition_point(|(_, point)| (point.frame as usize) < frame);
    &rows.moves[before(place.frame)..before(place.frame + 1)]
}

/// Adds points without poses to the tracks of the bodies that moved in a frame.
fn add_moved_bodies(recording: &mut Recording, place: Place, from: &[i32]) -> Result<(), ColumnFault> {
    let count = recording.bodies.len();
    for (nth, index) in from.iter().enumerate() {
        let found = usize::try_from(*index).ok().and_then(|index| recording.bodies.get_mut(index));
        let sorted = nth == 0 || from[nth - 1] < *index;
        let Some(body) = found.filter(|_| sorted) else {
            return Err((index.to_string(), format!("a body below {count}, in order")));
        };
        body.track.push(TrackPoint {
            frame: place.frame as u32,
            position_world_m: [0.0; 3],
            orientation_world: [0.0; 4],
        });
    }
    Ok(())
}

/// Adds the poses to the points of a frame.
fn add_poses(recording: &mut Recording, place: Place, from: &[f32]) -> Result<(), ColumnFault> {
    let mut points = Vec::new();
    for body in &mut recording.bodies {
        let point = body.track.binary_search_by_key(&place.frame, |point| point.frame as usize);
        points.extend(point.ok().map(|point| &mut body.track[point]));
    }
    let (poses, rest) = from.as_chunks::<7>();
    if poses.len() != points.len() || !rest.is_empty() {
        let allowed = format!("seven numbers for each of {} bodies", points.len());
        return Err((format!("{} numbers", from.len()), allowed));
    }
    for (point, &[x, y, z, qx, qy, qz, qw]) in points.into_iter().zip(poses) {
        point.position_world_m = [x, y, z];
        point.orientation_world = [qx, qy, qz, qw];
    }
    Ok(())
}
