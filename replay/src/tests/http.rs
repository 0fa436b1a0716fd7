//! Clients that send or take too much, or nothing: none of them may end the server, fill its memory or keep others
//! waiting.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::time::{Duration, Instant};

use crate::http::{Limits, Response, serve};

/// Limits that a test need not wait for.
const LIMITS: Limits = Limits {
    head_bytes: 16_384,
    head_time: Duration::from_millis(300),
    write_time: Duration::from_millis(300),
    linger: Duration::from_millis(300),
    connections: 8,
};
/// More than the buffers of a connection hold.
const MANY_BYTES: usize = 64_000_000;

/// Starts a server that answers `/` with "fine" and `/large` with many bytes.
fn start(limits: Limits) -> u16 {
    let listener = TcpListener::bind(("127.0.0.1", 0)).unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        serve(&listener, limits, move |request| {
            let answer = match request.head.target.as_str() {
                "/large" => Response::new(200, "text/plain", vec![b'x'; MANY_BYTES]),
                _ => Response::text(200, "fine"),
            };
            request.respond(&answer, &limits);
        });
    });
    port
}

fn connect(port: u16) -> TcpStream {
    let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    // A server that hangs must fail the test.
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    stream
}

/// The status that comes back after these bytes; `None` if the connection is closed without an answer.
fn status(port: u16, request: &str) -> Option<u16> {
    let mut stream = connect(port);
    stream.write_all(request.as_bytes()).unwrap();
    status_from(stream)
}

fn status_from(mut stream: TcpStream) -> Option<u16> {
    let mut bytes = Vec::new();
    if let Err(error) = stream.read_to_end(&mut bytes) {
        assert_eq!(error.kind(), ErrorKind::ConnectionReset);
    }
    let text = String::from_utf8_lossy(&bytes);
    text.strip_prefix("HTTP/1.1 ").and_then(|rest| rest.get(..3)).map(|status| status.parse().unwrap())
}

/// Waits until the server answers again, which it must as soon as its limits of time have passed.
fn answers_again(port: u16) {
    let deadline = Instant::now() + Duration::from_secs(30);
    while status(port, "GET / HTTP/1.1\r\n\r\n") != Some(200) {
        assert!(Instant::now() < deadline, "the server does not answer any more");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Tests that a request that announces a body, of whatever length, is refused, and that the server continues.
#[test]
fn bodies_are_refused() {
    let port = start(LIMITS);
    for (field, expected) in [
        ("Content-Length: 1000000000000000", 413),
        ("Content-Length: 99999999999999999999999999", 413),
        ("content-length: 1", 413),
        ("Content-Length: -1", 413),
        ("Content-Length: 0\r\nContent-Length: 5", 413),
        ("Transfer-Encoding: chunked", 400),
        ("Content-Length: 0", 200),
    ] {
        let found = status(port, &format!("POST / HTTP/1.1\r\n{field}\r\n\r\n"));
        assert_eq!(found, Some(expected), "{field}");
    }
}

/// Tests that a head that never ends is refused after the limit of bytes, without waiting for its rest, and that what
/// is no request is refused, too.
#[test]
fn large_heads_and_other_protocols_are_refused() {
    let port = start(LIMITS);
    let long = "x".repeat(LIMITS.head_bytes);
    assert_eq!(status(port, &format!("GET / HTTP/1.1\r\nA: {long}")), Some(431));
    assert_eq!(status(port, &format!("GET /{long}")), Some(431));
    assert_eq!(status(port, &format!("GET / HTTP/1.1\r\n{}\r\n", "A: b\r\n".repeat(65))), Some(431));
    let short = "x".repeat(LIMITS.head_bytes - 40);
    assert_eq!(status(port, &format!("GET / HTTP/1.1\r\nA: {short}\r\n\r\n")), Some(200));
    for other in ["\u{16}\u{3}\u{1} no HTTP\r\n\r\n", "GET\r\n\r\n", "GET / HTTP/2.0\r\n\r\n"] {
        assert_eq!(status(port, other), Some(400), "{other:?}");
    }
    // A head without an end: the server stops reading.
    let mut stream = connect(port);
    stream.write_all(b"GET / HTTP/1.1\r\nA: ").unwrap();
    let part = vec![b'x'; 1 << 20];
    let begin = Instant::now();
    while stream.write_all(&part).is_ok() {
        assert!(begin.elapsed() < Duration::from_secs(30), "the server reads for ever");
    }
    answers_again(port);
}

/// Tests that clients that send their head byte by byte, or not at all, are cut off after the limit of time.
#[test]
fn slow_clients_are_cut_off() {
    let port = start(LIMITS);
    let mut drip = connect(port);
    let start = Instant::now();
    // Each byte comes well within the limit, the whole head never does.
    while drip.write_all(b"G").is_ok() && drip.flush().is_ok() {
        assert!(start.elapsed() < Duration::from_secs(30), "the server waits for ever");
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(status(port, "GET / HTTP/1.1\r\n"), Some(408));
    assert_eq!(status(port, ""), None, "a spare connection is closed without an answer");
}

/// Tests that connections beyond the limit are refused at once, and that there is room again when the others are gone.
#[test]
fn connections_beyond_the_limit_are_refused() {
    let port = start(Limits { head_time: Duration::from_secs(600), ..LIMITS });
    let mut open: Vec<TcpStream> = (0..900).map(|_| connect(port)).collect();
    for refused in open.split_off(LIMITS.connections) {
        assert_eq!(status_from(refused), Some(503));
    }
    drop(open);
    answers_again(port);
}

/// Tests that a client that does not take its answer loses its connection, and that one that does gets everything.
#[test]
fn a_client_that_never_reads_is_cut_off() {
    let port = start(Limits { connections: 1, ..LIMITS });
    let mut idle = connect(port);
    idle.write_all(b"GET /large HTTP/1.1\r\n\r\n").unwrap();
    // Others are answered only when its connection is gone.
    answers_again(port);
    let mut taken = Vec::new();
    let _ = idle.read_to_end(&mut taken);
    assert!(taken.len() < MANY_BYTES, "the server has waited for a client that does not read");
    let port = start(LIMITS);
    let mut busy = connect(port);
    busy.write_all(b"GET /large HTTP/1.1\r\n\r\n").unwrap();
    let mut taken = Vec::new();
    busy.read_to_end(&mut taken).unwrap();
    assert!(taken.len() > MANY_BYTES);
}
