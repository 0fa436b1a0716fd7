//! The controller's map during a reach, as a recording stores it.

use underbrush_recording::MappedObstacle;

/// Follows the map, frame by frame.
#[derive(Clone, Default)]
pub(super) struct MapLog {
    pub(super) obstacles: Vec<MappedObstacle>,
}

impl MapLog {
    /// Takes in the map of a frame.
    pub(super) fn observe(&mut self, frame: usize, now: &[MappedObstacle]) {
        let frame = frame as u32;
        let before = self.obstacles.len();
        for obstacle in now {
            let as_of = |own: &MappedObstacle| MappedObstacle { first_frame: own.first_frame, ..*obstacle };
            // What stood there like this in the frame before goes on.
            let goes_on = |own: &&mut MappedObstacle| {
                own.last_frame + 1 == frame && MappedObstacle { last_frame: 0, ..**own } == as_of(own)
            };
            match self.obstacles[..before].iter_mut().find(goes_on) {
                Some(own) => own.last_frame = frame,
                None => self.obstacles.push(MappedObstacle { first_frame: frame, last_frame: frame, ..*obstacle }),
            }
        }
    }
}
