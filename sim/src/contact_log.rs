//! The contacts of a reach, each from its first frame to its last.

use std::collections::BTreeMap;

use glam::DVec3;
use underbrush_recording::Contact;

/// Follows which patch touches which object, frame by frame.
#[derive(Default)]
pub struct ContactLog {
    open: BTreeMap<(Option<u16>, u16), (Contact, f64)>,
    closed: Vec<Contact>,
}

impl ContactLog {
    /// Takes the forces between patches and objects in one frame, N.
    pub fn observe(&mut self, frame: u32, pairs: &BTreeMap<(Option<u16>, u16), DVec3>) {
        for (pair, force) in pairs {
            let force_n = force.length();
            let (contact, sum) = self.open.entry(*pair).or_insert_with(|| {
                let contact = Contact {
                    patch: pair.0,
                    object: pair.1,
                    first_frame: frame,
                    last_frame: frame,
                    peak_force_n: 0.0,
                    mean_force_n: 0.0,
                };
                (contact, 0.0)
            });
            contact.last_frame = frame;
            contact.peak_force_n = contact.peak_force_n.max(force_n);
            *sum += force_n;
        }
        let ended: Vec<_> = self
            .open
            .iter()
            .filter(|(_, (contact, _))| contact.last_frame < frame)
            .map(|(pair, _)| *pair)
            .collect();
        for pair in ended {
            self.close(pair);
        }
    }

    /// All contacts, those still open included, by first frame, then patch, then object.
    pub fn finish(mut self) -> Vec<Contact> {
        for pair in self.open.keys().copied().collect::<Vec<_>>() {
            self.close(pair);
        }
        self.closed
            .sort_by_key(|contact| (contact.first_frame, contact.patch, contact.object));
        self.closed
    }

    fn close(&mut self, pair: (Option<u16>, u16)) {
        if let Some((mut contact, sum)) = self.open.remove(&pair) {
            contact.mean_force_n = sum / f64::from(contact.last_frame - contact.first_frame + 1);
            self.closed.push(contact);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pins that a contact which breaks and comes again makes two rows, with peak and mean of its own frames.
    #[test]
    fn a_broken_contact_is_two() {
        let mut log = ContactLog::default();
        let pressed = |force: f64| BTreeMap::from([((Some(0), 3), DVec3::X * force)]);
        log.observe(5, &pressed(1.0));
        log.observe(6, &pressed(3.0));
        log.observe(7, &BTreeMap::new());
        log.observe(8, &pressed(2.0));
        let contacts = log.finish();
        let summary: Vec<_> = contacts
            .iter()
            .map(|c| (c.first_frame, c.last_frame, c.peak_force_n, c.mean_force_n))
            .collect();
        assert_eq!(summary, [(5, 6, 3.0, 2.0), (8, 8, 2.0, 2.0)]);
    }
}
