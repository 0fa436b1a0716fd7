//! Makes recordings of the frames of a log, with what the mapping says of the skin. Labels take the place of ground truth.

use std::path::Path;

use glam::DVec3;
use underbrush_recording::fault::line_of_row;
use underbrush_recording::limits::{MAX_TAXELS, TEXT_BYTES, short};
use underbrush_recording::math::median;
use underbrush_recording::{
    Body, BodyOwner, Category, Contact, Frame, InputError, ObjectRecord, Patch, Pose, Recording, SkinLayout, Taxel,
    TaxelReading, read_bytes,
};

use super::Mapping;
use super::cutter::Place;
use super::time_grid::TimeGrid;

/// The name of frames in which nothing presses, whatever the skin reads.
const NOTHING: &str = "nothing";
/// Skin that moves faster than this has poses in another unit, m/s. Choice: far above the speed of robot arms.
const FASTEST_M_PER_S: f64 = 20.0;
/// How much the rates of the reaches of one log may differ, relatively.
const RATE_DIFFERENCE: f64 = 0.02;
/// A larger share of missing frames is warned of. Choice: more than a busy logger loses.
const MANY_MISSING: f64 = 0.1;
/// The columns of the file of taxels.
const TAXEL_COLUMNS: [&str; 7] = ["x_m", "y_m", "z_m", "normal_x", "normal_y", "normal_z", "area_m2"];
/// The largest size of a number in each of these columns: of places, m, and areas, m², as in skin files, so that numbers in
/// millimetres are noticed.
const LARGEST: [f64; 7] = [5.0, 5.0, 5.0, 1e3, 1e3, 1e3, 0.25];

/// Takes frames one after another and makes a recording of each reach.
pub(super) struct Recorder<'a> {
    mapping: &'a Mapping,
    layout: SkinLayout,
    /// The log. Its name takes the place of the scene.
    path: &'a Path,
    reaches: Vec<Recording>,
    /// The line of each frame.
    lines: Vec<usize>,
    /// The largest speed of the skin, m/s, and the line of its frame.
    fastest: (f64, usize),
    /// The categories so far.
    categories: Vec<Category>,
    /// The category of the frame before, and its object.
    label: String,
    object: Option<u16>,
}

impl<'a> Recorder<'a> {
    /// A recorder with the taxels of the mapping's file.
    pub(super) fn new(path: &'a Path, mapping: &'a Mapping) -> Result<Self, InputError> {
        let allowed =
            "the file of the taxels' places, for recordings in a folder; a table of trials is called .csv or .parquet";
        let file = mapping.taxels_file().ok_or_else(|| mapping.fault("skin.taxels", "nothing".into(), allowed))?;
        let name = mapping.file.trial.patch.clone().unwrap_or_else(|| "skin".into());
        let taxels = read_taxels(&file)?;
        let expected = mapping.taxels();
        if taxels.len() != expected {
            let found = format!("{} rows in {}", taxels.len(), file.display());
            return Err(mapping.fault("skin.taxels", found, format!("a row for each of {expected} taxels")));
        }
        let layout = SkinLayout { patches: vec![Patch { link: name.clone(), name, grid: mapping.grid, taxels }] };
        Ok(Recorder {
            mapping,
            layout,
            path,
            reaches: Vec::new(),
            lines: Vec::new(),
            fastest: (0.0, 0),
            categories: Vec::new(),
            label: String::new(),
            object: None,
        })
    }

    /// Adds a frame with the reading of each taxel, in the file's unit, and the pose of the skin: place, m, and quaternion x, y,
    /// z, w.
    pub(super) fn push(&mut self, place: &Place, readings: &[f64], pose: Option<[f64; 7]>) -> Result<(), InputError> {
        if self.reaches.last().is_none_or(|last| last.reach_index != place.reach) {
            self.reaches.push(self.empty(place.reach));
            self.label.clear();
            self.object = None;
        }
        self.lines.push(place.line);
        let Some(reach) = self.reaches.last_mut() else { return Ok(()) };
        let forces_n = readings.iter().map(|reading| self.mapping.force_n(*reading).max(0.0));
        let pressed_n = |force_n: f64| if force_n > self.mapping.threshold_n { force_n } else { 0.0 };
        if place.category.is_empty() && forces_n.clone().any(|force_n| pressed_n(force_n) > 0.0) {
            let remedy = format!("name it in the log or in a [[label]], or call it `{NOTHING}` if nothing pressed");
            let allowed = format!("the category of what presses, or `{NOTHING}`");
            let fault = InputError::new(self.path, "category", "a frame with forces and none", allowed, remedy);
            return Err(fault.at_line(place.line));
        }
        if self.label != place.category {
            self.label = place.category.to_owned();
            self.object = None;
            if !self.label.is_empty() && self.label != NOTHING {
                let Some(category) = category(&self.label, &mut self.categories) else {
                    let allowed = "up to 24 lower-case letters, digits and _, which begin with a letter, and not none, \
                                   uncertain or unknown";
                    let found = format!("{:?}", self.label);
                    let fault = InputError::new(self.path, "category", found, allowed, "give it another name");
                    return Err(fault.at_line(place.line));
                };
                self.object = u16::try_from(reach.objects.len()).ok();
                let (kind, parameters) = (self.label.clone(), Default::default());
                reach.objects.push(ObjectRecord { kind, category, position_world: DVec3::ZERO, parameters });
            }
        }
        let pressed = |force_n: f64| self.object.filter(|_| pressed_n(force_n) > 0.0);
        let reading = |(taxel, force_n): (usize, f64)| TaxelReading {
            taxel: taxel as u16,
            sensed_force_n: force_n,
            true_normal_force_n: pressed(force_n).map_or(0.0, |_| force_n),
            object: pressed(force_n),
            ..TaxelReading::default()
        };
        let taxels = forces_n.enumerate().filter(|(_, force_n)| *force_n > 0.0).map(reading).collect();
        let pose = pose.map_or(Pose::IDENTITY, |numbers| Pose::from_numbers(&numbers));
        let pose = Pose { orientation: pose.orientation.normalize(), ..pose };
        if let Some(before) = reach.frames.last() {
            let way_m = before.end_effector_pose_world.position.distance(pose.position);
            let speed_m_per_s = way_m / (place.time_s - before.time_s);
            if speed_m_per_s > self.fastest.0 {
                self.fastest = (speed_m_per_s, place.line);
            }
        }
        let zeros = || vec![0.0];
        reach.frames.push(Frame {
            time_s: place.time_s,
            patch_pose_world: vec![pose],
            end_effector_pose_world: pose,
            taxels,
            joint_angle_rad: zeros(),
            joint_velocity_rad_per_s: zeros(),
            equilibrium_angle_rad: zeros(),
            joint_torque_nm: zeros(),
            ..Frame::blank(1)
        });
        Ok(())
    }

    /// A reach without frames. Files need a joint: one that does not move.
    fn empty(&self, reach_index: u64) -> Recording {
        let owner = BodyOwner::Link(self.layout.patches[0].link.clone());
        Recording {
            scene: self.path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            controller: Recording::UNKNOWN_CONTROLLER.into(),
            reach_index,
            rate_hz: 1.0,
            joint_names: vec!["fixed".into()],
            layout: self.layout.clone(),
            // The labels are the truth, even if they say that nothing presses: the link is known, and there are no objects.
            bodies: vec![Body { owner, parts: Vec::new(), rest_pose_world: Pose::IDENTITY, track: Vec::new() }],
            ..Recording::default()
        }
    }

    /// The recordings, at the rate of the mapping, or else that of their frames, and what is suspicious about them. Times begin
    /// at 0.
    pub(super) fn finish(self) -> Result<(Vec<Recording>, Vec<String>), InputError> {
        let Recorder { mapping, path, layout, mut reaches, .. } = self;
        let (mut lines, mut all) = (&self.lines[..], 0);
        for reach in &mut reaches {
            let (own_lines, later_lines) = lines.split_at(reach.frames.len());
            lines = later_lines;
            let times_s: Vec<f64> = reach.frames.iter().map(|frame| frame.time_s).collect();
            let grid = TimeGrid::of(&times_s, mapping.file.time.rate_hz);
            let grid = grid.map_err(|(found, allowed, frame)| {
                let remedy = "write the frames at one rate, begin a new reach there (`reach_from` of the mapping), or give the right \
                              rate as `time.rate_hz`";
                let found = format!("{found} in reach {}", reach.reach_index);
                InputError::new(path, "time", found, allowed, remedy).at_line(own_lines.get(frame).copied())
            })?;
            reach.rate_hz = grid.rate_hz;
            reach.frames = grid.filled(std::mem::take(&mut reach.frames));
            all += reach.frames.len();
            for (number, frame) in (0..).zip(&reach.frames) {
                let Some(object) = frame.taxels.iter().find_map(|own| own.object) else { continue };
                let force_n = frame.taxels.iter().map(|own| own.true_normal_force_n).sum();
                add_contact(&mut reach.contacts, object, number, force_n, &layout);
            }
        }
        let mut warnings = other_rate(&reaches).into_iter().collect::<Vec<_>>();
        let missing = all - self.lines.len();
        if missing as f64 > MANY_MISSING * all as f64 {
            warnings.push(format!(
                "{missing} of {all} frames of the recordings are missing in the log and repeat the one before: check the rate, and \
                 whether the log is whole"
            ));
        }
        let (speed_m_per_s, line) = self.fastest;
        if speed_m_per_s > FASTEST_M_PER_S {
            let speed = short(speed_m_per_s.round());
            warnings.push(format!(
                "the skin moves at {speed} m/s up to line {line}: the first three of `pose_from` are in m"
            ));
        }
        if !mapping.file.channel.is_empty() {
            warnings.push("recordings hold no channels: write a table of trials to use each [[channel]]".into());
        }
        Ok((reaches, warnings))
    }
}

/// A warning if a reach seems to have another rate than most.
fn other_rate(reaches: &[Recording]) -> Option<String> {
    // A single frame has no rate.
    let with_rate = || reaches.iter().filter(|reach| reach.frames.len() > 1);
    let usual_hz = median(with_rate().map(|reach| reach.rate_hz).collect())?;
    let other = with_rate().find(|reach| (reach.rate_hz / usual_hz - 1.0).abs() > RATE_DIFFERENCE)?;
    let (index, own, usual) = (other.reach_index, short(other.rate_hz), short(usual_hz));
    Some(format!(
        "reach {index} seems to have frames at {own} Hz, while {usual} Hz is usual in this file: if all have one rate, give it as \
         `time.rate_hz` in the mapping"
    ))
}

/// The category with this name: the one with its usual code, or with the next code that is free if another name has that.
fn category(name: &str, known: &mut Vec<Category>) -> Option<Category> {
    if let Some(category) = known.iter().find(|own| own.name() == name) {
        return Some(*category);
    }
    let further = (0..=i8::MAX).filter_map(|code| Category::from_file(name, code));
    let is_free = |own: &Category| known.iter().all(|other| other.code() != own.code());
    let category = std::iter::once(Category::named(name)?).chain(further).find(is_free)?;
    known.push(category);
    Some(category)
}

/// Goes on with the last contact, if it is with the same object and had not ended, or begins one.
fn add_contact(contacts: &mut Vec<Contact>, object: u16, frame: u32, force_n: f64, layout: &SkinLayout) {
    let goes_on = |last: &&mut Contact| last.object == object && last.last_frame + 1 == frame;
    if let Some(last) = contacts.last_mut().filter(goes_on) {
        let frames = f64::from(frame - last.first_frame);
        last.mean_force_n += (force_n - last.mean_force_n) / (frames + 1.0);
        last.peak_force_n = last.peak_force_n.max(force_n);
        last.last_frame = frame;
        return;
    }
    contacts.push(Contact {
        link: layout.patches[0].link.clone(),
        patch: Some(0),
        object,
        first_frame: frame,
        last_frame: frame,
        peak_force_n: force_n,
        mean_force_n: force_n,
    });
}

/// Reads the places of taxels.
fn read_taxels(path: &Path) -> Result<Vec<Taxel>, InputError> {
    let text =
        read_bytes(path, &TEXT_BYTES, "a CSV file with a row for each taxel", "check `skin.taxels` of the mapping")?;
    let remedy = "correct the file of the taxels";
    let fault = |field: &str, found: String, allowed: &str| InputError::new(path, field, found, allowed, remedy);
    let unreadable = |error: csv::Error| InputError::of_csv(path, "CSV", &text, error, remedy);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(&text[..]);
    let names = reader.headers().map_err(unreadable)?.clone();
    let mut columns = [0; 7];
    for (column, name) in columns.iter_mut().zip(TAXEL_COLUMNS) {
        let missing = || fault("columns", names.iter().collect::<Vec<_>>().join(", "), &TAXEL_COLUMNS.join(", "));
        *column = names.iter().position(|own| own == name).ok_or_else(missing)?;
    }
    let mut taxels = Vec::new();
    for row in reader.records().take(MAX_TAXELS + 1) {
        let row = row.map_err(unreadable)?;
        let line = row.position().map(|position| line_of_row(&text, position));
        let mut numbers = [0.0; 7];
        for (place, number) in numbers.iter_mut().enumerate() {
            let (cell, most) = (row.get(columns[place]).unwrap_or_default(), LARGEST[place]);
            let parsed = cell.parse().ok().filter(|number: &f64| number.abs() <= most);
            let allowed = format!("a number up to {most}");
            let wrong = || fault(TAXEL_COLUMNS[place], format!("{cell:?}"), &allowed).at_line(line);
            *number = parsed.ok_or_else(wrong)?;
        }
        let [x, y, z, normal_x, normal_y, normal_z, area_m2] = numbers;
        let normal = DVec3::new(normal_x, normal_y, normal_z);
        let Some(normal_link) = normal.try_normalize().filter(|_| area_m2 > 0.0) else {
            let found = format!("{normal}, {}", short(area_m2));
            return Err(fault("normal, area_m2", found, "a normal that is not zero, and an area above 0").at_line(line));
        };
        let tangent_link = normal_link.any_orthonormal_vector();
        taxels.push(Taxel { position_link: DVec3::new(x, y, z), normal_link, tangent_link, area_m2 });
    }
    Ok(taxels)
}
