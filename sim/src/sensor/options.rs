//! Options of the sensor: the `[sensor]` section of a scene file.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::SkinLayout;

/// What the skin's electronics do to the true force.
///
/// `delay_frames` and the dead taxels are of all skin, `fabric` of the patches that the arm's skin file calls fabric,
/// every other key of those that it calls capacitive. `perfect = true` switches all of it off; each effect also goes by
/// itself, at 0 or, for the two saturations, at `inf`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct SensorOptions {
    /// The sensed force is the true force.
    pub perfect: bool,
    /// Standard deviation of a taxel's noise, N.
    pub noise_n: f64,
    /// Deviations under this many standard deviations of the noise read 0 (the authors' driver: 6).
    pub gate_sigmas: f64,
    /// Smallest step of a reading, N (the authors' driver: counts / 1000).
    pub quantum_n: f64,
    /// Largest force that a taxel can tell, N (17 on the robot); larger ones read as this.
    pub saturation_n: f64,
    /// Readings under this many newtons read 0; off at 0 (the authors' optional floor: 1.0).
    pub floor_n: f64,
    /// Share of a taxel's force that its cover hands to the neighbours in the patch's grid, in equal parts to the four.
    pub crosstalk_share: f64,
    /// What a held force adds to its own reading by creep in every decade of time from 0.1 to 100 s, as a share of the
    /// force; after release it is taken back as slowly.
    pub creep_share_per_decade: f64,
    /// Share of the taxels that stray in the long run: they read a force though nothing touches them.
    pub stray_share: f64,
    /// Mean time for which a taxel strays, s.
    pub stray_time_s: f64,
    /// Least and largest reading of a stray, N; anything between is equally likely.
    pub stray_force_n: [f64; 2],
    /// Frames of 10 ms that readings are late.
    pub delay_frames: u32,
    /// Share of all taxels that are dead in a reach, drawn anew for each; a dead taxel reads 0.
    pub dead_share: f64,
    /// Taxels that are dead in every reach: lists of indices by patch name.
    pub dead_taxels: BTreeMap<String, Vec<u16>>,
    /// Fabric taxels.
    pub fabric: FabricOptions,
}

/// Two of the forearm's 384 taxels.
const STRAY_SHARE: f64 = 2.0 / 384.0;

impl Default for SensorOptions {
    /// Gate, quantum and saturation are the authors'. The others are choices:
    ///
    /// * strays: a stored frame of the real skin holds, beside one contact, four taxels of 384 with 0.02 to 0.10 N. Some may
    ///   be what creep has left of contacts before, so half of them count as strays. How long they last is not known; 6 s
    ///   give, in reaches of some ten to thirty seconds, six to ten a reach, about as many as the paper counts components
    ///   more than ours without any (ARCHITECTURE.md tells the whole reckoning);
    /// * noise: the gate, at 12 mN, must be under the smallest of those strays;
    /// * crosstalk: that frame's strongest taxel (1.5 N) leaves its neighbours dark, so they may get 12 mN at most, the
    ///   gate: a share of 0.03 in all;
    /// * creep: slow creep over tens of seconds is documented, its size is not; rubber and its foams creep with the
    ///   logarithm of time, by 2 to 10 % a decade. With 5 % a taxel that a trunk has
    ///   pressed with 3 N for a second still reads 49 mN a second after the contact has slid on, and 17 mN after three;
    /// * delay: one frame, which the electronics fill before they send it;
    /// * no dead taxels.
    fn default() -> Self {
        SensorOptions {
            perfect: false,
            noise_n: 0.002,
            gate_sigmas: 6.0,
            quantum_n: 0.001,
            saturation_n: 17.0,
            floor_n: 0.0,
            crosstalk_share: 0.03,
            creep_share_per_decade: 0.05,
            stray_share: STRAY_SHARE,
            stray_time_s: 6.0,
            stray_force_n: [0.02, 0.10],
            delay_frames: 1,
            dead_share: 0.0,
            dead_taxels: BTreeMap::new(),
            fabric: FabricOptions::default(),
        }
    }
}

/// What a taxel of piezoresistive fabric makes of the true force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FabricOptions {
    /// Steps of a reading per newton (about 30 on the robot); no steps at 0.
    pub counts_per_n: f64,
    /// The reading S that an infinite force tends to, N: a force F reads F S / (F + S).
    pub full_scale_n: f64,
    /// Share of the largest force that must be taken away before the reading begins to fall.
    pub hysteresis_share: f64,
    /// Standard deviation of a taxel's noise, N.
    pub noise_n: f64,
    /// Deviations under this many standard deviations of the noise read 0.
    pub gate_sigmas: f64,
}

impl Default for FabricOptions {
    /// About 30 counts per newton of a 10 bit converter are the authors' figures, so the full scale is 1023 / 30 N.
    /// Choices: a hysteresis of a quarter ("strong"); noise of half a count, as of a converter whose last bit flickers;
    /// the gate of the other skin.
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

/// A delay of more frames than this, two seconds, is a slip of the keyboard.
const LONGEST_DELAY_FRAMES: u32 = 200;

impl SensorOptions {
    /// Every effect off, each by its own key: what a single effect is judged against.
    pub fn off() -> Self {
        SensorOptions {
            perfect: false,
            noise_n: 0.0,
            gate_sigmas: 0.0,
            quantum_n: 0.0,
            saturation_n: f64::INFINITY,
            floor_n: 0.0,
            crosstalk_share: 0.0,
            creep_share_per_decade: 0.0,
            stray_share: 0.0,
            stray_time_s: 8.0,
            stray_force_n: [0.02, 0.10],
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

    /// What is wrong with the options, if anything.
    pub fn fault(&self) -> Option<Fault> {
        let fabric = &self.fabric;
        let not_negative = |key, value: f64| {
            let holds = value.is_finite() && value >= 0.0;
            (key, value.to_string(), holds, "a finite number of zero or more")
        };
        let positive = |key, value: f64| (key, value.to_string(), value > 0.0, "a positive number");
        let time = |key, value: f64| {
            let holds = value.is_finite() && value > 0.0;
            (key, value.to_string(), holds, "a finite positive number")
        };
        let share = |key, value: f64| (key, value.to_string(), (0.0..=1.0).contains(&value), "0 to 1");
        let late = self.delay_frames <= LONGEST_DELAY_FRAMES;
        let [least, most] = self.stray_force_n;
        let ordered = least > 0.0 && least <= most && most.is_finite();
        let loops = (0.0..1.0).contains(&fabric.hysteresis_share);
        let checks = [
            not_negative("noise_n", self.noise_n),
            not_negative("gate_sigmas", self.gate_sigmas),
            not_negative("quantum_n", self.quantum_n),
            positive("saturation_n", self.saturation_n),
            not_negative("floor_n", self.floor_n),
            share("crosstalk_share", self.crosstalk_share),
            not_negative("creep_share_per_decade", self.creep_share_per_decade),
            (
                "stray_share",
                self.stray_share.to_string(),
                (0.0..=0.5).contains(&self.stray_share),
                "0 to 0.5",
            ),
            time("stray_time_s", self.stray_time_s),
            (
                "stray_force_n",
                format!("{:?}", self.stray_force_n),
                ordered,
                "[least, largest]: finite positive numbers, the smaller first",
            ),
            ("delay_frames", self.delay_frames.to_string(), late, "0 to 200"),
            share("dead_share", self.dead_share),
            not_negative("fabric.counts_per_n", fabric.counts_per_n),
            positive("fabric.full_scale_n", fabric.full_scale_n),
            (
                "fabric.hysteresis_share",
                fabric.hysteresis_share.to_string(),
                loops,
                "0 to less than 1",
            ),
            not_negative("fabric.noise_n", fabric.noise_n),
            not_negative("fabric.gate_sigmas", fabric.gate_sigmas),
        ];
        let broken = checks.into_iter().find(|(_, _, holds, _)| !holds);
        broken.map(|(key, value, _, allowed)| (key.into(), value, allowed.into()))
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
            let beyond = taxels.iter().find(|taxel| usize::from(**taxel) >= count)?;
            let allowed = format!("0 to {} on {name}", count - 1);
            Some(("dead_taxels".into(), beyond.to_string(), allowed))
        })
    }
}
