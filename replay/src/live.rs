//! A running reach: passes its frames from the thread that simulates it to the server's threads, and passes their
//! commands back.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde::Serialize;
use underbrush_recording::Recording;

use crate::Verdicts;

/// A request waits for the simulation at most this long. A frame takes milliseconds.
const PATIENCE: Duration = Duration::from_secs(30);

/// What the page is told about a running reach.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct News {
    /// Number of frames so far.
    pub frames: usize,
    /// Whether the simulation waits for a command.
    pub paused: bool,
    /// Whether the reach has ended.
    pub ended: bool,
}

/// A reach as far as it has been simulated.
pub struct SoFar {
    /// The recording.
    pub recording: Recording,
    /// The verdicts on its frames, if there is a model.
    pub verdicts: Option<Verdicts>,
}

#[derive(Default)]
struct State {
    news: News,
    /// Whether a page has asked for news. The reach waits for this, so that its beginning is seen.
    watched: bool,
    /// Frames that are still to be simulated while paused.
    steps: usize,
    /// Whether a request waits for the reach so far.
    wanted: bool,
    latest: Option<Arc<SoFar>>,
}

/// The state that the threads share.
///
/// ```
/// use std::sync::Arc;
/// use underbrush_replay::Live;
///
/// let live = Arc::new(Live::new());
/// let simulation = Arc::clone(&live);
/// // The first frame waits until a page asks for news.
/// let thread = std::thread::spawn(move || simulation.frame(|| None));
/// while live.news_after(None).frames == 0 {}
/// thread.join().expect("the frame has been passed on");
/// live.pause(true);
/// assert!(live.news_after(None).paused);
/// ```
#[derive(Default)]
pub struct Live {
    state: Mutex<State>,
    changed: Condvar,
}

impl Live {
    /// A reach that has not begun.
    pub fn new() -> Self {
        Live::default()
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reports that one more frame has been simulated. `so_far` returns the reach with this frame, and is called only
    /// if a request asks for it. Blocks until the first page asks for news, and while the reach is paused.
    pub fn frame(&self, so_far: impl Fn() -> Option<SoFar>) {
        let mut state = self.state();
        state.news.frames += 1;
        loop {
            if state.wanted {
                state.latest = so_far().map(Arc::new);
                state.wanted = false;
            }
            self.changed.notify_all();
            if state.watched && (!state.news.paused || state.steps > 0) {
                break;
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        state.steps = state.steps.saturating_sub(1);
    }

    /// Reports that the reach has ended; `whole` is the complete reach.
    pub fn end(&self, whole: SoFar) {
        let mut state = self.state();
        state.news.ended = true;
        state.news.paused = false;
        state.wanted = false;
        state.latest = Some(Arc::new(whole));
        self.changed.notify_all();
    }

    /// The reach so far, and the news about it. `None` if the simulation does not answer.
    pub fn so_far(&self) -> Option<(Arc<SoFar>, News)> {
        let mut state = self.state();
        if !state.news.ended {
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
        state.latest.clone().map(|latest| (latest, state.news))
    }

    /// Pauses the simulation or lets it go on.
    pub fn pause(&self, paused: bool) {
        let mut state = self.state();
        state.news.paused = paused && !state.news.ended;
        state.steps = 0;
        self.changed.notify_all();
    }

    /// Simulates this many frames, then pauses.
    pub fn step(&self, frames: usize) {
        let mut state = self.state();
        state.news.paused = !state.news.ended;
        state.steps = frames;
        self.changed.notify_all();
    }

    /// Returns the news as soon as they differ from `known`, or after a second. Also lets the reach begin.
    pub fn news_after(&self, known: Option<News>) -> News {
        let mut state = self.state();
        state.watched = true;
        self.changed.notify_all();
        let same = |state: &mut State| Some(state.news) == known;
        let waited = self.changed.wait_timeout_while(state, Duration::from_secs(1), same);
        waited.unwrap_or_else(PoisonError::into_inner).0.news
    }
}
