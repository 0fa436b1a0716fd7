//! One line of the live stream: a frame of the skin, checked as far as the model uses it.

use glam::DVec3;
use underbrush_recording::limits::{Limits, POSITION_M, SENSED_FORCE_N, TIME_S};
use underbrush_recording::{Frame, Pose, SkinLayout, TaxelReading, unit_quaternion};

use super::json::{self, LineError, Spot};

/// The content of a line.
#[derive(Debug, PartialEq)]
pub enum Message {
    /// A frame of the skin. All other fields are empty or zero.
    Frame(Box<Frame>),
    /// A new reach begins: contacts of the last one end, and time may start again.
    Reset,
}

/// Reads the lines of one stream.
///
/// ```
/// use underbrush_exchange::live::{LineParser, Message};
/// use underbrush_recording::{Patch, SkinLayout, Taxel};
/// use glam::DVec3;
///
/// let taxel = Taxel { position_link: DVec3::ZERO, normal_link: DVec3::Z, tangent_link: DVec3::X, area_m2: 1e-4 };
/// let patch = Patch { name: "sleeve".into(), link: "arm".into(), grid: None, taxels: vec![taxel; 4] };
/// let mut parser = LineParser::new(SkinLayout { patches: vec![patch] }, None);
/// let line = r#"{"time_s": 0.01, "taxels": [{"taxel": 2, "sensed_force_n": 0.4}]}"#;
/// let Ok(Message::Frame(frame)) = parser.parse(1, line) else { panic!("a frame") };
/// assert_eq!(frame.taxels[0].sensed_force_n, 0.4);
/// // A fault names its field.
/// let error = parser.parse(2, r#"{"time_s": 0.02, "taxels": [{"taxel": 9, "sensed_force_n": 1}]}"#).unwrap_err();
/// assert_eq!(error.field, "taxels[0].taxel");
/// ```
#[derive(Clone, Debug)]
pub struct LineParser {
    layout: SkinLayout,
    /// The patches whose poses are needed; none for models that do not use motion.
    poses_of: Vec<usize>,
    /// Time and number of the last good line.
    last: Option<(f64, usize)>,
}

impl LineParser {
    /// A parser for streams of this skin; `poses_of` are the patches whose poses the models need.
    pub fn new(layout: SkinLayout, poses_of: impl IntoIterator<Item = usize>) -> Self {
        LineParser { layout, poses_of: poses_of.into_iter().collect(), last: None }
    }

    /// Maximum length of a line, bytes. Choice: a reading with its ground truth takes about 200 bytes.
    pub fn max_bytes(&self) -> usize {
        65_536 + 1024 * self.layout.taxel_count()
    }

    /// Reads the line with this number. A line with an error changes nothing.
    ///
    /// # Errors
    /// [`LineError`] with the field, if the line is not JSON, or a field is missing or not allowed.
    pub fn parse(&mut self, number: usize, text: &str) -> Result<Message, LineError> {
        let value = json::parse(text)?;
        let line = Spot { path: String::new(), value: &value }.object("one JSON object")?;
        if let Some(reset) = line.get("reset") {
            if *reset.value != true || line.keys().count() > 1 {
                return Err(reset.error("true, in a line of its own"));
            }
            self.last = None;
            return Ok(Message::Reset);
        }
        let time_s = self.time_s(&line)?;
        let taxels = self.readings(&line)?;
        let mut frame = Frame { time_s, taxels, ..Frame::blank(self.layout.patches.len()) };
        // Only the poses that the models need are read; the others are at the origin.
        for &needed in &self.poses_of {
            frame.patch_pose_world[needed] = self.pose(&line, needed)?;
        }
        self.last = Some((time_s, number));
        Ok(Message::Frame(Box::new(frame)))
    }

    fn time_s(&self, line: &Spot<'_>) -> Result<f64, LineError> {
        let spot = line.need("time_s", "the time of the frame in seconds")?;
        let time_s = number(&spot, TIME_S)?;
        match self.last {
            Some((last_s, last_line)) if time_s <= last_s => Err(spot.error(format!(
                "later than {last_s} s, the time of line {last_line}; for a new reach send {{\"reset\":true}} first"
            ))),
            _ => Ok(time_s),
        }
    }

    /// The readings, sorted by patch and taxel.
    fn readings(&self, line: &Spot<'_>) -> Result<Vec<TaxelReading>, LineError> {
        let allowed = "a list of readings, empty where nothing is felt";
        let list = line.need("taxels", allowed)?.list(allowed)?;
        let mut readings = Vec::with_capacity(list.len());
        for spot in list {
            let reading = spot.object("an object with patch, taxel and sensed_force_n")?;
            let patch = self.patch(&reading)?;
            let last_taxel = self.layout.patches[patch].taxels.len().saturating_sub(1);
            let allowed = format!("a taxel of patch {}: 0 to {last_taxel}", self.layout.patches[patch].name);
            let taxel_spot = reading.need("taxel", &allowed)?;
            let taxel = taxel_spot.index().filter(|taxel| *taxel <= last_taxel);
            let place = taxel.and_then(|taxel| Some((u16::try_from(patch).ok()?, u16::try_from(taxel).ok()?)));
            let (patch, taxel) = place.ok_or_else(|| taxel_spot.error(allowed))?;
            let force = reading.need("sensed_force_n", "the normal force in newtons")?;
            let sensed_force_n = number(&force, SENSED_FORCE_N)?;
            readings.push((TaxelReading { patch, taxel, sensed_force_n, ..TaxelReading::default() }, taxel_spot));
        }
        let place = |(reading, _): &(TaxelReading, Spot<'_>)| (reading.patch, reading.taxel);
        readings.sort_by_key(place);
        if let Some([first, twice]) = readings.array_windows().find(|[first, second]| place(first) == place(second)) {
            return Err(twice.1.error(format!("each taxel once; {} names it, too", first.1.path)));
        }
        Ok(readings.into_iter().map(|(reading, _)| reading).collect())
    }

    /// The patch of a reading, by name or index. It need not be given if the skin has only one patch.
    fn patch(&self, reading: &Spot<'_>) -> Result<usize, LineError> {
        let patches = &self.layout.patches;
        if patches.len() == 1 && reading.get("patch").is_none() {
            return Ok(0);
        }
        let known: Vec<String> =
            patches.iter().enumerate().map(|(index, patch)| format!("{index} or {:?}", patch.name)).collect();
        let allowed = format!("a patch of the skin: {}", known.join(", "));
        let spot = reading.need("patch", &allowed)?;
        let index = match spot.value.as_str() {
            Some(name) => self.layout.patch_index(name),
            None => spot.index(),
        };
        index.filter(|index| *index < patches.len()).ok_or_else(|| spot.error(allowed))
    }

    /// The pose of a patch.
    fn pose(&self, line: &Spot<'_>, needed: usize) -> Result<Pose, LineError> {
        let patches = &self.layout.patches;
        let name = &patches[needed].name;
        let allowed = format!(
            "the pose of patch {name}, as this model uses motion: {{{name:?}: pose}}, or a list of {} poses in the \
             order of the patches",
            patches.len()
        );
        let spot = line.need("patch_pose_world", &allowed)?;
        let pose = if spot.value.is_object() {
            if let Some(unknown) = spot.keys().find(|key| self.layout.patch_index(key).is_none()) {
                let names: Vec<&str> = patches.iter().map(|patch| patch.name.as_str()).collect();
                return Err(spot.unknown(unknown, format!("names of patches: {}", names.join(", "))));
            }
            spot.need(name, &allowed)?
        } else {
            let list = spot.list(&allowed)?;
            if list.len() != patches.len() {
                return Err(spot.error(allowed));
            }
            list[needed].clone()
        };
        read_pose(pose)
    }
}

fn read_pose(spot: Spot<'_>) -> Result<Pose, LineError> {
    let allowed = "an object with position and orientation";
    let pose = spot.object(allowed)?;
    let allowed = "x, y and z in metres";
    let position = pose.need("position", allowed)?;
    let coordinates: [f64; 3] = position.numbers(allowed)?;
    if !coordinates.iter().all(|value| POSITION_M.hold(*value)) {
        return Err(position.error(format!("{allowed}, each from {POSITION_M}")));
    }
    let allowed = "a quaternion x, y, z, w of length 1, from the patch's frame to the world's";
    let orientation = pose.need("orientation", allowed)?;
    let unit = unit_quaternion(orientation.numbers(allowed)?).ok_or_else(|| orientation.error(allowed))?;
    Ok(Pose::new(DVec3::from_array(coordinates), unit))
}

fn number(spot: &Spot<'_>, limits: Limits) -> Result<f64, LineError> {
    spot.value.as_f64().filter(|value| limits.hold(*value)).ok_or_else(|| spot.error(format!("a number from {limits}")))
}

#[cfg(test)]
mod tests;
