//! The server's answers about a running reach.

use std::io::Write;
use std::sync::Arc;
use std::time::Duration;

use crate::live::{Live, LiveStatus};
use crate::pack::pack_from;
use crate::response::{FIELDS, Response};
use crate::source::no_such_reach;
use crate::{ReplayContext, Summary};

/// A page gets the status at most this often.
const STATUS_EVERY: Duration = Duration::from_millis(100);
/// A single command steps at most this many frames: a minute.
const MAX_STEPS: usize = 6000;

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
        let Some((latest, status)) = self.live.so_far() else {
            return no_answer();
        };
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
        let Some((latest, _)) = self.live.so_far() else {
            return no_answer();
        };
        match pack_from(&latest.recording, &self.known, latest.verdicts.as_ref(), from) {
            Ok(bytes) => Response::reach(Arc::new(bytes)),
            Err(error) => Response::text(500, error.to_string()),
        }
    }

    /// Does what a command asks for: `pause`, `run`, or `step/N` for N frames.
    pub fn command(&self, command: &str) -> Response {
        let steps = command.strip_prefix("step/").and_then(|count| count.parse().ok());
        match (command, steps) {
            ("pause", _) => self.live.pause(true),
            ("run", _) => self.live.pause(false),
            (_, Some(count @ 1..=MAX_STEPS)) => self.live.step(count),
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
