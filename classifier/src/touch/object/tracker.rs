//! Which contacts belong to one object.

use glam::{DVec2, DVec3};

use super::course::{ObjectCourse, ObjectMeasure};
use crate::touch::contact_history::Measure;
use crate::touch::frame::SkinTracker;

/// A contact that begins within this distance of where another one began, is, or ended, horizontally in the world, belongs
/// to its object, m. Choice, on development seeds: nearly the radius of a trunk or roll, and less than most leaves are apart.
const PLACE_M: f64 = 0.03;
/// The other contact lasts, or ended at most this long ago, s. Choice: objects stand on the table, so the arm finds them
/// where it left them, goals later.
const PLACE_S: f64 = 30.0;
/// A contact joins an object once it has sensed this force, N: the strongest spurious readings of the sensor.
const JOINING_N: f64 = 0.1;
/// An object is judged once it has sensed [`JUDGED_N`] in this many samples.
pub(in crate::touch) const JUDGED_SAMPLES: usize = 15;
/// The force of the samples that count, N.
const JUDGED_N: f64 = 0.2;
/// Room for this many objects and contacts, so that nothing is allocated with fewer.
const ROOM: usize = 256;

/// Something that touches the skin, or did so in the last thirty seconds.
#[derive(Clone, Copy, Debug)]
pub struct TouchObject {
    /// Number of the object, from 1.
    pub number: u64,
    /// Time of the first contact, s.
    pub start_s: f64,
    /// Whether it touches the skin in this frame.
    pub is_touching: bool,
    /// What the skin has sensed of it so far.
    pub course: ObjectCourse,
}

impl TouchObject {
    /// Whether it has been felt for long enough to be judged: at 0.2 N or more for 0.15 s.
    pub fn is_judged(&self) -> bool {
        self.course.samples() >= JUDGED_SAMPLES
    }
}

/// A contact of an object.
#[derive(Clone, Copy, Debug)]
struct Member {
    patch: usize,
    contact: u64,
    object: u64,
    /// Where it began, and where it was felt last. A contact walks along a round object, and an object gives way.
    places_world: [DVec2; 2],
    last_s: f64,
}

/// Follows the objects that touch a skin. Nothing is allocated after the first frames.
#[derive(Clone, Debug)]
pub struct ObjectTracker {
    /// The objects that touch the skin, or did so in the last thirty seconds, in the order in which they were first touched.
    pub objects: Vec<TouchObject>,
    /// The objects that are forgotten since this frame.
    pub ended: Vec<TouchObject>,
    members: Vec<Member>,
    /// For each region of this frame, patch by patch: the index of its object in `objects`; `None` for a contact that is
    /// too weak to belong to one.
    pub of_region: Vec<Option<usize>>,
    /// For each object, what the skin senses in this frame.
    measures: Vec<ObjectMeasure>,
    numbers: u64,
}

impl Default for ObjectTracker {
    fn default() -> Self {
        ObjectTracker {
            objects: Vec::with_capacity(ROOM),
            ended: Vec::with_capacity(ROOM),
            members: Vec::with_capacity(ROOM),
            of_region: Vec::with_capacity(ROOM),
            measures: Vec::with_capacity(ROOM),
            numbers: 0,
        }
    }
}

impl ObjectTracker {
    /// Takes in the regions of the frame that the trackers of all patches have followed, which was sensed at `time_s`.
    pub fn update(&mut self, patches: &[SkinTracker], time_s: f64) {
        self.end_old(time_s);
        self.of_region.clear();
        self.measures.clear();
        self.measures.resize(self.objects.len(), ObjectMeasure::default());
        for (patch, tracker) in patches.iter().enumerate() {
            for region in tracker.regions() {
                let now = &region.course.now;
                let joins = region.course.largest_force_n >= JOINING_N;
                let object = joins.then(|| self.object_of(patch, region.contact, now, time_s));
                if let Some(object) = object {
                    self.measures[object].add(&region.course);
                }
                self.of_region.push(object);
            }
        }
        for (object, measure) in self.objects.iter_mut().zip(&self.measures) {
            object.is_touching = measure.contacts > 0.0;
            if object.is_touching {
                object.course.push(measure, time_s, JUDGED_N);
            }
        }
    }

    /// The index of the object that a contact belongs to: its own, that of the nearest contact, or a new one.
    fn object_of(&mut self, patch: usize, contact: u64, now: &Measure, time_s: f64) -> usize {
        let place_world = DVec3::truncate(now.center_world);
        let own = self.members.iter_mut().find(|member| member.patch == patch && member.contact == contact);
        let number = match own {
            Some(member) => {
                (member.places_world[1], member.last_s) = (place_world, time_s);
                member.object
            }
            None => {
                let places = self.members.iter().flat_map(|own| own.places_world.map(|place| (place, own.object)));
                let near = places.map(|(place, object)| (place.distance(place_world), object));
                let near = near.filter(|(distance, _)| *distance <= PLACE_M);
                let nearest = near.reduce(|best, other| if other.0 < best.0 { other } else { best });
                let object = nearest.map_or_else(|| self.begin(time_s), |(_, object)| object);
                self.members.push(Member { patch, contact, object, places_world: [place_world; 2], last_s: time_s });
                if let Some(index) = self.index_of(object) {
                    self.objects[index].course.contacts += 1.0;
                }
                object
            }
        };
        self.index_of(number).unwrap_or_default()
    }

    fn index_of(&self, number: u64) -> Option<usize> {
        self.objects.iter().position(|object| object.number == number)
    }

    fn begin(&mut self, time_s: f64) -> u64 {
        self.numbers += 1;
        let course = ObjectCourse::default();
        self.objects.push(TouchObject { number: self.numbers, start_s: time_s, is_touching: true, course });
        self.measures.push(ObjectMeasure::default());
        self.numbers
    }

    /// Forgets contacts that ended long ago, and objects without contacts.
    fn end_old(&mut self, time_s: f64) {
        self.ended.clear();
        self.members.retain(|member| time_s - member.last_s <= PLACE_S);
        let members = &self.members;
        let is_over = |object: &mut TouchObject| members.iter().all(|member| member.object != object.number);
        self.ended.extend(self.objects.extract_if(.., is_over));
    }
}
