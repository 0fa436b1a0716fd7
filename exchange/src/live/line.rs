//! One line of the live stream: a frame of the skin, checked as far as the model uses it.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Deserialize;
use serde_json::{Map, Value};
use underbrush_recording::limits::{Limits, POSITION_M, SENSED_FORCE_N, TIME_S};
use underbrush_recording::{Frame, Pose, SkinLayout, TaxelReading, shortened, unit_quaternion};

use super::json::{self, LineError, MAX_QUOTED};

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
        let line = json::parse(text)?;
        let fault = |key: &str, allowed: &str| LineError::at(key, &line[key], allowed);
        if !line["reset"].is_null() {
            if line != serde_json::json!({ "reset": true }) {
                return Err(fault("reset", "true, in a line of its own"));
            }
            self.last = None;
            return Ok(Message::Reset);
        }
        let time_s = within(TIME_S, &line["time_s"]).map_err(|allowed| fault("time_s", &allowed))?;
        if let Some((last_s, last_line)) = self.last
            && time_s <= last_s
        {
            let allowed = format!(
                "later than {last_s} s, the time of line {last_line}; for a new reach send {{\"reset\":true}} first"
            );
            return Err(fault("time_s", &allowed));
        }
        let sent = line["taxels"].as_array();
        let sent = sent.ok_or_else(|| fault("taxels", "a list of readings, empty where nothing is felt"))?;
        let taxels = self.readings(sent)?;
        let mut frame = Frame { time_s, taxels, ..Frame::blank(self.layout.patches.len()) };
        // Only the poses that the models need are read; the others are at the origin.
        for &needed in &self.poses_of {
            frame.patch_pose_world[needed] = self.pose(&line["patch_pose_world"], needed)?;
        }
        self.last = Some((time_s, number));
        Ok(Message::Frame(Box::new(frame)))
    }

    /// The readings, sorted by patch and taxel.
    fn readings(&self, sent: &[Value]) -> Result<Vec<TaxelReading>, LineError> {
        let mut readings = BTreeMap::new();
        for (index, reading) in sent.iter().enumerate() {
            if !reading.is_object() {
                let allowed = "an object with patch, taxel and sensed_force_n";
                return Err(LineError::at(format!("taxels[{index}]"), reading, allowed));
            }
            let fault =
                |key: &str, allowed: &str| LineError::at(format!("taxels[{index}].{key}"), &reading[key], allowed);
            let patch = self.patch(&reading["patch"]).map_err(|allowed| fault("patch", &allowed))?;
            let touched = &self.layout.patches[usize::from(patch)];
            let count = touched.taxels.len();
            let taxel = u16::deserialize(&reading["taxel"]).ok().filter(|taxel| usize::from(*taxel) < count);
            let range = || match count.checked_sub(1) {
                Some(last) => format!("a taxel of patch {}: 0 to {last}", touched.name),
                None => format!("no reading of patch {}, which has no taxels", touched.name),
            };
            let taxel = taxel.ok_or_else(|| fault("taxel", &range()))?;
            let force_n = within(SENSED_FORCE_N, &reading["sensed_force_n"]);
            let sensed_force_n = force_n.map_err(|allowed| fault("sensed_force_n", &allowed))?;
            let felt = TaxelReading { patch, taxel, sensed_force_n, ..TaxelReading::default() };
            if let Some((_, first)) = readings.insert((patch, taxel), (felt, index)) {
                return Err(fault("taxel", &format!("each taxel once; taxels[{first}].taxel names it, too")));
            }
        }
        Ok(readings.into_values().map(|(felt, _)| felt).collect())
    }

    /// The patch with this name or index, or what is allowed. It need not be given if the skin has only one patch.
    fn patch(&self, sent: &Value) -> Result<u16, String> {
        let patches = &self.layout.patches;
        let index = match sent {
            Value::Null if patches.len() == 1 => Some(0),
            Value::String(name) => self.layout.patch_index(name),
            index => usize::deserialize(index).ok().filter(|index| *index < patches.len()),
        };
        index.and_then(|index| u16::try_from(index).ok()).ok_or_else(|| {
            let known = patches.iter().enumerate().map(|(index, patch)| format!("{index} or {:?}", patch.name));
            format!("a patch of the skin: {}", known.collect::<Vec<_>>().join(", "))
        })
    }

    /// The pose of a patch.
    fn pose(&self, sent: &Value, needed: usize) -> Result<Pose, LineError> {
        let names: Vec<&str> = self.layout.patches.iter().map(|patch| &*patch.name).collect();
        let mut keys = sent.as_object().into_iter().flat_map(Map::keys);
        if let Some(unknown) = keys.find(|key| !names.contains(&key.as_str())) {
            let found = format!("key {:?}", shortened(unknown, MAX_QUOTED));
            return Err(LineError::new("patch_pose_world", found, format!("names of patches: {}", names.join(", "))));
        }
        let name = names[needed];
        let (field, pose) = match sent {
            Value::Object(_) => (format!("patch_pose_world.{name}"), &sent[name]),
            Value::Array(list) if list.len() == names.len() => (format!("patch_pose_world[{needed}]"), &list[needed]),
            _ => ("patch_pose_world".to_owned(), sent),
        };
        if !pose.is_object() {
            let allowed = format!(
                "the pose of patch {name}, as this model uses motion: {{{name:?}: pose}}, or a list of {} poses in the \
                 order of the patches",
                names.len()
            );
            return Err(LineError::at(field, pose, allowed));
        }
        let fault = |key: &str, allowed: &str| LineError::at(format!("{field}.{key}"), &pose[key], allowed);
        let position = <[f64; 3]>::deserialize(&pose["position"]).ok();
        let position = position.filter(|position| position.iter().all(|own| POSITION_M.hold(*own)));
        let allowed = || format!("x, y and z in metres, each from {POSITION_M}");
        let position = position.ok_or_else(|| fault("position", &allowed()))?;
        let orientation = <[f64; 4]>::deserialize(&pose["orientation"]).ok().and_then(unit_quaternion);
        let allowed = "a quaternion x, y, z, w of length 1, from the patch's frame to the world's";
        let orientation = orientation.ok_or_else(|| fault("orientation", allowed))?;
        Ok(Pose::new(DVec3::from_array(position), orientation))
    }
}

/// A number within its limits, or what is allowed.
fn within(limits: Limits, sent: &Value) -> Result<f64, String> {
    sent.as_f64().filter(|number| limits.hold(*number)).ok_or_else(|| format!("a number from {limits}"))
}

#[cfg(test)]
mod tests;
