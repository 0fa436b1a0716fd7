//! Colours and light, those of the replay page (`replay/page/src/colours.ts` and `view/light.ts`).

use std::sync::LazyLock;

use glam::Vec3;
use underbrush_recording::math;

/// What is behind everything.
pub const GROUND: &str = "#f0f3f5";
/// Links of the arm.
pub const ARM: &str = "#7d8995";
/// Taxels that read no force.
pub const PLATE: &str = "#b9c2ca";
/// The goal.
pub const GOAL: &str = "#1f5fbf";
/// What is fixed on a controller's map. What is doubtful has the colour of the goal.
pub const FIXED: &str = "#1c2329";
/// What gives way on a controller's map.
pub const YIELDING: &str = "#1b8a4b";
/// An arrow.
pub const ARROW: &str = "#1c2329";
/// An arrow where a taxel senses more than the controller's limit.
pub const OVER: &str = "#c8102e";
/// The table, and the lines on it.
pub const TABLE: &str = "#d9cfc0";
const CATEGORIES: [(&str, &str); 4] =
    [("leaf", "#1b8a4b"), ("trunk", "#6b4423"), ("block", "#a8904a"), ("outlier", "#c8102e")];
const FURTHER: [&str; 4] = ["#8c4fb3", "#b58900", "#0b7285", "#cc79a7"];
/// Forces from none to the largest; the scale follows the square root.
const RAMP: [&str; 6] = ["#e9edf1", "#fdd98c", "#f79646", "#d9472f", "#9b1b4b", "#4a0d4f"];

/// Direction to the lamp, of length 1, world frame.
pub const LAMP: Vec3 = Vec3::new(-0.2242, -0.5231, 0.8222);
/// Light from above, of the light from all around. It is darker than on the page, which has no shadows.
const AROUND: f32 = 0.52;
/// Light from below, as a share of that from above.
const BELOW: f32 = 0.72;
/// Light of the lamp on a surface that faces it.
const DIRECT: f32 = 0.86;

/// Light from all around and from the lamp on a surface with this normal. A thin surface is lit from either side.
pub fn light_on(normal: Vec3, thin: bool) -> [f32; 2] {
    let facing = normal.dot(LAMP);
    if thin {
        return [AROUND * (0.5 + 0.5 * BELOW), DIRECT * facing.abs()];
    }
    [AROUND * (BELOW + (1.0 - BELOW) * (0.5 + 0.5 * normal.z)), DIRECT * facing.max(0.0)]
}

/// A colour such as #1b8a4b as linear light.
pub fn linear(colour: &str) -> Vec3 {
    light_of(bytes(colour))
}

/// The linear light of red, green and blue from 0 to 255.
fn light_of(bytes: [u8; 3]) -> Vec3 {
    Vec3::from(bytes.map(|byte| {
        let share = f64::from(byte) / 255.0;
        let light = if share <= 0.04045 { share / 12.92 } else { math::powf((share + 0.055) / 1.055, 2.4) };
        light as f32
    }))
}

fn bytes(colour: &str) -> [u8; 3] {
    [1, 3, 5].map(|at| u8::from_str_radix(colour.get(at..at + 2).unwrap_or_default(), 16).unwrap_or_default())
}

/// Steps of the table from linear light to what a screen shows.
const STEPS: usize = 4096;
static SHOWN: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let shown =
        |light: f64| if light <= 0.0031308 { 12.92 * light } else { 1.055 * math::powf(light, 1.0 / 2.4) - 0.055 };
    (0..=STEPS).map(|step| (255.0 * shown(step as f64 / STEPS as f64)).round() as u8).collect()
});

/// Linear light as a screen shows it.
pub fn shown(light: Vec3) -> [u8; 3] {
    let table = &*SHOWN;
    light.to_array().map(|light| table[(light.clamp(0.0, 1.0) * STEPS as f32 + 0.5) as usize])
}

/// The colour of a category. `further` are the names of those that have no colour of their own, each once.
pub fn of_category(name: &str, further: &[&str]) -> Vec3 {
    let known = CATEGORIES.iter().find(|(own, _)| *own == name).map(|(_, colour)| *colour);
    let place = further.iter().position(|own| *own == name).unwrap_or_default();
    linear(known.unwrap_or(FURTHER[place % FURTHER.len()]))
}

/// Whether a category has a colour of its own.
pub fn is_known(name: &str) -> bool {
    CATEGORIES.iter().any(|(own, _)| *own == name)
}

/// The colour of a share of the largest force.
pub fn of_force(share: f64) -> Vec3 {
    let at = share.clamp(0.0, 1.0).sqrt() * (RAMP.len() - 1) as f64;
    let low = (at as usize).min(RAMP.len() - 2);
    let (from, to) = (bytes(RAMP[low]), bytes(RAMP[low + 1]));
    light_of([0, 1, 2].map(|axis| {
        let (from, to) = (f64::from(from[axis]), f64::from(to[axis]));
        (from + (to - from) * (at - low as f64)).round() as u8
    }))
}
