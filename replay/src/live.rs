//! A running reach: passes its frames from the thread that simulates it to the server's threads, passes their commands
//! back, and gives the server's answers about it.

use std::io::Write;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde::Serialize;
use underbrush_recording::{FRAME_PERIOD_S, Recording};

use crate::http::{FIELDS, Response};
use crate::pack::pack_from;
use crate::source::no_such_reach;
use crate::{ReplayContext, Summary, Verdicts};

/// A request waits for the simulation at most this long. A frame takes milliseconds.
const PATIENCE: Duration = Duration::from_secs(30);
/// A page gets the status at most this often.
const STATUS_EVERY: Duration = Duration::from_millis(100);
/// A single command steps at most this many frames: a minute.
const MAX_STEPS: usize = 6000;

/// The status of a running reach, which the page shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LiveStatus {
    /// Number of frames so far.
    pub frames: usize,
    /// Whether the simulation waits for a command.
    pub paused: bool,
    /// Whether the reach has ended.
    pub ended: bool,
}

/// A reach as far as it has been simulated.
pub struct PartialReach {
    /// The recording.
    pub recording: Recording,
    /// The verdicts on its frames, if there is a model.
    pub verdicts: Option<Verdicts>,
}

#[derive(Default)]
struct State {
    status: LiveStatus,
    /// Whether a page has asked for the status. The reach waits for this, so that its beginning is seen.
    watched: bool,
    /// Frames that are still to be simulated while paused.
    steps: usize,
    /// Whether a request waits for the reach so far.
    wanted: bool,
    latest: Option<Arc<PartialReach>>,
}

/// The state that the threads share; by default of a reach that has not begun.
///
/// ```
/// use std::sync::Arc;
/// use underbrush_replay::Live;
///
/// let live = Arc::new(Live::default());
/// let simulation = Arc::clone(&live);
/// // The first frame waits until a page asks for the status.
/// let thread = std::thread::spawn(move || simulation.frame(|| None));
/// while live.status_after(None).frames == 0 {}
/// thread.join().expect("the frame has been passed on");
/// live.pause(true, 0);
/// assert!(live.status_after(None).paused);
/// ```
#[derive(Default)]
pub struct Live {
    state: Mutex<State>,
    changed: Condvar,
}

impl Live {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reports that one more frame has been simulated. `so_far` returns the reach with this frame, and is called only
    /// if a request asks for it. Blocks until the first page asks for the status, and while the reach is paused. Otherwise it
    /// waits a frame's time, so that a reader can follow.
    pub fn frame(&self, so_far: impl Fn() -> Option<PartialReach>) {
        let mut state = self.state();
        state.status.frames += 1;
        loop {
            if state.wanted {
                state.latest = so_far().map(Arc::new);
                state.wanted = false;
            }
            self.changed.notify_all();
            if state.watched && (!state.status.paused || state.steps > 0) {
                break;
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        state.steps = state.steps.saturating_sub(1);
        let paused = state.status.paused;
        drop(state);
        if !paused {
            std::thread::sleep(Duration::from_secs_f64(FRAME_PERIOD_S));
        }
    }

    /// Reports that the reach has ended; `whole` is the complete reach.
    pub fn end(&self, whole: PartialReach) {
        let mut state = self.state();
        state.status.ended = true;
        state.status.paused = false;
        state.wanted = false;
        state.latest = Some(Arc::new(whole));
        self.changed.notify_all();
    }

    /// The reach so far and its status. `None` if the simulation does not answer.
    pub fn so_far(&self) -> Option<(Arc<PartialReach>, LiveStatus)> {
        let mut state = self.state();
        if !state.status.ended {
            state.wanted = true;
            self.changed.notify_all();
            let waiting = |state: &mut State| state.wanted;
            let waited = self.changed.wait_timeout_while(state, PATIENCE, waiting);
            let (answered, timeout) = waited.unwrap_or_else(PoisonError::into_inner);
            if timeout.timed_out() {
                return None;
            }
            state = answered;
        }
        state.latest.clone().map(|latest| (latest, state.status))
    }

    /// Pauses the simulation after this many more frames, or continues it.
    pub fn pause(&self, paused: bool, steps: usize) {
        let mut state = self.state();
        state.status.paused = paused && !state.status.ended;
        state.steps = steps;
        self.changed.notify_all();
    }

    /// Returns the status as soon as it differs from `known`, or after a second. Also lets the reach begin.
    pub fn status_after(&self, known: Option<LiveStatus>) -> LiveStatus {
        let mut state = self.state();
        state.watched = true;
        self.changed.notify_all();
        let same = |state: &mut State| Some(state.status) == known;
        let waited = self.changed.wait_timeout_while(state, Duration::from_secs(1), same);
        waited.unwrap_or_else(PoisonError::into_inner).0.status
    }
}

/// A running reach, and what the caller knows.
pub struct Running {
    /// The reach.
    pub live: Arc<Live>,
    /// What the caller knows and the recording does not hold.
    pub known: ReplayContext,
}

impl Running {
    /// The list, which holds this reach alone.
    pub fn list(&self) -> Response {
        let Some((latest, status)) = self.live.so_far() else { return no_answer() };
        let line = Summary::of(&latest.recording, &self.known);
        Response::list(&[Summary { running: !status.ended, ..line }])
    }

    /// The reach so far; with `from=N` in the query only what follows the first N frames.
    pub fn reach(&self, number: usize, query: &str) -> Response {
        let mut parts = query.split('&').filter_map(|part| part.strip_prefix("from="));
        let Ok(from) = parts.next().map_or(Ok(0), str::parse) else {
            return Response::text(400, "from is the number of frames that are known");
        };
        if number > 0 {
            return Response::text(404, no_such_reach(number, 1).to_string());
        }
        let Some((latest, _)) = self.live.so_far() else { return no_answer() };
        match pack_from(&latest.recording, &self.known, latest.verdicts.as_ref(), from) {
            Ok(bytes) => Response::reach(Arc::new(bytes)),
            Err(error) => Response::text(500, error.to_string()),
        }
    }

    /// Does what a command asks for: `pause`, `run`, or `step/N` for N frames.
    pub fn command(&self, command: &str) -> Response {
        let steps = command.strip_prefix("step/").and_then(|count| count.parse().ok());
        match (command, steps) {
            ("pause", _) => self.live.pause(true, 0),
            ("run", _) => self.live.pause(false, 0),
            (_, Some(count @ 1..=MAX_STEPS)) => self.live.pause(true, count),
            _ => return Response::text(404, "no such command"),
        }
        Response::text(200, "done")
    }

    /// Sends the status as server-sent events until the reach ends or the client disconnects.
    pub fn tell(&self, mut to: impl Write) {
        let head = format!("HTTP/1.1 200 \r\nContent-Type: text/event-stream\r\n{FIELDS}\r\n");
        let mut send = |text: &str| to.write_all(text.as_bytes()).and_then(|()| to.flush());
        let mut sent_status: Option<LiveStatus> = None;
        let mut sent = send(&head);
        while sent.is_ok() {
            let status = self.live.status_after(sent_status);
            // Sending a comment shows whether the client is still connected.
            let event = match sent_status == Some(status) {
                true => ": still here\n\n".to_owned(),
                false => format!("data: {}\n\n", serde_json::to_string(&status).unwrap_or_default()),
            };
            sent = send(&event);
            sent_status = Some(status);
            if status.ended {
                break;
            }
            std::thread::sleep(STATUS_EVERY);
        }
    }
}

fn no_answer() -> Response {
    Response::text(500, "the simulation does not answer; look at the terminal in which it runs")
}
