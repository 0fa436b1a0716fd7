//! Options of the sensor: the `[sensor]` section of a scene file.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::SkinLayout;
use underbrush_recording::limits::{first_outside, short};

use super::limits;
use crate::range::{Within, options};

options! {
    // Gate, quantization step and saturation are the authors'. The others are choices:
    //
    // * spurious readings: in a stored frame of the real skin, four of 384 taxels away from the one contact read 0.02
    //   to 0.10 N. Some of these may be creep left by earlier contacts, so half of them count as spurious. Their
    //   duration is not known; 6 s gives six to ten per reach of ten to thirty seconds, about the difference between
    //   the paper's count of components and ours without spurious readings (docs/physics.md explains the choice);
    // * noise: the gate, at 12 mN, must be below the smallest of those spurious readings;
    // * crosstalk: the neighbours of that frame's strongest taxel (1.5 N) read nothing, so they get at most 12 mN, the
    //   gate: a share of 0.03 in all;
    // * creep: slow creep over tens of seconds is documented, but not its size; rubber and rubber foams creep with the
    //   logarithm of time, by 2 to 10 % per decade. With 5 %, a taxel that a trunk has pressed with 3 N for a second
    //   still reads 49 mN one second after the contact has moved on, and 17 mN after three;
    // * delay: one frame, which the electronics fill before they send it;
    // * no dead taxels, spread of gains, drift or limit of the bandwidth: nothing is published about them.
    /// Properties of the tactile sensors.
    ///
    /// `delay_frames` and the dead taxels apply to all skin, `fabric` to the patches that the arm's skin file calls fabric,
    /// and `gain_spread_share`, `drift_n` and `bandwidth_hz` apply to all skin, too. All other keys apply to patches that it
    /// calls capacitive. `model` switches many effects at once. A single effect is switched off by the value 0 or, for the two
    /// saturations and the bandwidth, `inf`.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct SensorOptions {
        /// Which effects there are.
        model: SensorModel = SensorModel::Paper;
        /// Standard deviation of the logarithm of a taxel's gain, drawn for every reach: 0.1 means that most taxels read up to a
        /// tenth too much or too little.
        gain_spread_share: f64 = 0.0, limits::GAIN_SPREAD;
        /// Standard deviation of a taxel's slow drift, as by temperature, N.
        drift_n: f64 = 0.0, limits::NOISE_N;
        /// Time in which the drift forgets where it was, s.
        drift_time_s: f64 = 60.0, limits::DRIFT_TIME_S;
        /// Bandwidth of a taxel with its electronics, Hz: a low-pass filter of first order.
        bandwidth_hz: f64 = f64::INFINITY, limits::BANDWIDTH_HZ;
        /// Standard deviation of a taxel's noise, N.
        noise_n: f64 = 0.002, limits::NOISE_N;
        /// Readings below this many standard deviations of the noise are 0 (the authors' driver: 6).
        gate_sigmas: f64 = 6.0, limits::GATE_SIGMAS;
        /// Quantization step of a reading, N (the authors' driver: counts / 1000).
        quantum_n: f64 = 0.001, limits::QUANTUM_N;
        /// Largest reading of a taxel, N (17 on the robot).
        saturation_n: f64 = 17.0, limits::SATURATION_N;
        /// Readings below this are 0, N (the authors' optional floor: 1.0).
        floor_n: f64 = 0.0, limits::FLOOR_N;
        /// Share of a taxel's force that the cover passes to its four neighbours in the patch's grid, in equal parts.
        crosstalk_share: f64 = 0.03, limits::SHARE;
        /// Creep: how much the reading of a held force grows in every decade of time from 0.1 to 100 s, as a share of the
        /// force. After release it recovers as slowly.
        creep_share_per_decade: f64 = 0.05, limits::CREEP_SHARE;
        /// Long-run share of the taxels with a spurious reading: a force although nothing touches them.
        spurious_share: f64 = SPURIOUS_SHARE, limits::SPURIOUS_SHARE;
        /// Mean duration of a spurious reading, s.
        spurious_time_s: f64 = 6.0, limits::SPURIOUS_TIME_S;
        /// Smallest and largest spurious reading, N; values between them are equally likely.
        #[schemars(transform = Within(limits::SPURIOUS_FORCE_N))]
        spurious_force_n: [f64; 2] = [0.02, 0.10];
        /// Delay of the readings in frames of 10 ms.
        delay_frames: u32 = 1, limits::DELAY_FRAMES;
        /// Share of dead taxels, drawn for every reach; a dead taxel reads 0.
        dead_share: f64 = 0.0, limits::SHARE;
        /// Taxels that are dead in every reach: lists of taxel indices by the name of the patch.
        dead_taxels: BTreeMap<String, Vec<u16>> = BTreeMap::new();
        /// Properties of fabric taxels.
        fabric: FabricOptions = FabricOptions::default();
    }
}

/// How real the sensors are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SensorModel {
    /// The sensed force is what the skin passes on to the taxel. All other keys have no effect.
    Ideal,
    /// The sensors of the paper's robot: every effect as its key says.
    #[default]
    Paper,
    /// Each taxel was calibrated against a load cell, as on robots of today: no spread of gains, drift, creep, hysteresis,
    /// spurious readings, or saturating response of fabric. What remains are noise, gate, resolution, range, crosstalk,
    /// bandwidth, delay, dead taxels, and that of fabric with `response = "conductance"`: no load cell says how a force is spread.
    Calibrated,
}

/// Two of the forearm's 384 taxels.
const SPURIOUS_SHARE: f64 = 2.0 / 384.0;

options! {
    // The authors report a 10-bit converter with about 30 counts per newton, so the full scale is 1023 / 30 N.
    // Choices: hysteresis of a quarter ("strong"); noise of half a count, as in a converter whose last bit flickers;
    // the gate of the capacitive skin.
    /// Properties of taxels of piezoresistive fabric.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields, default)]
    pub struct FabricOptions {
        /// What the reading depends on.
        response: FabricResponse = FabricResponse::TotalForce;
        /// Quantization steps per newton (about 30 on the robot). With `conductance` the converter has 1024 steps over the
        /// supply voltage, and 0 means none.
        counts_per_n: f64 = 30.0, limits::COUNTS_PER_N;
        /// Full scale S, N: the reading of a force F is F S / (F + S). With `conductance` it has no effect.
        full_scale_n: f64 = 34.1, limits::SATURATION_N;
        /// Hysteresis: by what share of its largest value the force must fall before the reading begins to fall.
        hysteresis_share: f64 = 0.25, limits::HYSTERESIS_SHARE;
        /// Standard deviation of a taxel's noise, N; with `conductance` that of an unloaded taxel.
        noise_n: f64 = 1.0 / 60.0, limits::NOISE_N;
        /// Readings below this many standard deviations of the noise are 0.
        gate_sigmas: f64 = 6.0, limits::GATE_SIGMAS;
    }
}

/// What the reading of a fabric taxel depends on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum FabricResponse {
    /// The total force alone, however it is spread over the taxel.
    #[default]
    TotalForce,
    /// The pressure on each part of the taxel, as in the authors' model: the parts are resistors in parallel. The reading is
    /// the force that would give the same voltage if it were spread evenly over the taxel. If only a part
    /// of the taxel is loaded, it is larger than the true force, the more so the smaller that part is.
    Conductance,
}

/// What is wrong with an option: `(key, found, allowed)`.
pub type OptionFault = (String, String, String);

impl SensorOptions {
    /// Every effect switched off by its own key, as the baseline for testing single effects.
    pub fn off() -> Self {
        SensorOptions {
            noise_n: 0.0,
            gate_sigmas: 0.0,
            quantum_n: 0.0,
            saturation_n: f64::INFINITY,
            crosstalk_share: 0.0,
            creep_share_per_decade: 0.0,
            spurious_share: 0.0,
            spurious_time_s: 8.0,
            delay_frames: 0,
            fabric: FabricOptions {
                response: FabricResponse::TotalForce,
                counts_per_n: 0.0,
                full_scale_n: f64::INFINITY,
                hysteresis_share: 0.0,
                noise_n: 0.0,
                gate_sigmas: 0.0,
            },
            ..SensorOptions::default()
        }
    }

    /// The options with those effects off that `model` leaves out.
    pub(super) fn effective(&self) -> SensorOptions {
        match self.model {
            SensorModel::Paper => self.clone(),
            SensorModel::Ideal => SensorOptions::off(),
            SensorModel::Calibrated => SensorOptions {
                gain_spread_share: 0.0,
                drift_n: 0.0,
                creep_share_per_decade: 0.0,
                spurious_share: 0.0,
                fabric: FabricOptions { full_scale_n: f64::INFINITY, hysteresis_share: 0.0, ..self.fabric.clone() },
                ..self.clone()
            },
        }
    }

    /// What is wrong with these options, if anything.
    pub fn fault(&self) -> Option<OptionFault> {
        let own = self.numbers().into_iter().map(|(key, value, limits)| (key.to_owned(), value, limits));
        let forces_n = self.spurious_force_n;
        let spurious = forces_n.map(|force_n| ("spurious_force_n".to_owned(), force_n, limits::SPURIOUS_FORCE_N));
        let fabric = self.fabric.numbers().into_iter();
        let fabric = fabric.map(|(key, value, limits)| (format!("fabric.{key}"), value, limits));
        if let Some(fault) = first_outside(own.chain(spurious).chain(fabric)) {
            return Some(fault);
        }
        if forces_n[0] > forces_n[1] {
            let found = format!("{forces_n:?}");
            return Some(("spurious_force_n".into(), found, "[smallest, largest]: the smaller first".into()));
        }
        (self.floor_n >= self.saturation_n).then(|| {
            let allowed = format!("less than saturation_n, {}", short(self.saturation_n));
            ("floor_n".into(), short(self.floor_n), allowed)
        })
    }

    /// What is wrong with the list of dead taxels on this skin, if anything.
    pub fn fault_on(&self, layout: &SkinLayout) -> Option<OptionFault> {
        self.dead_taxels.iter().find_map(|(name, taxels)| {
            let Some(patch) = layout.patch_index(name) else {
                let names: Vec<&str> = layout.patches.iter().map(|patch| patch.name.as_str()).collect();
                let allowed = format!("patches of the arm's skin: {}", names.join(", "));
                return Some(("dead_taxels".into(), format!("{name:?}"), allowed));
            };
            let count = layout.patches[patch].taxels.len();
            if taxels.len() > count {
                let (found, allowed) = (taxels.len(), format!("each of the {count} taxels of {name} once"));
                return Some(("dead_taxels".into(), format!("{found} taxels"), allowed));
            }
            let invalid = taxels.iter().find(|taxel| usize::from(**taxel) >= count)?;
            Some(("dead_taxels".into(), invalid.to_string(), format!("0 to {} on {name}", count - 1)))
        })
    }
}
