//! Options of the sensor: the `[sensor]` section of a scene file.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::SkinLayout;
use underbrush_recording::limits::short;

use super::limits;

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
    pub model: SensorModel,
    /// Standard deviation of the logarithm of a taxel's gain, drawn for every reach: 0.1 means that most taxels read up to a
    /// tenth too much or too little.
    #[schemars(range(min = limits::GAIN_SPREAD.min, max = limits::GAIN_SPREAD.max))]
    pub gain_spread_share: f64,
    /// Standard deviation of a taxel's slow drift, as by temperature, N.
    #[schemars(range(min = 0.0, max = limits::NOISE_N.max))]
    pub drift_n: f64,
    /// Time in which the drift forgets where it was, s.
    #[schemars(range(min = limits::DRIFT_TIME_S.min, max = limits::DRIFT_TIME_S.max))]
    pub drift_time_s: f64,
    /// Bandwidth of a taxel with its electronics, Hz: a low-pass filter of first order.
    #[schemars(range(min = limits::BANDWIDTH_HZ.min))]
    pub bandwidth_hz: f64,
    /// Standard deviation of a taxel's noise, N.
    #[schemars(range(min = 0.0, max = limits::NOISE_N.max))]
    pub noise_n: f64,
    /// Readings below this many standard deviations of the noise are 0 (the authors' driver: 6).
    #[schemars(range(min = limits::GATE_SIGMAS.min, max = limits::GATE_SIGMAS.max))]
    pub gate_sigmas: f64,
    /// Quantization step of a reading, N (the authors' driver: counts / 1000).
    #[schemars(range(min = 0.0, max = limits::QUANTUM_N.max))]
    pub quantum_n: f64,
    /// Largest reading of a taxel, N (17 on the robot).
    #[schemars(range(min = limits::SATURATION_N.min))]
    pub saturation_n: f64,
    /// Readings below this are 0, N (the authors' optional floor: 1.0).
    #[schemars(range(min = 0.0, max = limits::FLOOR_N.max))]
    pub floor_n: f64,
    /// Share of a taxel's force that the cover passes to its four neighbours in the patch's grid, in equal parts.
    #[schemars(range(min = limits::SHARE.min, max = limits::SHARE.max))]
    pub crosstalk_share: f64,
    /// Creep: how much the reading of a held force grows in every decade of time from 0.1 to 100 s, as a share of the
    /// force. After release it recovers as slowly.
    #[schemars(range(min = limits::CREEP_SHARE.min, max = limits::CREEP_SHARE.max))]
    pub creep_share_per_decade: f64,
    /// Long-run share of the taxels with a spurious reading: a force although nothing touches them.
    #[serde(alias = "stray_share")]
    #[schemars(range(min = limits::SPURIOUS_SHARE.min, max = limits::SPURIOUS_SHARE.max))]
    pub spurious_share: f64,
    /// Mean duration of a spurious reading, s.
    #[serde(alias = "stray_time_s")]
    #[schemars(range(min = limits::SPURIOUS_TIME_S.min, max = limits::SPURIOUS_TIME_S.max))]
    pub spurious_time_s: f64,
    /// Smallest and largest spurious reading, N; values between them are equally likely.
    #[serde(alias = "stray_force_n")]
    pub spurious_force_n: [f64; 2],
    /// Delay of the readings in frames of 10 ms.
    #[schemars(range(min = limits::DELAY_FRAMES.min, max = limits::DELAY_FRAMES.max))]
    pub delay_frames: u32,
    /// Share of dead taxels, drawn for every reach; a dead taxel reads 0.
    #[schemars(range(min = limits::SHARE.min, max = limits::SHARE.max))]
    pub dead_share: f64,
    /// Taxels that are dead in every reach: lists of taxel indices by the name of the patch.
    pub dead_taxels: BTreeMap<String, Vec<u16>>,
    /// Properties of fabric taxels.
    pub fabric: FabricOptions,
}

/// How real the sensors are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SensorModel {
    /// The sensed force is the true force. All other keys have no effect.
    Ideal,
    /// The sensors of the paper's robot: every effect as its key says.
    #[default]
    Paper,
    /// Each taxel was calibrated against a load cell, as on robots of today: no spread of gains, drift, creep, hysteresis,
    /// spurious readings, or saturating response of fabric. What remains are noise, gate, resolution, range, crosstalk,
    /// bandwidth, delay and dead taxels.
    Calibrated,
}

/// Two of the forearm's 384 taxels.
const SPURIOUS_SHARE: f64 = 2.0 / 384.0;

impl Default for SensorOptions {
    /// Gate, quantization step and saturation are the authors'. The others are choices:
    ///
    /// * spurious readings: in a stored frame of the real skin, four of 384 taxels away from the one contact read 0.02
    ///   to 0.10 N. Some of these may be creep left by earlier contacts, so half of them count as spurious. Their
    ///   duration is not known; 6 s gives six to ten per reach of ten to thirty seconds, about the difference between
    ///   the paper's count of components and ours without spurious readings (docs/physics.md explains the choice);
    /// * noise: the gate, at 12 mN, must be below the smallest of those spurious readings;
    /// * crosstalk: the neighbours of that frame's strongest taxel (1.5 N) read nothing, so they get at most 12 mN, the
    ///   gate: a share of 0.03 in all;
    /// * creep: slow creep over tens of seconds is documented, but not its size; rubber and rubber foams creep with the
    ///   logarithm of time, by 2 to 10 % per decade. With 5 %, a taxel that a trunk has pressed with 3 N for a second
    ///   still reads 49 mN one second after the contact has moved on, and 17 mN after three;
    /// * delay: one frame, which the electronics fill before they send it;
    /// * no dead taxels, spread of gains, drift or limit of the bandwidth: nothing is published about them.
    fn default() -> Self {
        SensorOptions {
            model: SensorModel::Paper,
            gain_spread_share: 0.0,
            drift_n: 0.0,
            drift_time_s: 60.0,
            bandwidth_hz: f64::INFINITY,
            noise_n: 0.002,
            gate_sigmas: 6.0,
            quantum_n: 0.001,
            saturation_n: 17.0,
            floor_n: 0.0,
            crosstalk_share: 0.03,
            creep_share_per_decade: 0.05,
            spurious_share: SPURIOUS_SHARE,
            spurious_time_s: 6.0,
            spurious_force_n: [0.02, 0.10],
            delay_frames: 1,
            dead_share: 0.0,
            dead_taxels: BTreeMap::new(),
            fabric: FabricOptions::default(),
        }
    }
}

/// Properties of taxels of piezoresistive fabric.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FabricOptions {
    /// Quantization steps per newton (about 30 on the robot).
    #[schemars(range(min = 0.0, max = limits::COUNTS_PER_N.max))]
    pub counts_per_n: f64,
    /// Full scale S, N: the reading of a force F is F S / (F + S).
    #[schemars(range(min = limits::SATURATION_N.min))]
    pub full_scale_n: f64,
    /// Hysteresis: by what share of its largest value the force must fall before the reading begins to fall.
    #[schemars(range(min = limits::HYSTERESIS_SHARE.min, max = limits::HYSTERESIS_SHARE.max))]
    pub hysteresis_share: f64,
    /// Standard deviation of a taxel's noise, N.
    #[schemars(range(min = 0.0, max = limits::NOISE_N.max))]
    pub noise_n: f64,
    /// Readings below this many standard deviations of the noise are 0.
    #[schemars(range(min = limits::GATE_SIGMAS.min, max = limits::GATE_SIGMAS.max))]
    pub gate_sigmas: f64,
}

impl Default for FabricOptions {
    /// The authors report a 10-bit converter with about 30 counts per newton, so the full scale is 1023 / 30 N.
    /// Choices: hysteresis of a quarter ("strong"); noise of half a count, as in a converter whose last bit flickers;
    /// the gate of the capacitive skin.
    fn default() -> Self {
        FabricOptions {
            counts_per_n: 30.0,
            full_scale_n: 34.1,
            hysteresis_share: 0.25,
            noise_n: 1.0 / 60.0,
            gate_sigmas: 6.0,
        }
    }
}

/// What is wrong with an option: `(key, found, allowed)`.
pub type Fault = (String, String, String);

impl SensorOptions {
    /// Every effect switched off by its own key, as the baseline for testing single effects.
    pub fn off() -> Self {
        SensorOptions {
            model: SensorModel::Paper,
            gain_spread_share: 0.0,
            drift_n: 0.0,
            drift_time_s: 60.0,
            bandwidth_hz: f64::INFINITY,
            noise_n: 0.0,
            gate_sigmas: 0.0,
            quantum_n: 0.0,
            saturation_n: f64::INFINITY,
            floor_n: 0.0,
            crosstalk_share: 0.0,
            creep_share_per_decade: 0.0,
            spurious_share: 0.0,
            spurious_time_s: 8.0,
            spurious_force_n: [0.02, 0.10],
            delay_frames: 0,
            dead_share: 0.0,
            dead_taxels: BTreeMap::new(),
            fabric: FabricOptions {
                counts_per_n: 0.0,
                full_scale_n: f64::INFINITY,
                hysteresis_share: 0.0,
                noise_n: 0.0,
                gate_sigmas: 0.0,
            },
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
    pub fn fault(&self) -> Option<Fault> {
        let fabric = &self.fabric;
        let [min_spurious_n, max_spurious_n] = self.spurious_force_n;
        let numbers = [
            ("gain_spread_share", self.gain_spread_share, limits::GAIN_SPREAD),
            ("drift_n", self.drift_n, limits::NOISE_N),
            ("drift_time_s", self.drift_time_s, limits::DRIFT_TIME_S),
            ("bandwidth_hz", self.bandwidth_hz, limits::BANDWIDTH_HZ),
            ("noise_n", self.noise_n, limits::NOISE_N),
            ("gate_sigmas", self.gate_sigmas, limits::GATE_SIGMAS),
            ("quantum_n", self.quantum_n, limits::QUANTUM_N),
            ("saturation_n", self.saturation_n, limits::SATURATION_N),
            ("floor_n", self.floor_n, limits::FLOOR_N),
            ("crosstalk_share", self.crosstalk_share, limits::SHARE),
            ("creep_share_per_decade", self.creep_share_per_decade, limits::CREEP_SHARE),
            ("spurious_share", self.spurious_share, limits::SPURIOUS_SHARE),
            ("spurious_time_s", self.spurious_time_s, limits::SPURIOUS_TIME_S),
            ("spurious_force_n", min_spurious_n, limits::SPURIOUS_FORCE_N),
            ("spurious_force_n", max_spurious_n, limits::SPURIOUS_FORCE_N),
            ("delay_frames", f64::from(self.delay_frames), limits::DELAY_FRAMES),
            ("dead_share", self.dead_share, limits::SHARE),
            ("fabric.counts_per_n", fabric.counts_per_n, limits::COUNTS_PER_N),
            ("fabric.full_scale_n", fabric.full_scale_n, limits::SATURATION_N),
            ("fabric.hysteresis_share", fabric.hysteresis_share, limits::HYSTERESIS_SHARE),
            ("fabric.noise_n", fabric.noise_n, limits::NOISE_N),
            ("fabric.gate_sigmas", fabric.gate_sigmas, limits::GATE_SIGMAS),
        ];
        let broken = numbers.into_iter().find(|(_, value, limits)| !limits.hold(*value));
        if let Some((key, value, limits)) = broken {
            return Some((key.into(), short(value), limits.to_string()));
        }
        if min_spurious_n > max_spurious_n {
            let found = format!("{:?}", self.spurious_force_n);
            return Some(("spurious_force_n".into(), found, "[smallest, largest]: the smaller first".into()));
        }
        (self.floor_n >= self.saturation_n).then(|| {
            let allowed = format!("less than saturation_n, {}", short(self.saturation_n));
            ("floor_n".into(), short(self.floor_n), allowed)
        })
    }

    /// What is wrong with the list of dead taxels on this skin, if anything.
    pub fn fault_on(&self, layout: &SkinLayout) -> Option<Fault> {
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
            let allowed = format!("0 to {} on {name}", count - 1);
            Some(("dead_taxels".into(), invalid.to_string(), allowed))
        })
    }
}
