//! The contacts of a reach, each from its first frame to its last.

use std::collections::BTreeMap;

use glam::DVec3;
use underbrush_recording::Contact;

use crate::simulation::ContactPair;

/// Follows which part of the arm touches which object, frame by frame.
#[derive(Clone, Default)]
pub struct ContactLog {
    open: BTreeMap<ContactPair, Course>,
    closed: Vec<(ContactPair, Course)>,
}

/// One contact so far.
#[derive(Clone)]
struct Course {
    first_frame: u32,
    last_frame: u32,
    peak_force_n: f64,
    force_sum_n: f64,
}

impl ContactLog {
    /// Adds the forces between the pairs that touch in one frame, N.
    pub fn observe(&mut self, frame: u32, pairs: &[(ContactPair, DVec3)]) {
        for (pair, force) in pairs {
            let force_n = force.length();
            let course = self.open.entry(*pair).or_insert(Course {
                first_frame: frame,
                last_frame: frame,
                peak_force_n: 0.0,
                force_sum_n: 0.0,
            });
            course.last_frame = frame;
            course.peak_force_n = course.peak_force_n.max(force_n);
            course.force_sum_n += force_n;
        }
        self.closed.extend(self.open.extract_if(.., |_, course| course.last_frame < frame));
    }

    /// All contacts with objects, including those still open, sorted by first frame, then patch, link and object.
    pub fn finish(mut self, link_name: impl Fn(u16) -> String) -> Vec<Contact> {
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
