//! Covers a link of an arm with taxels: a new patch of its skin file.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use glam::DVec3;
use underbrush_recording::limits::{MAX_TAXELS, short};
use underbrush_recording::{BodyShape, InputError, Pose};

use super::skin::FACING_COSINE;
use super::skin_fit::Surface;
use super::source::quoted;
use super::{Arm, LinkCollider, limits};
use crate::geometry::PlacedShape;

/// A patch to be made.
#[derive(Clone, Debug)]
pub struct NewPatch {
    /// Its name.
    pub name: String,
    /// The moving link, or base, that it covers, or a link that is rigidly joined to it.
    pub link: String,
    /// Distance between neighbouring taxels, m.
    pub pitch_m: f64,
    /// Whether taxels that nothing can touch are left out; otherwise they are an error.
    pub prune: bool,
    /// Whether a patch of this name may be replaced.
    pub replace: bool,
}

/// A skin file with the new patch.
#[derive(Clone, Debug)]
pub struct Covered {
    /// The skin file.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
    /// The arm with that skin.
    pub arm: Arm,
    /// How many taxels or, on a grid, rows of taxels were left out.
    pub left_out: usize,
}

/// Of a pitch, the side of taxels on a grid. Choice: Cody's taxels are 9 mm wide, 10.8 mm apart.
const TAXEL_SHARE: f64 = 0.9;
/// Of a pitch, the least distance of taxels that are no grid. On a flat face along the axes they are a whole pitch apart,
/// because candidates are a quarter apart.
const LEAST_SHARE: f64 = 0.9;
const CANDIDATES_PER_PITCH: f64 = 4.0;
/// A taxel that is deeper than this in another shape cannot be touched, m. Choice: less than a skin gives way.
const BURIED_M: f64 = 5e-4;

/// A place on the surface of a link, in the frame of the link.
#[derive(Clone, Copy)]
struct Place {
    position: DVec3,
    normal: DVec3,
}

/// Makes a patch on the arm whose file is `arm_file`.
///
/// A link with one collision shape that is a cylinder or a capsule gets rows and columns round its side. Any other link gets
/// taxels that are at least 0.9 pitches apart, listed one by one. The same arm and pitch give the same patch.
///
/// # Errors
/// When the arm's files are bad, the patch has a wrong name, link or pitch, or taxels cannot be touched and
/// [`NewPatch::prune`] is off: then the error lists all of them.
pub fn cover(arm_file: &Path, new: &NewPatch) -> Result<Covered, InputError> {
    let arm = Arm::load(arm_file)?;
    let [_, _, skin] = &arm.files;
    let path = arm_file.parent().unwrap_or(Path::new("")).join(&skin.name);
    let refused = |found: String, allowed: &str, remedy: &str| {
        InputError::new(&path, format!("patch {}", new.name), found, allowed, remedy)
    };
    let (faults, link) = faults(&arm, new);
    let (Some(link), true) = (link, faults.is_empty()) else {
        return Err(refused(faults.join("; "), "a patch that fits the arm", "change the options"));
    };
    let new = &NewPatch { link: arm.links[link].name.clone(), ..new.clone() };
    let (table, left_out) = match arm.links[link].colliders.as_slice() {
        [only] if round(only).is_some() => grid(&arm, link, only, new),
        _ => points(&arm, link, new),
    }
    .map_err(|found| {
        refused(found, "taxels that something can touch, 1 to 65536 of them", "add --prune, or choose another pitch")
    })?;
    let is_new = |block: &&str| {
        let table: Result<toml::Table, _> = block.parse();
        table.is_ok_and(|table| table.get("name").and_then(toml::Value::as_str) == Some(new.name.as_str()))
    };
    // A patch keeps its place among the others, because the first one is special.
    let before = format!("{}\n\n", skin.text.trim_end());
    let mut blocks: Vec<&str> = before.split("[[patch]]").collect();
    let found = blocks.iter().skip(1).position(is_new).map(|place| place + 1);
    let own = format!("\n{}\n\n{}", table.trim_end(), found.map_or("", |place| remarks(blocks[place])));
    match found {
        Some(place) => blocks[place] = &own,
        None => blocks.push(&own),
    }
    let text = format!("{}\n", blocks.join("[[patch]]").trim_end());
    let mut files = arm.files.clone();
    files[2].text.clone_from(&text);
    let arm = Arm::from_files(&files)
        .map_err(|error| refused(format!("{}: {}", error.field, error.found), &error.allowed, "change the options"))?;
    Ok(Covered { path, text, arm, left_out })
}

/// The comments at the end of a patch, which are about the next one.
fn remarks(block: &str) -> &str {
    let is_code = |line: &&str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    let lines = block.split_inclusive('\n').rev().take_while(|line| !is_code(line));
    block[block.len() - lines.map(str::len).sum::<usize>()..].trim_start()
}

/// What is wrong with the options, all of it, and the link.
fn faults(arm: &Arm, new: &NewPatch) -> (Vec<String>, Option<usize>) {
    let mut faults = Vec::new();
    let link = arm.links.iter().position(|link| link.name == new.link || link.joined.contains(&new.link));
    match link.map(|link| &arm.links[link]) {
        None => {
            let names = arm.links.iter().flat_map(|link| std::iter::once(&link.name).chain(&link.joined));
            let names: Vec<&str> = names.map(String::as_str).collect();
            faults.push(format!("no link {:?}; there are {}", new.link, names.join(", ")));
        }
        Some(link) if link.colliders.is_empty() => faults.push(format!("link {} has no collision shape", link.name)),
        Some(link) => {
            let area_m2: f64 = link.placed_shapes(Pose::IDENTITY).map(|shape| box_area_m2(&shape)).sum();
            if limits::TAXEL_SIZE_M.hold(new.pitch_m) && area_m2 / (new.pitch_m * new.pitch_m) > MAX_TAXELS as f64 {
                faults.push(format!("a pitch of {} mm may give over {MAX_TAXELS} taxels", short(new.pitch_m * 1e3)));
            }
        }
    }
    if !limits::TAXEL_SIZE_M.hold(new.pitch_m) {
        let [pitch, min, max] =
            [new.pitch_m, limits::TAXEL_SIZE_M.min, limits::TAXEL_SIZE_M.max].map(|m| short(m * 1e3));
        faults.push(format!("a pitch of {pitch} mm; it must be {min} to {max} mm"));
    }
    if arm.skin.layout.patch_index(&new.name).is_some() && !new.replace {
        faults.push(format!("a patch {:?} is there already; --force replaces it", new.name));
    }
    (faults, link)
}

fn box_area_m2(shape: &PlacedShape) -> f64 {
    let half = shape.shape.compute_local_aabb().half_extents();
    8.0 * (half.x * half.y + half.y * half.z + half.z * half.x)
}

/// Radius and length of a cylinder's or capsule's side, m.
fn round(collider: &LinkCollider) -> Option<(f64, f64)> {
    match collider.shape {
        BodyShape::Cylinder { radius_m, length_m } | BodyShape::Capsule { radius_m, length_m } => {
            Some((radius_m, length_m))
        }
        _ => None,
    }
}

/// The keys of a patch, up to its own kind of table.
fn head(new: &NewPatch, note: &str) -> String {
    let millimetres = short(new.pitch_m * 1000.0);
    let [name, link] = [&new.name, &new.link].map(|own| quoted(own));
    format!(
        "# Made by `underbrush arm skin` with a pitch of {millimetres} mm: {note}.\nname = {name}\nlink = {link}\ntechnology = \"capacitive\"\n\n"
    )
}

/// Rows and columns round the side of a cylinder or capsule, and how many rows are left out.
fn grid(arm: &Arm, link: usize, collider: &LinkCollider, new: &NewPatch) -> Result<(String, usize), String> {
    let (radius_m, length_m) = round(collider).unwrap_or_default();
    let [rows, columns] =
        [length_m, TAU * radius_m].map(|extent| ((extent / new.pitch_m + 1e-9).floor() as usize).max(1));
    let axis = collider.pose_link.transform_vector(DVec3::Z);
    let zero = collider.pose_link.transform_vector(DVec3::X);
    let step_deg = 360.0 / columns as f64;
    let along_m = |row: usize| (row as f64 - (rows - 1) as f64 / 2.0) * new.pitch_m;
    let place = |row: usize, column: usize| {
        let normal = glam::DQuat::from_axis_angle(axis, (column as f64 * step_deg).to_radians()) * zero;
        Place { position: collider.pose_link.position + axis * along_m(row) + normal * radius_m, normal }
    };
    let places: Vec<Place> = (0..rows * columns).map(|taxel| place(taxel / columns, taxel % columns)).collect();
    let covered = covered(arm, link, &places, new)?;
    // The longest run of rows that can be felt all round.
    let free: Vec<bool> =
        (0..rows).map(|row| covered[row * columns..(row + 1) * columns].iter().all(Option::is_none)).collect();
    let runs = (0..rows).map(|first| (first, free[first..].iter().take_while(|free| **free).count()));
    let (first, kept) = runs.max_by_key(|(first, count)| (*count, rows - first)).unwrap_or((0, 0));
    if kept == 0 {
        return Err("no row of taxels that something can touch all round".into());
    }
    let row_0 = collider.pose_link.position + axis * along_m(first);
    let angles: Vec<String> =
        (0..columns).map(|column| short((column as f64 * step_deg * 1e3).round() / 1e3)).collect();
    let head = head(new, "rows and columns round the side of the link's only shape");
    let [row_0, axis, zero] = [(row_0, 1e6), (axis, 1e9), (zero, 1e9)].map(|(own, steps)| numbers(own, steps));
    let (pitch, size, wraps, angles) = (new.pitch_m, new.pitch_m * TAXEL_SHARE, columns > 2, angles.join(", "));
    let text = format!(
        "{head}[patch.cylinder]\nrow_0_m = {row_0}\naxis = {axis}\nzero_angle = {zero}\nradius_m = {radius_m}\nrows = {kept}\n\
         row_pitch_m = {pitch}\n# The rest of the pitch is a gap.\ntaxel_size_m = {size}\nwraps = {wraps}\n\
         column_angles_deg = [{angles}]\n"
    );
    Ok((text, rows - kept))
}

/// Three numbers in brackets, rounded to so many steps to a unit.
fn numbers(vector: DVec3, steps: f64) -> String {
    let [x, y, z] = ((vector * steps).round() / steps + 0.0).to_array();
    format!("[{x:?}, {y:?}, {z:?}]")
}

/// Taxels all over the link's shapes, and how many are left out.
fn points(arm: &Arm, link: usize, new: &NewPatch) -> Result<(String, usize), String> {
    let own = Surface::of(&arm.links[link]);
    let candidates = own.0.iter().flat_map(|shape| surface(shape, new.pitch_m));
    let mut picked = Spread { least_m: LEAST_SHARE * new.pitch_m, cells: HashMap::new(), places: Vec::new() };
    // Pruned before they are spread, so that they do not keep others away.
    for place in candidates.filter(|place| !new.prune || own.is_open(place)) {
        picked.add(place);
    }
    let covered = covered(arm, link, &picked.places, new)?;
    let left_out = covered.iter().flatten().count();
    let limits = [LEAST_SHARE * LEAST_SHARE, 1.0].map(|share| share * new.pitch_m * new.pitch_m);
    let mut text = head(new, &format!("taxels at least {LEAST_SHARE} pitches apart, all over the link"));
    let _ = writeln!(text, "[patch.points]\nderived_area_limits_m2 = [{:?}, {:?}]\ntaxels = [", limits[0], limits[1]);
    for (place, _) in picked.places.iter().zip(&covered).filter(|(_, cover)| cover.is_none()) {
        let (position, normal) = (numbers(place.position, 1e5), numbers(place.normal, 1e4));
        let _ = writeln!(text, "    {{ position_m = {position}, normal = {normal} }},");
    }
    text += "]\n";
    match left_out < picked.places.len() {
        true => Ok((text, left_out)),
        false => Err("no taxel that something can touch".into()),
    }
}

/// Places all over a convex shape, at most a quarter of a pitch apart: the nearest ones to a grid on a box around it. The way
/// from there is the normal.
fn surface(shape: &PlacedShape, pitch_m: f64) -> Vec<Place> {
    let bounds = shape.shape.compute_local_aabb();
    let half = bounds.half_extents() + pitch_m;
    let step_m = pitch_m / CANDIDATES_PER_PITCH;
    let mut places = Vec::new();
    for (across, [first, second]) in
        [(DVec3::Z, [DVec3::X, DVec3::Y]), (DVec3::X, [DVec3::Y, DVec3::Z]), (DVec3::Y, [DVec3::Z, DVec3::X])]
    {
        for side in [-1.0, 1.0] {
            // The grid is centred on the face.
            let steps = [first, second].map(|axis| (half.dot(axis) / step_m).ceil() as i64);
            for one in -steps[0]..=steps[0] {
                for other in -steps[1]..=steps[1] {
                    let flat = first * (one as f64 * step_m) + second * (other as f64 * step_m);
                    let outside = bounds.center() + across * (side * half.dot(across)) + flat;
                    let nearest = shape.shape.project_local_point(outside, true).point;
                    if let Some(normal) = (outside - nearest).try_normalize() {
                        places.push(Place {
                            position: shape.pose.transform_point(nearest),
                            normal: shape.pose.transform_vector(normal),
                        });
                    }
                }
            }
        }
    }
    places
}

/// Places that keep their distance from each other.
struct Spread {
    least_m: f64,
    /// Indices of places, by the cell of a grid of that width.
    cells: HashMap<[i64; 3], Vec<usize>>,
    places: Vec<Place>,
}

impl Spread {
    /// Adds a place unless one that faces the same way is nearer than the least distance.
    fn add(&mut self, new: Place) {
        let cell = (new.position / self.least_m).floor().to_array().map(|own| own as i64);
        let around = (0..27).map(|number| [number % 3 - 1, number / 3 % 3 - 1, number / 9 - 1]);
        let mut near =
            around.filter_map(|by: [i64; 3]| self.cells.get(&[0, 1, 2].map(|axis| cell[axis] + by[axis]))).flatten();
        // Grid points that should be this far apart may be closer by rounding.
        let least_m = self.least_m * (1.0 - 1e-6);
        let is_taken = near.any(|other| {
            let other = &self.places[*other];
            other.position.distance(new.position) < least_m && other.normal.dot(new.normal) > 0.0
        });
        if !is_taken {
            self.cells.entry(cell).or_default().push(self.places.len());
            self.places.push(new);
        }
    }
}

impl Surface {
    fn buries(&self, point: DVec3) -> bool {
        self.distance_m(point) < -BURIED_M
    }

    /// Whether something can press on a taxel: it is on the surface of all shapes together, and faces out.
    fn is_open(&self, place: &Place) -> bool {
        !self.buries(place.position) && self.facing_cosine(place.position, place.normal) > FACING_COSINE
    }
}

/// For each place the link whose shapes cover it: its own, or another one that does so in the start posture and with all
/// joints at the lower or at the upper end of the controller's limits. An error if there are some and none may be left out.
fn covered<'a>(arm: &'a Arm, link: usize, places: &[Place], new: &NewPatch) -> Result<Vec<Option<&'a str>>, String> {
    let end = |end: usize| arm.joints.iter().map(|joint| joint.controller_limits_rad[end]).collect::<Vec<f64>>();
    let poses = [arm.start_posture_rad(), end(0), end(1)].map(|posture| arm.forward_kinematics(&posture));
    let surfaces: Vec<Surface> = arm.links.iter().map(Surface::of).collect();
    let covers = |other: usize, place: &Place| match other == link {
        true => !surfaces[link].is_open(place),
        false => poses.iter().all(|poses| {
            surfaces[other].buries(poses[other].inverse_transform_point(poses[link].transform_point(place.position)))
        }),
    };
    let coverer = |place: &Place| (0..surfaces.len()).find(|other| covers(*other, place));
    let name = |place: &Place| coverer(place).map(|other| arm.links[other].name.as_str());
    let covered: Vec<_> = places.iter().map(name).collect();
    if new.prune || covered.iter().all(Option::is_none) { Ok(covered) } else { Err(listed(&covered)) }
}

/// All taxels that nothing can touch, by what covers them.
fn listed(covered: &[Option<&str>]) -> String {
    let mut by_link: Vec<(&str, Vec<usize>)> = Vec::new();
    for (taxel, link) in covered.iter().enumerate() {
        let Some(link) = link else { continue };
        match by_link.iter_mut().find(|(other, _)| other == link) {
            Some((_, taxels)) => taxels.push(taxel),
            None => by_link.push((link, vec![taxel])),
        }
    }
    let count: usize = by_link.iter().map(|(_, taxels)| taxels.len()).sum();
    let list = |(link, taxels): &(&str, Vec<usize>)| format!("{} inside of {link} ({})", taxels.len(), runs(taxels));
    let lists = by_link.iter().map(list).collect::<Vec<_>>().join("; ");
    format!("{count} of {} taxels cannot be touched: {lists}", covered.len())
}

/// Ascending numbers, with a dash for those that follow each other: `3-7, 9`.
fn runs(numbers: &[usize]) -> String {
    let runs = numbers.chunk_by(|one, next| one + 1 == *next).map(|run| match run {
        [one] => one.to_string(),
        run => format!("{}-{}", run[0], run[run.len() - 1]),
    });
    runs.collect::<Vec<_>>().join(", ")
}
