//! The recording of a reach, frame by frame: of a running reach by itself, and for observers.

use std::collections::BTreeMap;

use glam::DVec3;
use underbrush_recording::{Audit, Contact, FRAME_PERIOD_S, Frame, MappedObstacle, Recording};

use super::Observed;
use super::plan::ReachPlan;
use crate::arm::Arm;
use crate::audit::Auditor;
use crate::body_log::BodyLog;
use crate::simulation::{ContactPair, Simulation};

/// The recording of a running reach.
#[derive(Clone)]
pub(super) struct ReachLog {
    /// What is recorded while the reach runs.
    pub(super) recording: Recording,
    contacts: ContactLog,
    bodies: BodyLog,
    /// Audits every frame, and every engine step and answer of the controller that it is shown.
    pub(super) auditor: Auditor,
    has_contact_points: bool,
}

impl ReachLog {
    /// An empty log, for a simulation at its start.
    pub(super) fn new(plan: &ReachPlan, controller: &str, reach_index: u64, simulation: &Simulation) -> Self {
        let recording = Recording {
            scene: plan.scene.name.clone(),
            controller: controller.into(),
            seed: plan.seed,
            reach_index,
            rate_hz: 1.0 / FRAME_PERIOD_S,
            joint_names: plan.arm.joints.iter().map(|joint| joint.name.clone()).collect(),
            layout: plan.arm.skin.layout.clone(),
            objects: simulation.clutter().records(),
            ..Recording::default()
        };
        ReachLog {
            recording,
            contacts: ContactLog::default(),
            bodies: BodyLog::new(simulation),
            auditor: Auditor::new(simulation),
            has_contact_points: plan.scene.file.recording.contact_points,
        }
    }

    /// Records the present frame, and the controller's map in it.
    pub(super) fn record(&mut self, simulation: &Simulation, mut frame: Frame, map: &[MappedObstacle]) -> &Frame {
        if !self.has_contact_points {
            frame.contact_points = Vec::new();
        }
        let (arm, report) = (simulation.arm(), simulation.report());
        self.contacts.observe(report.frame, &report.tactile.pairs);
        self.bodies.observe(report);
        self.auditor.observe_frame(arm, report);
        let frames = &mut self.recording.frames;
        observe_map(&mut self.recording.map, frames.len(), map);
        frames.push(frame);
        &frames[frames.len() - 1]
    }

    /// The finished recording.
    pub(super) fn finish(mut self, arm: &Arm) -> Recording {
        self.recording.bodies = self.bodies.bodies;
        self.recording.contacts = self.contacts.finish(|link| arm.links[usize::from(link)].name.clone());
        self.recording.audit = self.auditor.audit();
        self.recording
    }
}

/// Takes in the map of a frame, `now`, after those of the frames before.
fn observe_map(obstacles: &mut Vec<MappedObstacle>, frame: usize, now: &[MappedObstacle]) {
    let frame = frame as u32;
    let before = obstacles.len();
    for obstacle in now {
        let as_of = |own: &MappedObstacle| MappedObstacle { first_frame: own.first_frame, ..*obstacle };
        // What stood there like this in the frame before goes on.
        let goes_on = |own: &&mut MappedObstacle| {
            own.last_frame + 1 == frame && MappedObstacle { last_frame: 0, ..**own } == as_of(own)
        };
        match obstacles[..before].iter_mut().find(goes_on) {
            Some(own) => own.last_frame = frame,
            None => obstacles.push(MappedObstacle { first_frame: frame, last_frame: frame, ..*obstacle }),
        }
    }
}

/// Follows which part of the arm touches which object, frame by frame.
#[derive(Clone, Default)]
struct ContactLog {
    open: BTreeMap<ContactPair, Course>,
    closed: Vec<(ContactPair, Course)>,
}

/// One contact so far.
#[derive(Clone, Default)]
struct Course {
    first_frame: u32,
    last_frame: u32,
    peak_force_n: f64,
    force_sum_n: f64,
}

impl ContactLog {
    /// Adds the forces between the pairs that touch in one frame, N.
    fn observe(&mut self, frame: u32, pairs: &[(ContactPair, DVec3)]) {
        for (pair, force) in pairs {
            let force_n = force.length();
            let course = self.open.entry(*pair).or_insert(Course { first_frame: frame, ..Course::default() });
            course.last_frame = frame;
            course.peak_force_n = course.peak_force_n.max(force_n);
            course.force_sum_n += force_n;
        }
        self.closed.extend(self.open.extract_if(.., |_, course| course.last_frame < frame));
    }

    /// All contacts with objects, including those still open, sorted by first frame, then patch, link and object.
    fn finish(mut self, link_name: impl Fn(u16) -> String) -> Vec<Contact> {
        self.closed.extend(self.open);
        self.closed.sort_by_key(|(pair, course)| (course.first_frame, *pair));
        let contact = |(pair, course): (ContactPair, Course)| {
            Some(Contact {
                link: link_name(pair.link),
                patch: pair.patch,
                object: pair.object?,
                first_frame: course.first_frame,
                last_frame: course.last_frame,
                peak_force_n: course.peak_force_n,
                mean_force_n: course.force_sum_n / f64::from(course.last_frame - course.first_frame + 1),
            })
        };
        self.closed.into_iter().filter_map(contact).collect()
    }
}

/// Follows a reach as its observer, and gives the recording so far at any time.
///
/// It has the frames, poses, contacts and the map. It has no goals, because they are known only when they have ended, and its
/// audit is empty. The recording that [`ReachPlan::run`] returns has everything.
pub struct ReachSoFar<'a> {
    plan: &'a ReachPlan,
    reach_index: u64,
    log: Option<ReachLog>,
}

impl<'a> ReachSoFar<'a> {
    /// An empty recording of reach number `reach_index` of a plan.
    pub fn new(plan: &'a ReachPlan, reach_index: u64) -> Self {
        ReachSoFar { plan, reach_index, log: None }
    }

    /// Adds a frame. Must be called for every frame, from the first on.
    pub fn observe(&mut self, Observed { simulation, frame, map }: Observed) {
        let begin = || ReachLog::new(self.plan, &self.plan.controller_name(), self.reach_index, simulation);
        self.log.get_or_insert_with(begin).record(simulation, frame.clone(), map);
    }

    /// The recording so far; `None` before the first frame.
    pub fn recording(&self) -> Option<Recording> {
        let log = self.log.clone()?;
        Some(Recording { audit: Audit::default(), ..log.finish(&self.plan.arm) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAIR: ContactPair = ContactPair { patch: Some(0), link: 2, object: Some(3) };

    fn link_name(link: u16) -> String {
        format!("link {link}")
    }

    /// Tests that a contact which breaks and returns gives two rows, each with the peak and the mean over its own
    /// frames.
    #[test]
    fn a_broken_contact_is_two() {
        let mut log = ContactLog::default();
        let pressed = |force: f64| [(PAIR, DVec3::X * force)];
        log.observe(5, &pressed(1.0));
        log.observe(6, &pressed(3.0));
        log.observe(7, &[]);
        log.observe(8, &pressed(2.0));
        let contacts = log.finish(link_name);
        let summary: Vec<_> =
            contacts.iter().map(|c| (c.first_frame, c.last_frame, c.peak_force_n, c.mean_force_n)).collect();
        assert_eq!(summary, [(5, 6, 3.0, 2.0), (8, 8, 2.0, 2.0)]);
    }

    /// Tests that an object on two bare links gives two contacts, each with the name of its link, and that contacts
    /// with the same first frame are sorted by patch, link and object.
    #[test]
    fn contacts_name_their_links() {
        let bare = |link, object| ContactPair { patch: None, link, object: Some(object) };
        let pairs = [PAIR, bare(4, 1), bare(1, 3), bare(4, 0)];
        let mut log = ContactLog::default();
        log.observe(0, &pairs.map(|pair| (pair, DVec3::X)));
        let contacts = log.finish(link_name);
        let places: Vec<_> =
            contacts.iter().map(|contact| (contact.patch, contact.link.as_str(), contact.object)).collect();
        let expected = [(None, "link 1", 3), (None, "link 4", 0), (None, "link 4", 1), (Some(0), "link 2", 3)];
        assert_eq!(places, expected);
    }
}
