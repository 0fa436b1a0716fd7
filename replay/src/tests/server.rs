//! The server, through plain sockets.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use super::source;
use crate::Server;
use crate::page::PAGE;
use crate::server::hosts;

/// Starts a server of two reaches, which runs until the test ends. Returns its port.
fn start(folder: &Path) -> u16 {
    let server = Server::start(source(folder), 0).unwrap();
    let address = server.address();
    let port = address.trim_start_matches("http://127.0.0.1:").trim_end_matches('/');
    let port = port.parse().unwrap();
    std::thread::spawn(move || server.run());
    port
}

/// The answer to a request: its status, its head and its content.
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub content: Vec<u8>,
}

/// Sends these lines, followed by an empty one, and reads the answer to its end.
pub fn ask(port: u16, lines: &[&str]) -> Answer {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    // No answer takes a minute. A server that hangs must fail the test.
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let request = format!("{}\r\nConnection: close\r\n\r\n", lines.join("\r\n"));
    stream.write_all(request.as_bytes()).unwrap();
    let mut bytes = Vec::new();
    stream.read_to_end(&mut bytes).unwrap();
    let end = bytes.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
    let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
    Answer {
        status: head.split(' ').nth(1).unwrap().parse().unwrap(),
        head: head.to_lowercase(),
        content: bytes[end + 4..].to_vec(),
    }
}

/// Asks for a path with this method, as a browser on this machine.
pub fn get(port: u16, method: &str, path: &str) -> Answer {
    ask(
        port,
        &[&format!("{method} {path} HTTP/1.1"), &format!("Host: 127.0.0.1:{port}")],
    )
}

/// Pins that the page, the list and the reaches are served, with headers that keep other sites away.
#[test]
fn the_server_gives_out_page_list_and_reaches() {
    let folder = tempfile::tempdir().unwrap();
    let expected = source(folder.path()).pack(1).unwrap();
    let port = start(folder.path());
    let page = get(port, "GET", "/");
    assert_eq!((page.status, page.content.as_slice()), (200, PAGE.as_bytes()));
    for header in [
        "content-type: text/html; charset=utf-8",
        "content-security-policy: default-src 'none'",
        "x-content-type-options: nosniff",
        "cross-origin-resource-policy: same-origin",
    ] {
        assert!(page.head.contains(header), "no {header} in {}", page.head);
    }
    let list: serde_json::Value = serde_json::from_slice(&get(port, "GET", "/api/reaches").content).unwrap();
    assert_eq!(list.as_array().unwrap().len(), 2);
    let reach = get(port, "GET", "/api/reach/1?again");
    assert_eq!((reach.status, reach.content), (200, expected.clone()));
    let head = get(port, "HEAD", "/api/reach/1");
    assert_eq!((head.status, head.content.len()), (200, 0));
    assert!(
        head.head.contains(&format!("content-length: {}", expected.len())),
        "{}",
        head.head
    );
}

/// Pins that paths outside the set, other methods and the names of other hosts are refused, and that the server still
/// answers afterwards.
#[test]
fn everything_else_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let port = start(folder.path());
    for path in [
        "/../Cargo.toml",
        "/..%2f..%2fetc/passwd",
        "//etc/passwd",
        "/api/reach/2",
        "/api/reach/99999999999999999999999",
        "/api/reach/-1",
        "/api/reach/+1",
        "/api/reach/",
        "/api/reach/0/../0",
        "/api",
        "/index.html",
    ] {
        assert_eq!(get(port, "GET", path).status, 404, "{path}");
    }
    for method in ["POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE"] {
        let answer = get(port, method, "/api/reach/0");
        assert_eq!(answer.status, 405, "{method}");
        assert!(answer.head.contains("allow: get, head"), "{}", answer.head);
    }
    let own = format!("Host: 127.0.0.1:{port}");
    for hosts in [
        vec!["Host: evil.example".to_owned()],
        vec![format!("Host: evil.example:{port}")],
        vec!["Host: 127.0.0.1".to_owned()],
        vec![own.clone(), "Host: evil.example".to_owned()],
        vec![],
    ] {
        let lines: Vec<&str> = std::iter::once("GET / HTTP/1.1")
            .chain(hosts.iter().map(String::as_str))
            .collect();
        assert_eq!(ask(port, &lines).status, 403, "{hosts:?}");
    }
    assert_eq!(
        ask(port, &["GET / HTTP/1.1", &format!("Host: LOCALHOST:{port}")]).status,
        200
    );
}

/// Pins that the addresses of port 80 count with and without the port, which browsers leave out.
#[test]
fn port_80_may_be_left_out() {
    assert_eq!(hosts(80), ["127.0.0.1:80", "localhost:80", "127.0.0.1", "localhost"]);
    assert_eq!(hosts(8080), ["127.0.0.1:8080", "localhost:8080"]);
}

/// Pins that a request for a range, however large, is answered with the whole content, and that the server says that it
/// does not support ranges.
#[test]
fn ranges_are_ignored() {
    let folder = tempfile::tempdir().unwrap();
    let expected = source(folder.path()).pack(0).unwrap();
    let port = start(folder.path());
    for range in [
        "bytes=0-18446744073709551615",
        "bytes=5-1",
        "bytes=0-0,1-1,2-2,3-3",
        "bytes=-99999999999999999999",
    ] {
        let host = format!("Host: 127.0.0.1:{port}");
        let answer = ask(port, &["GET /api/reach/0 HTTP/1.1", &host, &format!("Range: {range}")]);
        assert_eq!((answer.status, &answer.content), (200, &expected), "{range}");
        assert!(answer.head.contains("accept-ranges: none"), "{}", answer.head);
    }
}

/// Pins that a hundred requests at once are all answered, while other clients are connected that never finish their
/// request.
#[test]
fn a_hundred_requests_at_once_are_answered() {
    let folder = tempfile::tempdir().unwrap();
    let expected = Arc::new(source(folder.path()).pack(0).unwrap());
    let port = start(folder.path());
    let idle: Vec<TcpStream> = (0..20)
        .map(|_| {
            let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
            stream.write_all(b"GET /api/reach/0 HTTP/1.1\r\nHost: ").unwrap();
            stream
        })
        .collect();
    let threads = (0..100).map(|_| {
        let expected = Arc::clone(&expected);
        std::thread::spawn(move || {
            let answer = get(port, "GET", "/api/reach/0");
            assert_eq!((answer.status, &answer.content), (200, &*expected));
        })
    });
    let threads: Vec<_> = threads.collect();
    threads.into_iter().for_each(|thread| thread.join().unwrap());
    drop(idle);
}

/// Pins that a port that is taken is an error that names it.
#[test]
fn a_taken_port_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let port = start(folder.path());
    let error = Server::start(source(folder.path()), port).err().unwrap().to_string();
    assert!(error.contains(&port.to_string()) && error.contains("--port"), "{error}");
}
