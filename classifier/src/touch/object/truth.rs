//! Ground truth of the objects that a tracker tells apart: what truly presses on their taxels, and how stiff it is.

use std::collections::BTreeMap;

use glam::DVec3;
use underbrush_recording::{BodyOwner, Category, Recording, math};

use super::tracker::ObjectTracker;
use crate::frequency::largest;
use crate::touch::frame::SkinTracker;
use crate::touch::region::Region;

/// An object that has given way by less than this is fixed, m: ten times the rounding of stored poses.
const GIVES_WAY_M: f64 = 1e-3;

/// The sensed force of each true object, by its index in the recording, summed over taxels and frames, N.
pub(crate) type Votes = BTreeMap<u16, f64>;

/// Adds the sensed force of each taxel of a region that something truly presses on.
pub(in crate::touch) fn add_votes(votes: &mut Votes, tracker: &SkinTracker, region: &Region) {
    let image = &tracker.image;
    for &taxel in tracker.taxels(region) {
        if let Some(object) = image.pressing(taxel) {
            *votes.entry(object).or_default() += image.sensed_force_n(taxel);
        }
    }
}

/// The true object that most of the force comes from, this force, N, and its category.
pub(crate) fn strongest(votes: &Votes, recording: &Recording) -> Option<(u16, f64, Category)> {
    let (object, force_n) = largest(votes.iter().map(|(object, force_n)| (*object, *force_n)))?;
    Some((object, force_n, recording.category_of(object)?))
}

/// What is kept of each object of a recording, with the votes for what it truly is.
#[derive(Default)]
pub(crate) struct Followed<T> {
    /// The objects that have not ended, by number.
    open: BTreeMap<u64, (T, Votes)>,
    ended: Vec<(T, Votes)>,
}

impl<T: Default> Followed<T> {
    /// Takes in the frame that the trackers have followed last. An object begins with its first contact.
    pub(crate) fn update(&mut self, patches: &[SkinTracker], objects: &ObjectTracker) {
        self.ended.extend(objects.ended.iter().filter_map(|object| self.open.remove(&object.number)));
        let regions = patches.iter().flat_map(|tracker| tracker.regions().iter().map(move |region| (tracker, region)));
        for ((tracker, region), object) in regions.zip(&objects.of_region) {
            if let Some(object) = object.and_then(|index| objects.objects.get(index)) {
                let (_, votes) = self.open.entry(object.number).or_default();
                add_votes(votes, tracker, region);
            }
        }
    }

    /// What is kept of the object with this number, which has not ended.
    pub(crate) fn of(&mut self, object: u64) -> Option<&mut (T, Votes)> {
        self.open.get_mut(&object)
    }

    /// All objects, once the recording is over, in the order in which they ended.
    pub(crate) fn finish(self) -> impl Iterator<Item = (T, Votes)> {
        self.ended.into_iter().chain(self.open.into_values())
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

/// How far an object has truly been in these frames, both included, from where it was in the first, m: the way of the centre of its shape
/// that was farthest. `None` if its bodies are not recorded.
pub(crate) fn true_displacement_m(recording: &Recording, frames: [usize; 2], object: u16) -> Option<f64> {
    let [first, last] = frames.map(|frame| u32::try_from(frame).unwrap_or(u32::MAX));
    let bodies = recording.bodies.iter().filter(|body| body.owner == BodyOwner::Object(object));
    let ways_m = bodies.flat_map(|body| {
        let start_world = body.pose_world(first);
        (first..=last).flat_map(move |frame| {
            let pose_world = body.pose_world(frame);
            body.parts.iter().map(move |part| {
                let center = part.pose_body.position;
                start_world.transform_point(center).distance(pose_world.transform_point(center))
            })
        })
    });
    ways_m.reduce(math::larger)
}

#[cfg(test)]
mod tests {
    use underbrush_recording::{Body, BodyPart, BodyShape, ContactPoint, Frame, Pose};

    use super::*;
    use crate::trial::tests::recording;

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

    /// Tests that the displacement of an object is that of its shape that moved farthest, from the first frame and not from where it
    /// was built, and that there is none without bodies.
    #[test]
    fn the_true_displacement_is_that_of_the_farthest_shape() {
        let part = BodyPart { shape: BodyShape::Sphere { radius_m: 0.02 }, pose_body: Pose::from_position(DVec3::Z) };
        let body = |object: u16, shifts_m: [f64; 3]| {
            let mut body = Body {
                owner: BodyOwner::Object(object),
                parts: vec![part.clone()],
                rest_pose_world: Pose::IDENTITY,
                track: Vec::new(),
            };
            for (frame, shift_m) in (0..).zip(shifts_m) {
                body.observe(frame, &Pose::from_position(shift_m * DVec3::X));
            }
            body
        };
        let bodies = vec![body(0, [0.5, 0.5, 0.503]), body(0, [0.1, 0.1, 0.11]), body(1, [0.0, 0.2, 0.05])];
        let recording = Recording { bodies, ..recording(&[]) };
        let moved = |frames: [usize; 2], object: u16| true_displacement_m(&recording, frames, object);
        assert!((moved([1, 2], 0).unwrap() - 0.01).abs() < 3e-4, "{:?}", moved([1, 2], 0));
        assert!((moved([0, 2], 1).unwrap() - 0.2).abs() < 3e-4, "it has come back: {:?}", moved([0, 2], 1));
        assert_eq!((moved([0, 1], 0), moved([0, 1], 2)), (Some(0.0), None));
    }
}
