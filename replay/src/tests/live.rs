//! A running reach, tested through plain sockets.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use serde_json::Value;

use super::server::{Place, Response, ask, get, run};
use super::{KNOWN, reach};
use crate::pack::{pack, pack_from};
use crate::{Held, Live, PartialReach, Server, Source};

/// A reach of 20 frames that is simulated in a thread, its server, and the number of frames so far.
fn start() -> (Place, JoinHandle<()>, Arc<AtomicUsize>) {
    let live = Arc::new(Live::default());
    let place = run(Server::watch(Arc::clone(&live), KNOWN, 0).unwrap());
    let count = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&count);
    let simulation = std::thread::spawn(move || {
        for frame in 1..=20 {
            counted.store(frame, Ordering::SeqCst);
            live.frame(|| Some(so_far(frame.max(7))));
        }
        live.end(so_far(20));
    });
    (place, simulation, count)
}

/// The reach with this many frames.
fn so_far(frames: usize) -> PartialReach {
    PartialReach { recording: reach(0, frames), verdicts: None }
}

fn command(place: &Place, command: &str) -> Response {
    let Place { port, base } = place;
    let lines = [
        format!("POST {base}/api/live/{command} HTTP/1.1"),
        format!("Host: 127.0.0.1:{port}"),
        format!("Origin: http://127.0.0.1:{port}"),
        "Content-Length: 0".to_owned(),
    ];
    ask(*port, &lines.each_ref().map(String::as_str))
}

/// The stream with the status of a running reach.
struct StatusStream(BufReader<TcpStream>);

impl StatusStream {
    fn listen(Place { port, base }: &Place) -> StatusStream {
        let mut stream = TcpStream::connect(("127.0.0.1", *port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        write!(stream, "GET {base}/api/live HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n\r\n").unwrap();
        StatusStream(BufReader::new(stream))
    }

    /// The next status for which this holds.
    fn until(&mut self, holds: impl Fn(&Value) -> bool) -> Value {
        loop {
            let mut line = String::new();
            assert!(self.0.read_line(&mut line).unwrap() > 0, "the server has closed the stream");
            if let Some(data) = line.strip_prefix("data: ") {
                let status = serde_json::from_str(data).unwrap();
                if holds(&status) {
                    return status;
                }
            }
        }
    }
}

/// Tests that a reach waits for the page, is listed as running, is packed as far as it has been simulated, pauses,
/// steps one and several frames, continues, and ends with the whole recording.
#[test]
fn a_running_reach_is_told_paused_and_stepped() {
    let (place, simulation, count) = start();
    // The reach is paused before it is watched, so it stays at its first frame.
    assert_eq!(command(&place, "pause").status, 200);
    let list: Value = serde_json::from_slice(&get(&place, "GET", "/api/reaches").content).unwrap();
    assert_eq!((&list[0]["running"], list.as_array().unwrap().len()), (&true.into(), 1));
    assert_eq!(count.load(Ordering::SeqCst), 1);
    let mut status = StatusStream::listen(&place);
    let first = status.until(|_| true);
    assert_eq!((&first["frames"], &first["paused"], &first["ended"]), (&1.into(), &true.into(), &false.into()));
    assert_eq!(command(&place, "step/1").status, 200);
    assert_eq!(status.until(|status| status["frames"] != 1)["frames"], 2);
    assert_eq!(command(&place, "step/8").status, 200);
    assert_eq!(status.until(|status| status["frames"] == 10)["paused"], true);
    let answer = get(&place, "GET", "/api/reach/0");
    assert_eq!(answer.content, pack(&reach(0, 10), &KNOWN, None).unwrap());
    let answer = get(&place, "GET", "/api/reach/0?from=8");
    assert_eq!(answer.content, pack_from(&reach(0, 10), &KNOWN, None, 8).unwrap());
    assert_eq!(get(&place, "GET", "/api/reach/0?from=x").status, 400);
    assert_eq!(count.load(Ordering::SeqCst), 10, "it does not continue by itself");
    assert_eq!(command(&place, "run").status, 200);
    assert_eq!(status.until(|status| status["ended"] == true)["frames"], 20);
    simulation.join().unwrap();
    let answer = get(&place, "GET", "/api/reach/0");
    assert_eq!(answer.content, pack(&reach(0, 20), &KNOWN, None).unwrap());
    let list: Value = serde_json::from_slice(&get(&place, "GET", "/api/reaches").content).unwrap();
    assert_eq!(list[0]["running"], false);
}

/// Tests that commands are accepted only from the server's own page, as POST, and that unknown commands are refused.
#[test]
fn commands_of_others_are_refused() {
    let (place, _, count) = start();
    let Place { port, base } = &place;
    let line = format!("POST {base}/api/live/step/3 HTTP/1.1");
    let host = format!("Host: 127.0.0.1:{port}");
    for origin in [vec![], vec!["Origin: http://evil.example"], vec!["Origin: null"]] {
        let lines = [vec![line.as_str(), &host, "Content-Length: 0"], origin].concat();
        assert_eq!(ask(*port, &lines).status, 403, "{lines:?}");
    }
    assert_eq!(get(&place, "GET", "/api/live/step/3").status, 404);
    assert_eq!(get(&place, "PUT", "/api/live/step/3").status, 405);
    for unknown in ["stop", "step", "step/0", "step/-1", "step/6001", "step/x", ""] {
        assert_eq!(command(&place, unknown).status, 404, "{unknown}");
    }
    assert_eq!(get(&place, "GET", "/api/reach/1").status, 404);
    // The first frame is simulated without a command; on a busy machine it may still be to come.
    assert!(count.load(Ordering::SeqCst) <= 1, "a refused command does nothing");
}

/// Tests that recordings in memory are listed and packed like recordings in files.
#[test]
fn recordings_in_memory_are_packed_too() {
    let held = |index| Held { recording: reach(index, 20), judging: None };
    let source = Source::of(vec![held(0), held(3)], KNOWN).unwrap();
    assert_eq!(source.reaches.len(), 2);
    assert_eq!((source.reaches[1].number, source.reaches[1].reach_index), (1, 3));
    assert_eq!(source.pack(1).unwrap(), pack(&reach(3, 20), &KNOWN, None).unwrap());
}
