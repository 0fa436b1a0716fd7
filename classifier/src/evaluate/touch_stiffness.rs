//! The stiffness of touched objects, compared with ground truth.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Serialize;
use underbrush_recording::Recording;

use super::touch_object::JudgedObject;

/// Objects that were pressed with less say little, N.
const PRESSED_N: f64 = 3.0;
/// An object that has given way by less than this is fixed, m: ten times the rounding of stored poses.
const GIVES_WAY_M: f64 = 1e-3;

/// How well the stiffness of the objects of one category is told, of those that were pressed with 3 N or more and gave way by
/// 1 mm or more.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StiffnessFigures {
    /// The category.
    pub truth: String,
    /// Number of objects.
    pub objects: usize,
    /// Share of which the median of the stiffness is between half and twice the truth.
    pub within_twice: f64,
    /// Share of which the interval holds the truth; 90 % is meant.
    pub held: f64,
    /// Median of the ratio of the told stiffness to the true one.
    pub median_ratio: f64,
}

impl StiffnessFigures {
    /// The figures of each category, in alphabetical order.
    pub(super) fn of(objects: &[JudgedObject]) -> Vec<Self> {
        let mut ratios: BTreeMap<&str, Vec<[f64; 2]>> = BTreeMap::new();
        for own in objects.iter().filter(|own| own.peak_force_n >= PRESSED_N) {
            let (Some(told), Some(truth_n_per_m)) = (own.stiffness, own.true_stiffness_n_per_m) else { continue };
            let is_held = (told.low_n_per_m..=told.high_n_per_m).contains(&truth_n_per_m);
            let ratio = told.median_n_per_m / truth_n_per_m;
            ratios.entry(&own.truth).or_default().push([ratio, f64::from(u8::from(is_held))]);
        }
        let figures = |(truth, mut ratios): (&str, Vec<[f64; 2]>)| {
            ratios.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let count = ratios.len() as f64;
            StiffnessFigures {
                truth: truth.to_owned(),
                objects: ratios.len(),
                within_twice: ratios.iter().filter(|own| (0.5..=2.0).contains(&own[0])).count() as f64 / count,
                held: ratios.iter().map(|own| own[1]).sum::<f64>() / count,
                median_ratio: ratios[ratios.len() / 2][0],
            }
        };
        ratios.into_iter().map(figures).collect()
    }
}

/// The true stiffness of an object in a frame, N/m: the force of its contacts over how far the points that are touched are
/// from where they are at rest, along the force. `None` if it has not given way, or if contacts or bodies are not recorded.
pub(super) fn true_stiffness_n_per_m(recording: &Recording, frame: usize, object: u16) -> Option<f64> {
    let (mut force, mut work) = (DVec3::ZERO, 0.0);
    for contact in recording.frames.get(frame)?.contact_points.iter().filter(|own| own.object == object) {
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
    use crate::touch::Stiffness;
    use crate::trial::tests::recording;

    fn judged(peak_force_n: f64, ratio: f64, truth_n_per_m: Option<f64>) -> JudgedObject {
        let told = |factor: f64| ratio * factor * 100.0;
        JudgedObject {
            truth: "stalk".into(),
            peak_force_n,
            stiffness: Some(Stiffness { low_n_per_m: told(0.5), median_n_per_m: told(1.0), high_n_per_m: told(1.5) }),
            true_stiffness_n_per_m: truth_n_per_m,
            ..JudgedObject::new(1)
        }
    }

    /// Tests the shares: weakly pressed and fixed objects do not count.
    #[test]
    fn only_objects_that_were_pressed_and_gave_way_count() {
        let truth = Some(100.0);
        let objects = [
            judged(5.0, 1.0, truth),
            judged(5.0, 1.8, truth),
            judged(5.0, 4.0, truth),
            judged(1.0, 9.0, truth),
            judged(9.0, 9.0, None),
        ];
        let figures = StiffnessFigures::of(&objects);
        assert_eq!(figures.len(), 1);
        assert_eq!((figures[0].objects, figures[0].median_ratio), (3, 1.8));
        assert!((figures[0].within_twice - 2.0 / 3.0).abs() < 1e-12 && (figures[0].held - 2.0 / 3.0).abs() < 1e-12);
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
            object: 0,
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
