//! The regular times of a reach whose clock jitters and whose log may lack frames.

use std::f64::consts::TAU;

use underbrush_recording::Frame;
use underbrush_recording::limits::short;
use underbrush_recording::math::{self, median};

use super::mapping::RATE_HZ;
use crate::straight_line;

/// Frames that are missing for at most this long repeat the one before, s. A longer pause is no lost frame.
const LONGEST_PAUSE_S: f64 = 1.0;

/// The step is first found from this many frames.
const FIRST: usize = 512;
/// How far the step may be from the median step, as a share.
const AROUND: f64 = 0.25;
/// How far the step may be from that of a given rate, as a share.
const AROUND_GIVEN: f64 = 0.01;
/// Fewer frames tell less about the rate than one that is given.
const FEW: usize = 50;
/// At the right rate, the times of more frames leave at least this part of a frame empty. Choice: at another rate they
/// seldom do.
const CLEAR: f64 = 0.15;
/// How far the last frame moves, in frames, from one step that is tried to the next.
const CLOSE: f64 = 0.1;
/// A frame that is this far from its place, in frames, does not belong to the rate. Choice: half a frame, and a tenth for
/// the error of the rate that was found.
const FAR: f64 = 0.6;

/// A rate, and the place of each frame among frames of that rate.
#[derive(Debug)]
pub(super) struct TimeGrid {
    pub(super) rate_hz: f64,
    places: Vec<usize>,
}

/// The periodogram of the times at this step. Returns how well the times fit, from 0 (they may be anywhere) to 1 (they fit
/// exactly), and how far frame 0 is after the first time, in frames.
fn fit(times_s: &[f64], step_s: f64) -> (f64, f64) {
    let turns = times_s.iter().map(|time_s| TAU * (time_s - times_s[0]) / step_s);
    let [sine, cosine] = turns.fold([0.0, 0.0], |[sine, cosine], turn| {
        let own = math::sin_cos(turn);
        [sine + own.0, cosine + own.1]
    });
    (math::hypot(sine, cosine) / times_s.len() as f64, math::atan2(sine, cosine) / TAU)
}

/// The step with the best score, s. The steps that are tried lie within the share `around` of a first guess and differ by
/// the share `closeness` of it.
fn nearest(step_s: f64, around: f64, closeness: f64, score: impl Fn(f64) -> f64) -> f64 {
    let most = (around / closeness).ceil().min(2.0 * FIRST as f64) as i32;
    let steps_s = (-most..=most).map(|number| step_s * (1.0 + f64::from(number) * closeness));
    let best = steps_s.map(|own_s| (score(own_s), own_s)).max_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or(step_s, |(_, own_s)| own_s)
}

/// The step that fits best, s, within the share `around` of a first guess. Each turn looks at twice as many frames as the
/// one before, and at steps closer to the best so far.
fn best_step_s(times_s: &[f64], mut step_s: f64, mut around: f64) -> f64 {
    let mut count = FIRST;
    loop {
        let seen = &times_s[..count.min(times_s.len())];
        let closeness = 0.5 * step_s / (seen[seen.len() - 1] - seen[0]);
        let score = |own_s: f64| fit(seen, own_s).0;
        step_s = nearest(step_s, around, closeness, score);
        if seen.len() == times_s.len() {
            return nearest(step_s, closeness, closeness / 8.0, score);
        }
        (count, around) = (2 * count, closeness);
    }
}

/// Finds frame 0 if all frames jitter by less than half a frame. Returns how far frame 0 is after the first time, and the
/// width of a gap, both in frames of this step.
///
/// The places of the times within their frames leave gaps, in which no time lies. Frames begin and end in the middle of one
/// of these gaps. It must put no two times into one frame, and of those that do not, it is the one that leaves the fewest
/// frames without a time, and among equal ones the widest. If every gap puts two times into one frame, the widest is taken,
/// and the width that is returned is 0.
fn phase(times_s: &[f64], step_s: f64) -> (f64, f64) {
    let frames = |time_s: &f64| (time_s - times_s[0]) / step_s;
    let parts = math::sorted(times_s.iter().map(|time_s| frames(time_s).rem_euclid(1.0)).collect());
    let next = parts[1..].iter().copied().chain([parts[0] + 1.0]);
    let mut gaps: Vec<(f64, f64)> = parts.iter().copied().zip(next).collect();
    gaps.sort_by(|a, b| (b.1 - b.0).total_cmp(&(a.1 - a.0)));
    let phases = gaps.iter().take(FEW).map(|(before, after)| (0.5 * (before + after) + 0.5, after - before));
    let phases = phases.map(|(own, wide)| (own - own.round(), wide));
    let place = |time_s: &f64, phase: f64| (frames(time_s) - phase).round();
    let apart = phases.clone().filter(|(own, _)| times_s.is_sorted_by(|a, b| place(a, *own) < place(b, *own)));
    let last = |own: f64| place(&times_s[times_s.len() - 1], own) - place(&times_s[0], own);
    let widest = phases.clone().next().map(|(own, _)| (own, 0.0));
    apart.min_by(|a, b| last(a.0).total_cmp(&last(b.0))).or(widest).unwrap_or_default()
}

impl TimeGrid {
    /// The grid of ascending times, s. The step is the one that fits best, near that of the rate if one is given, and a frame is at
    /// the nearest place.
    ///
    /// # Errors
    /// What was found, what is allowed, and the number of the frame, if frames are missing for long, if more are missing than not, or
    /// if one is half a frame away from its place.
    pub(super) fn of(times_s: &[f64], rate_hz: Option<f64>) -> Result<Self, (String, String, usize)> {
        let steps_s: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let Some(median_s) = rate_hz.map(|rate_hz| 1.0 / rate_hz).or(median(steps_s.clone())) else {
            return Ok(TimeGrid { rate_hz: 1.0, places: vec![0; times_s.len()] });
        };
        if !RATE_HZ.hold(1.0 / median_s) {
            return Err((format!("a frame every {} s", short(median_s)), RATE_HZ.to_string(), 0));
        }
        if let Some(before) = steps_s.iter().position(|own_s| *own_s > LONGEST_PAUSE_S.max(1.5 * median_s)) {
            let [start, end] = [before, before + 1].map(|frame| short(times_s[frame]));
            let found = format!("no frame from {start} to {end} s");
            return Err((found, format!("no pause of more than {LONGEST_PAUSE_S} s"), before + 1));
        }
        let given = rate_hz.map(|_| phase(times_s, median_s));
        let mut certain = given.filter(|(_, wide)| times_s.len() < FEW || *wide > CLEAR);
        let around = if rate_hz.is_some() { AROUND_GIVEN } else { AROUND };
        let mut step_s = if certain.is_some() { median_s } else { best_step_s(times_s, median_s, around) };
        let wide = |own_s: f64| phase(times_s, own_s).1;
        if rate_hz.is_none() && times_s.len() <= FIRST && wide(step_s) <= CLEAR {
            // Many steps fit few frames whose times jitter much, but only one leaves much of a frame without times.
            let closeness = CLOSE * median_s / (times_s[times_s.len() - 1] - times_s[0]);
            let clear_s = nearest(median_s, AROUND, closeness, wide);
            certain = Some(phase(times_s, clear_s)).filter(|(_, wide)| *wide > CLEAR);
            step_s = certain.map_or(step_s, |_| clear_s);
        }
        // Two frames before the first one leave room for what is moved.
        let begin = certain.map_or_else(|| fit(times_s, step_s).1, |(phase, _)| phase);
        let mut start_s = times_s[0] + (begin - 2.0) * step_s;
        let mut places = vec![0; times_s.len()];
        // Twice, because the line through the places gives a better step.
        for _ in 0..2 {
            places = times_s.iter().map(|time_s| ((time_s - start_s) / step_s).round() as usize).collect();
            if certain.is_none() {
                let points = places.iter().map(|place| *place as f64).zip(times_s.iter().copied());
                // The time at place 0 and the step.
                [start_s, step_s] = straight_line(points);
            }
        }
        let off = |place: usize, time_s: f64| (time_s - start_s) / step_s - place as f64;
        // Of two frames at one place, the one that is farther off moves.
        for later in 1..places.len() {
            let [one, other] = [later - 1, later].map(|own| off(places[own], times_s[own]));
            match places[later] <= places[later - 1] {
                true if other > -one => places[later] += 1,
                true => places[later - 1] = places[later - 1].saturating_sub(1),
                false => {}
            }
        }
        let all = (places[places.len() - 1] + 1).saturating_sub(places[0]);
        let missing = all.saturating_sub(times_s.len());
        // A rate that is given stays, unless it drifts by a frame.
        let stays = |rate_hz: &f64| (rate_hz * step_s - 1.0).abs() * all as f64 <= 1.0;
        let rate_hz = rate_hz.filter(stays).unwrap_or(1.0 / step_s);
        if missing > times_s.len() {
            let found = format!("{missing} of {all} frames missing at {} Hz", short(rate_hz));
            return Err((found, "at most as many missing frames as there are".into(), 0));
        }
        let is_far = |own: &usize| {
            off(places[*own], times_s[*own]).abs() >= FAR || (*own > 0 && places[*own] <= places[own - 1])
        };
        if let Some(frame) = (0..places.len()).find(is_far) {
            let found = format!("a frame at {} s", short(times_s[frame]));
            return Err((found, format!("frames at one rate, here {} Hz, to half a frame", short(rate_hz)), frame));
        }
        let first = places[0];
        Ok(TimeGrid { rate_hz, places: places.into_iter().map(|place| place.saturating_sub(first)).collect() })
    }

    /// The frames at their places. Those that are missing repeat the one before. Times begin at 0.
    pub(super) fn filled(&self, frames: Vec<Frame>) -> Vec<Frame> {
        let mut filled: Vec<Frame> = Vec::with_capacity(frames.len());
        for (frame, place) in frames.into_iter().zip(&self.places) {
            while let Some(last) = filled.last().filter(|_| filled.len() < *place) {
                filled.push(last.clone());
            }
            filled.push(frame);
        }
        for (number, frame) in filled.iter_mut().enumerate() {
            frame.time_s = number as f64 / self.rate_hz;
        }
        filled
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Tests that the rate is found and every frame is at its place, if times jitter by up to 0.4 frames and frames are lost
        /// one by one and for up to a second.
        #[test]
        fn jitter_below_half_a_frame_is_placed(
            (jitters, lost) in (600..1500_usize).prop_flat_map(|count| {
                (prop::collection::vec(-0.4..0.4_f64, count), prop::collection::vec((10..count, 1..99_usize), 0..4))
            }),
            single in 2..40_usize,
            rate_hz in 99.0..101.0_f64,
        ) {
            let is_there = |place: &usize| {
                *place == 0
                    || !(place % (single * 11) == 5 || lost.iter().any(|(from, count)| (*from..from + count).contains(place)))
            };
            let places: Vec<usize> = (0..jitters.len()).filter(is_there).collect();
            prop_assume!(jitters.len() < 2 * places.len());
            let times_s: Vec<f64> = places.iter().map(|place| (*place as f64 + jitters[*place]) / rate_hz).collect();
            let longest_s = times_s.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
            prop_assume!(longest_s < LONGEST_PAUSE_S);
            let grid = TimeGrid::of(&times_s, None).unwrap();
            prop_assert_eq!(&grid.places, &places);
            prop_assert!((grid.rate_hz / rate_hz - 1.0).abs() < 1e-3);
        }

        /// Tests that the frames of a short reach are at their places if the rate is given and times jitter by up to 0.4 frames.
        #[test]
        fn a_given_rate_places_frames_that_jitter(jitters in prop::collection::vec(-0.4..0.4_f64, 50..300)) {
            let time_s = |(frame, jitter): (u32, &f64)| 0.01 * (f64::from(frame) + jitter);
            let times_s: Vec<f64> = (0..).zip(&jitters).map(time_s).collect();
            let grid = TimeGrid::of(&times_s, Some(100.0)).unwrap();
            prop_assert_eq!(&grid.places, &(0..jitters.len()).collect::<Vec<_>>());
            prop_assert!((grid.rate_hz - 100.0).abs() < 1e-9);
        }
    }

    fn times(count: usize, of: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..count).map(of).collect()
    }

    /// Tests that stamps in whole milliseconds, jitter and lost frames do not change the rate, and that lost frames are filled in.
    #[test]
    fn a_rate_is_found_in_spite_of_jitter_and_lost_frames() {
        let stamped = times(3000, |frame| (frame as f64 * 1000.0 / 30.0).round() / 1000.0);
        assert!((TimeGrid::of(&stamped, None).unwrap().rate_hz - 30.0).abs() < 0.01);
        let jittered = times(2700, |frame| 0.01 * frame as f64 + if frame % 2 == 0 { 6e-4 } else { 0.0 });
        assert!((TimeGrid::of(&jittered, None).unwrap().rate_hz - 100.0).abs() < 0.01);
        let lost: Vec<f64> = times(2700, |frame| 5.0 + 0.01 * frame as f64)
            .into_iter()
            .filter(|own| (own * 100.0).round() as usize % 50 > 1)
            .collect();
        let grid = TimeGrid::of(&lost, None).unwrap();
        assert!((grid.rate_hz - 100.0).abs() < 0.01);
        let frames = lost.iter().map(|time_s| Frame { time_s: *time_s, ..Frame::blank(1) }).collect();
        let filled = grid.filled(frames);
        // The first two of the log are lost.
        assert_eq!(filled.len(), 2698);
        for (number, frame) in filled.iter().enumerate() {
            assert!((frame.time_s - 0.01 * number as f64).abs() < 1e-9, "{number}: {}", frame.time_s);
        }
    }

    /// Tests that long pauses, a change of the rate, more missing frames than others, and a wrong unit of time are refused.
    #[test]
    fn pauses_and_two_rates_are_refused() {
        let paused = times(200, |frame| 0.01 * frame as f64 + if frame < 100 { 0.0 } else { 3.0 });
        assert!(TimeGrid::of(&paused, None).unwrap_err().0.contains("from 0.99 to 4 s"));
        let faster =
            times(200, |frame| if frame < 120 { 0.01 * frame as f64 } else { 1.2 + 0.006 * (frame - 120) as f64 });
        assert!(TimeGrid::of(&faster, None).is_err());
        let sparse = times(200, |frame| 0.001 * frame as f64 + 0.9 * (frame / 3) as f64);
        assert!(TimeGrid::of(&sparse, None).unwrap_err().0.contains("frames missing at"));
        assert!(TimeGrid::of(&times(200, |frame| 1e-9 * frame as f64), None).unwrap_err().0.contains("a frame every"));
        let half = TimeGrid::of(&times(50, |frame| 0.02 * frame as f64), Some(100.0)).unwrap();
        assert_eq!(half.filled(vec![Frame::blank(1); 50]).len(), 99);
    }
}
