//! The tactile sensors: from the true forces on the taxels to their readings, frame by frame.
//!
//! | patch | stages |
//! |---|---|
//! | capacitive | crosstalk → creep → spurious readings → noise → gate and floor → quantum → saturation |
//! | fabric | hysteresis → saturating response → noise → gate → counts |
//! | both | before: bandwidth → gain → drift; after: dead taxels → delay |
//!
//! With `response = "conductance"`, fabric starts from the evenly spread force that would give the same conductance as the true
//! pressures.

use std::ops::Range;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use underbrush_recording::SkinLayout;

mod capacitive;
mod fabric;
mod limits;
mod options;
mod shared;
#[cfg(test)]
mod tests;

use crate::arm::Skin;
use crate::arm::skin::Technology;
use crate::seed::stream;
use capacitive::Capacitive;
use fabric::Fabric;
pub use options::{FabricOptions, FabricResponse, OptionFault, SensorModel, SensorOptions};
use shared::Transducers;

/// The electronics of one patch.
#[derive(Clone, Serialize, Deserialize)]
enum Electronics {
    Capacitive(Capacitive),
    Fabric(Fabric),
}

/// The sensors of one reach. In every frame the pressed taxels are reported, then all taxels are sampled, then read.
///
/// Every taxel is sampled in every frame, in the same order, so that the noise of one does not depend on what touches
/// another.
///
/// ```
/// use underbrush_sim::arm::Arm;
/// use underbrush_sim::sensor::{Sensor, SensorOptions};
///
/// let arm = Arm::cody()?;
/// let mut sensor = Sensor::new(&SensorOptions::default(), &arm.skin, 1, "an example", 0);
/// // 2 N on the tenth taxel of the first patch for half a second.
/// for _ in 0..50 {
///     sensor.press(0, 10, 2.0);
///     sensor.sample();
/// }
/// assert!(sensor.reading_n(0, 10) > 0.5);
/// # Ok::<(), underbrush_recording::InputError>(())
/// ```
#[derive(Clone, Serialize, Deserialize)]
pub struct Sensor {
    /// Electronics of each patch, in the layout's order, and the indices of its taxels in the vectors below.
    patches: Vec<(Electronics, Range<usize>)>,
    transducers: Transducers,
    dead: Vec<bool>,
    true_force_n: Vec<f64>,
    /// Ring buffer of the last frames of readings, one more than the delay.
    readings_n: Vec<Vec<f64>>,
    newest: usize,
    random: ChaCha8Rng,
    /// A stream of its own, so that spurious readings do not shift the noise.
    random_spurious: ChaCha8Rng,
}

impl Sensor {
    /// The sensors of reach number `reach_index`; they draw from the streams `sensor`, `strays`, `dead taxels` and
    /// `transducers`.
    pub fn new(options: &SensorOptions, skin: &Skin, seed: u64, scene: &str, reach_index: u64) -> Self {
        let options = &options.effective();
        let mut taxels = 0;
        let mut patches = Vec::with_capacity(skin.layout.patches.len());
        for (patch, surface) in skin.layout.patches.iter().zip(&skin.surfaces) {
            let electronics = match surface.technology {
                Technology::Capacitive => Electronics::Capacitive(Capacitive::new(options, patch)),
                Technology::Fabric => Electronics::Fabric(Fabric::new(&options.fabric, &patch.taxels)),
            };
            let first = taxels;
            taxels += patch.taxels.len();
            patches.push((electronics, first..taxels));
        }
        let frames = 1 + options.delay_frames as usize;
        let mut drawn = stream(seed, scene, reach_index, "dead taxels");
        Sensor {
            patches,
            transducers: Transducers::new(options, taxels, stream(seed, scene, reach_index, "transducers")),
            dead: dead_taxels(options, &skin.layout, &mut drawn),
            true_force_n: vec![0.0; taxels],
            readings_n: vec![vec![0.0; taxels]; frames],
            newest: 0,
            random: stream(seed, scene, reach_index, "sensor"),
            // The name of the stream decides the random numbers, so the stream keeps its earlier name.
            random_spurious: stream(seed, scene, reach_index, "strays"),
        }
    }

    /// Adds to the true normal force on a taxel in the frame that is sampled next, N.
    pub fn press(&mut self, patch: usize, taxel: usize, normal_force_n: f64) {
        self.true_force_n[self.patches[patch].1.start + taxel] += normal_force_n;
    }

    /// Whether the readings of a patch depend on where on a taxel a force acts. Its taxels then take [`Sensor::press_parts`].
    pub fn feels_parts(&self, patch: usize) -> bool {
        matches!(&self.patches[patch].0, Electronics::Fabric(fabric) if fabric.feels_parts())
    }

    /// Presses parts of a taxel: `(normal force, area)`, N and m². A patch that does not feel parts takes their sum.
    pub fn press_parts(&mut self, patch: usize, taxel: usize, parts: impl Iterator<Item = (f64, f64)>) {
        let force_n = match &self.patches[patch].0 {
            Electronics::Fabric(fabric) => fabric.even_force_n(taxel, parts),
            Electronics::Capacitive(_) => parts.map(|(force_n, _)| force_n).sum(),
        };
        self.press(patch, taxel, force_n);
    }

    /// Samples all taxels once and clears the true forces.
    pub fn sample(&mut self) {
        self.newest = (self.newest + 1) % self.readings_n.len();
        let newest = &mut self.readings_n[self.newest];
        self.transducers.apply(&mut self.true_force_n);
        for (electronics, span) in &mut self.patches {
            let (force, reading) = (&self.true_force_n[span.clone()], &mut newest[span.clone()]);
            match electronics {
                Electronics::Capacitive(taxels) => {
                    taxels.read(force, reading, &mut self.random, &mut self.random_spurious);
                }
                Electronics::Fabric(taxels) => taxels.read(force, reading, &mut self.random),
            }
        }
        for (reading, dead) in newest.iter_mut().zip(&self.dead).filter(|(reading, _)| **reading != 0.0) {
            // Data sets store readings in single precision. Controllers and online classifiers get the same numbers.
            *reading = if *dead { 0.0 } else { f64::from(*reading as f32) };
        }
        self.true_force_n.fill(0.0);
    }

    /// The readings of the taxels of a patch after the last sample, N.
    pub fn readings_n(&self, patch: usize) -> &[f64] {
        // The slot after the newest holds the oldest.
        &self.readings_n[(self.newest + 1) % self.readings_n.len()][self.patches[patch].1.clone()]
    }

    /// A taxel's reading after the last sample, N.
    pub fn reading_n(&self, patch: usize, taxel: usize) -> f64 {
        self.readings_n(patch)[taxel]
    }
}

/// Which taxels are dead: those listed and those drawn. A number is drawn for a listed taxel too, so that listing it
/// does not change the draws of those after it.
fn dead_taxels(options: &SensorOptions, layout: &SkinLayout, drawn: &mut ChaCha8Rng) -> Vec<bool> {
    let of_patch = layout.patches.iter().flat_map(|patch| {
        let listed = options.dead_taxels.get(&patch.name);
        (0..patch.taxels.len())
            .map(move |taxel| listed.is_some_and(|listed| listed.iter().any(|dead| usize::from(*dead) == taxel)))
    });
    of_patch.map(|listed| drawn.random_bool(options.dead_share) || listed).collect()
}
