//! The stiffness of an object, as trees learnt it from objects whose truth is known.

use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use underbrush_recording::{Recording, math};

use super::course::OBJECT_FEATURE_COUNT;
use super::resistance::Stiffness;
use crate::boosted::{Boosted, Loss, Row};
use crate::frequency::frequencies;
use crate::touch::network::FITTED;

/// Trees estimate the logarithm of the stiffness over this, N/m: the middle of what leaves, rolls and branches have.
const UNIT_N_PER_M: f64 = 100.0;
/// A family needs this many objects, or it says little about kinds that training lacks.
const FEWEST: usize = 20;
/// The quantiles of the truth over the estimate that bound the interval.
const QUANTILES: [f64; 2] = [0.05, 0.95];
/// An object that has given way by less than this is fixed, m: ten times the rounding of stored poses.
const GIVES_WAY_M: f64 = 1e-3;

/// An object when its force was largest.
#[derive(Clone, Debug)]
pub(super) struct Pressed {
    pub(super) features: [f32; OBJECT_FEATURE_COUNT],
    /// See [`true_stiffness_n_per_m`].
    pub(super) stiffness_n_per_m: f64,
}

impl Pressed {
    fn target(&self) -> f64 {
        math::ln(self.stiffness_n_per_m / UNIT_N_PER_M)
    }
}

/// What estimates the stiffness of an object from its features when its force was largest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StiffnessTrees {
    /// The logarithm of the stiffness over 100 N/m.
    trees: Boosted,
    /// What is added to it for the ends of the interval: quantiles of the errors on families that trees were not fitted to.
    ends: [f64; 2],
}

impl StiffnessTrees {
    /// Fits trees to objects with their categories; the given ones are known, the others are families of unknown objects. Each
    /// category weighs the same. `None` if fewer than two families have enough objects.
    pub(super) fn fit(objects: &[(&str, &Pressed)], known: &[String]) -> Option<Self> {
        let counts = frequencies(objects.iter().map(|(category, _)| *category));
        let fit = |without: Option<&str>| {
            let rows = objects.iter().filter(|(category, _)| Some(*category) != without).map(|(category, pressed)| {
                Row { features: &pressed.features, target: pressed.target(), weight: 1.0 / counts[category] as f64 }
            });
            Boosted::fit(Loss::Squared, &rows.collect::<Vec<_>>(), OBJECT_FEATURE_COUNT)
        };
        let mut errors: Vec<(f64, f64)> = Vec::new();
        let mut families = 0;
        for (family, count) in &counts {
            if *count >= FEWEST && known.iter().all(|name| name != family) {
                let others = fit(Some(family));
                let own = objects.iter().filter(|(category, _)| category == family);
                errors.extend(own.map(|(_, own)| (own.target() - others.score(&own.features), 1.0 / *count as f64)));
                families += 1;
            }
        }
        errors.sort_by(|a, b| a.0.total_cmp(&b.0));
        let quantile = |share: f64| {
            let mut left = share * f64::from(families);
            let reached = errors.iter().find(|(_, weight)| {
                left -= weight;
                left <= 0.0
            });
            reached.or(errors.last()).map_or(0.0, |(error, _)| *error)
        };
        (families >= 2).then(|| StiffnessTrees { ends: QUANTILES.map(quantile), trees: fit(None) })
    }

    /// The stiffness of an object with these features when its force was largest.
    pub(in crate::touch) fn of(&self, features: &[f32]) -> Stiffness {
        let estimate = self.trees.score(features);
        let [low_n_per_m, median_n_per_m, high_n_per_m] =
            [self.ends[0], 0.0, self.ends[1]].map(|end| UNIT_N_PER_M * math::exp(estimate + end));
        Stiffness { low_n_per_m, median_n_per_m, high_n_per_m }
    }

    pub(in crate::touch) fn is_sound(&self) -> bool {
        self.trees.features() == OBJECT_FEATURE_COUNT && self.ends.iter().all(|end| FITTED.hold(*end))
    }
}

/// The true stiffness of an object in a frame, N/m: the force of its contacts over how far the points that are touched are
/// from where they are at rest, along the force. `None` if it has not given way, or if contacts or bodies are not recorded.
pub(crate) fn true_stiffness_n_per_m(recording: &Recording, frame: usize, object: u16) -> Option<f64> {
    let (mut force, mut work) = (DVec3::ZERO, 0.0);
    for contact in recording.frames.get(frame)?.contact_points.iter().filter(|own| own.object == Some(object)) {
        let body = recording.bodies.get(usize::from(contact.body))?;
        let pose_world = body.pose_world(u32::try_from(frame).ok()?);
        let point_world = contact.position_world.as_dvec3();
        let at_rest = body.rest_pose_world.transform_point(pose_world.inverse_transform_point(point_world));
        // The force is the one on the link.
        force -= contact.force_world.as_dvec3();
        work -= contact.force_world.as_dvec3().dot(point_world - at_rest);
    }
    let force_n = force.length();
    (work > GIVES_WAY_M * force_n).then(|| force_n * force_n / work)
}

#[cfg(test)]
mod tests {
    use underbrush_recording::{Body, BodyOwner, ContactPoint, Frame, Pose};

    use super::*;
    use crate::trial::tests::recording;

    /// Pressed objects of each family, whose first feature is the logarithm of their stiffness over 100 N/m, from -1.9 to 2.
    fn pressed(families: &[&'static str]) -> Vec<(&'static str, Pressed)> {
        let object = |index: usize| {
            let mut features = [0.0; OBJECT_FEATURE_COUNT];
            features[0] = 0.1 * (index % 40) as f32 - 1.9;
            let stiffness_n_per_m = UNIT_N_PER_M * f64::from(features[0]).exp();
            Pressed { features, stiffness_n_per_m }
        };
        families.iter().flat_map(|family| (0..80).map(move |index| (*family, object(index)))).collect()
    }

    fn fit(objects: &[(&'static str, Pressed)]) -> Option<StiffnessTrees> {
        StiffnessTrees::fit(&objects.iter().map(|(family, own)| (*family, own)).collect::<Vec<_>>(), &["leaf".into()])
    }

    /// Tests that a stiffness that a feature tells is learnt. A leaf has 20 rows, and each value 6, so the four values at each end
    /// cannot be told apart: they are 0.15 from their mean.
    #[test]
    fn a_stiffness_that_a_feature_tells_is_learnt() {
        let objects = pressed(&["leaf", "pole", "roll"]);
        let trees = fit(&objects).unwrap();
        assert!(trees.is_sound());
        for (_, own) in &objects {
            let told = trees.of(&own.features);
            assert!((told.median_n_per_m / own.stiffness_n_per_m).ln().abs() < 0.2, "{told:?} {own:?}");
            assert!(told.low_n_per_m <= told.median_n_per_m && told.median_n_per_m <= told.high_n_per_m, "{told:?}");
        }
    }

    /// Tests that the interval has the errors on families that are left out: one is told half its stiffness by the others, which are
    /// told twice theirs or what they have.
    #[test]
    fn the_interval_is_that_of_families_left_out() {
        let mut objects = pressed(&["pole", "roll"]);
        objects.iter_mut().filter(|(family, _)| *family == "pole").for_each(|(_, own)| own.stiffness_n_per_m *= 2.0);
        let [low, high] = fit(&objects).unwrap().ends;
        let doubled = std::f64::consts::LN_2;
        assert!((low + doubled).abs() < 0.1 && (high - doubled).abs() < 0.1, "{low} {high}");
    }

    /// Tests that a single family is not enough, because nothing shows how far off the trees are on others.
    #[test]
    fn one_family_is_not_enough() {
        assert!(fit(&pressed(&["leaf", "pole"])).is_none());
    }

    /// Tests the truth: a body that 4 N have moved by 2 cm along the force has 200 N/m, whatever its shift across it; one that
    /// did not move has none.
    #[test]
    fn the_true_stiffness_is_force_over_displacement() {
        let mut body = Body {
            owner: BodyOwner::Object(0),
            parts: Vec::new(),
            rest_pose_world: Pose::from_position(DVec3::X),
            track: Vec::new(),
        };
        body.observe(0, &body.rest_pose_world.clone());
        body.observe(1, &Pose::from_position(DVec3::new(1.02, 0.01, 0.0)));
        let contact = ContactPoint {
            link: 0,
            patch: None,
            object: Some(0),
            body: 0,
            position_world: glam::Vec3::new(0.97, 0.3, 0.2),
            normal_world: -glam::Vec3::X,
            force_world: -4.0 * glam::Vec3::X,
            moment_world: glam::Vec3::ZERO,
            slip_world: glam::Vec3::ZERO,
            depth_m: 0.0,
            area_m2: 0.0,
        };
        let frame = Frame { contact_points: vec![contact], ..Frame::blank(0) };
        let recording = Recording { bodies: vec![body], frames: vec![frame.clone(), frame], ..recording(&[]) };
        let found = true_stiffness_n_per_m(&recording, 1, 0).unwrap();
        assert!((found / 200.0 - 1.0).abs() < 0.01, "{found}");
        assert_eq!(true_stiffness_n_per_m(&recording, 0, 0), None);
    }
}
