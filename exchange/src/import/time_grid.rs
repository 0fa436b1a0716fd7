//! The regular times of a reach whose clock jitters and whose log may lack frames.

use underbrush_recording::Frame;
use underbrush_recording::limits::short;

use super::mapping::RATE_HZ;

/// Frames that are missing for at most this long repeat the one before, s. A longer pause is no lost frame.
const LONGEST_PAUSE_S: f64 = 1.0;

/// A rate, and the place of each frame among frames of that rate.
#[derive(Debug)]
pub(super) struct TimeGrid {
    pub(super) rate_hz: f64,
    places: Vec<usize>,
}

impl TimeGrid {
    /// The grid of ascending times, s. A step between two frames counts as the nearest whole number of median steps. The rate is the
    /// mean over all of these, unless one is given.
    ///
    /// # Errors
    /// What was found and what is allowed, if frames are missing for long, if more are missing than not, or if one is half a frame
    /// away from its place.
    pub(super) fn of(times_s: &[f64], rate_hz: Option<f64>) -> Result<Self, (String, String)> {
        let steps_s: Vec<f64> = times_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let mut sorted_s = steps_s.clone();
        sorted_s.sort_by(f64::total_cmp);
        let median_s = sorted_s.get(sorted_s.len() / 2).copied();
        let Some(step_s) = rate_hz.map(|rate_hz| 1.0 / rate_hz).or(median_s) else {
            return Ok(TimeGrid { rate_hz: 1.0, places: vec![0; times_s.len()] });
        };
        if !RATE_HZ.hold(1.0 / step_s) {
            return Err((format!("a frame every {} s", short(step_s)), RATE_HZ.to_string()));
        }
        let mut places = vec![0];
        for (own_s, start_s) in steps_s.iter().zip(times_s) {
            if *own_s > LONGEST_PAUSE_S.max(1.5 * step_s) {
                let found = format!("no frame from {} to {} s", short(*start_s), short(start_s + own_s));
                return Err((found, format!("no pause of more than {LONGEST_PAUSE_S} s")));
            }
            let frames = (own_s / step_s).round().max(1.0) as usize;
            places.push(places[places.len() - 1] + frames);
        }
        let last = places[places.len() - 1];
        let (all, missing) = (last + 1, last + 1 - times_s.len());
        if missing > times_s.len() {
            let found = format!("{missing} of {all} frames missing at {} Hz", short(1.0 / step_s));
            return Err((found, "at most as many missing frames as there are".into()));
        }
        let whole_s = times_s[times_s.len() - 1] - times_s[0];
        let rate_hz = rate_hz.unwrap_or(last as f64 / whole_s);
        let far = |(time_s, place): &(&f64, &usize)| ((*time_s - times_s[0]) * rate_hz - **place as f64).abs() >= 0.5;
        if let Some((time_s, _)) = times_s.iter().zip(&places).find(far) {
            let found = format!("a frame at {} s", short(*time_s));
            return Err((found, format!("frames at one rate, here {} Hz, to half a frame", short(rate_hz))));
        }
        Ok(TimeGrid { rate_hz, places })
    }

    /// The frames with those that are missing, which repeat the one before. Times begin at 0.
    pub(super) fn filled(&self, frames: Vec<Frame>) -> Vec<Frame> {
        let start_s = frames.first().map_or(0.0, |frame| frame.time_s);
        let mut filled: Vec<Frame> = Vec::with_capacity(frames.len());
        for (mut frame, place) in frames.into_iter().zip(&self.places) {
            frame.time_s -= start_s;
            while let Some(last) = filled.last().filter(|_| filled.len() < *place) {
                let missing = (*place - filled.len() + 1) as f64;
                let time_s = last.time_s + (frame.time_s - last.time_s) / missing;
                filled.push(Frame { time_s, ..last.clone() });
            }
            filled.push(frame);
        }
        filled
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
