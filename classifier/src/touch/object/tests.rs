//! Tests of which contacts are one object.

use super::tracker::ObjectTracker;
use crate::touch::frame::SkinTracker;
use crate::trial::tests::{Drawn, recording};

/// The numbers of the objects that taxel 7 touches: one for each contact, which lasts 20 frames of 10 ms, begins where the
/// patch has been shifted to, m, moves on to another place, and is followed by a pause, s.
fn objects(contacts: &[([f64; 2], f64)]) -> Vec<u64> {
    let touch = [(7, 1.0, Some(0))];
    let mut frames: Vec<Drawn<'_>> = Vec::new();
    for ([from, to], pause_s) in contacts {
        frames.extend((0..20).map(|step| (from + (to - from) * f64::from(step) / 19.0, &touch[..])));
        frames.extend((0..(pause_s / 0.01) as usize).map(|_| (*to, &[][..])));
    }
    let recording = recording(&frames);
    let mut patches = vec![SkinTracker::new(&recording.layout, None, 0.03).unwrap()];
    let mut tracker = ObjectTracker::default();
    let mut numbers = Vec::new();
    let mut was_touched = false;
    for frame in &recording.frames {
        patches[0].update(frame).unwrap();
        tracker.update(&patches, frame.time_s);
        let object = tracker.of_region.first().copied().flatten();
        if let Some(index) = object.filter(|_| !was_touched) {
            numbers.push(tracker.objects[index].number);
        }
        was_touched = object.is_some();
    }
    numbers
}

/// Tests that a contact that begins within 3 cm of where another began, or was felt last, in the last 30 s belongs to its
/// object, and any other begins one.
#[test]
fn contacts_of_one_place_are_one_object() {
    let walk = ([0.0, 0.1], 0.1);
    assert_eq!(objects(&[([0.0; 2], 0.1), ([0.029; 2], 0.1), ([0.08; 2], 0.1)]), [1, 1, 2]);
    assert_eq!(objects(&[walk, ([0.129; 2], 0.1)]), [1, 1]);
    assert_eq!(objects(&[walk, ([-0.029; 2], 0.1)]), [1, 1]);
    assert_eq!(objects(&[walk, ([0.05; 2], 0.1)]), [1, 2]);
    assert_eq!(objects(&[([0.0; 2], 29.0), ([0.0; 2], 31.0), ([0.0; 2], 0.1)]), [1, 1, 2]);
}
