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

/// Where a server listens: its port, and the path with its key, without a slash at its end.
#[derive(Clone, PartialEq, Debug)]
pub struct Place {
    pub port: u16,
    pub base: String,
}

/// Lets a server run until the test ends.
pub fn run(server: Server) -> Place {
    let address = server.address.trim_end_matches('/');
    let (port, key) = address.trim_start_matches("http://127.0.0.1:").split_once('/').unwrap();
    let place = Place { port: port.parse().unwrap(), base: format!("/{key}") };
    std::thread::spawn(move || server.run());
    place
}

/// Starts a server of two reaches.
fn start(folder: &Path) -> Place {
    run(Server::start(source(folder), 0).unwrap())
}

/// The answer to a request: its status, its head and its content.
pub struct Response {
    pub status: u16,
    pub head: String,
    pub content: Vec<u8>,
}

/// Sends these lines, followed by an empty one, and reads the answer to its end.
pub fn ask(port: u16, lines: &[&str]) -> Response {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    // No answer takes a minute. A server that hangs must fail the test.
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let request = format!("{}\r\nConnection: close\r\n\r\n", lines.join("\r\n"));
    stream.write_all(request.as_bytes()).unwrap();
    let mut bytes = Vec::new();
    stream.read_to_end(&mut bytes).unwrap();
    let end = bytes.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
    let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
    Response {
        status: head.split(' ').nth(1).unwrap().parse().unwrap(),
        head: head.to_lowercase(),
        content: bytes[end + 4..].to_vec(),
    }
}

/// Asks for a path after the key with this method, as a browser on this machine.
pub fn get(place: &Place, method: &str, path: &str) -> Response {
    let Place { port, base } = place;
    let line = format!("{method} {base}{path} HTTP/1.1");
    ask(*port, &[&line, &format!("Host: 127.0.0.1:{port}")])
}

/// Tests that the page, the list and the reaches are served, with headers that keep other sites away.
#[test]
fn the_server_gives_out_page_list_and_reaches() {
    let folder = tempfile::tempdir().unwrap();
    let expected = source(folder.path()).pack(1).unwrap();
    let place = start(folder.path());
    let page = get(&place, "GET", "/");
    assert_eq!((page.status, page.content.as_slice()), (200, PAGE.as_bytes()));
    for header in [
        "content-type: text/html; charset=utf-8",
        "content-security-policy: default-src 'none'",
        "x-content-type-options: nosniff",
        "cross-origin-resource-policy: same-origin",
    ] {
        assert!(page.head.contains(header), "no {header} in {}", page.head);
    }
    // Without its last slash, the address leads to the page, too, also with a query.
    for query in ["", "?from=mail"] {
        let bare = get(&place, "GET", query);
        let location = format!("location: {}/{query}\r\n", place.base);
        assert!(bare.status == 308 && bare.head.contains(&location), "{}", bare.head);
    }
    let list: serde_json::Value = serde_json::from_slice(&get(&place, "GET", "/api/reaches").content).unwrap();
    assert_eq!(list.as_array().unwrap().len(), 2);
    let reach = get(&place, "GET", "/api/reach/1?again");
    assert_eq!((reach.status, reach.content), (200, expected.clone()));
    let head = get(&place, "HEAD", "/api/reach/1");
    assert_eq!((head.status, head.content.len()), (200, 0));
    assert!(head.head.contains(&format!("content-length: {}", expected.len())), "{}", head.head);
}

/// Tests that paths outside the set, other methods and the names of other hosts are refused, and that the server still
/// answers afterwards.
#[test]
fn everything_else_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let place = start(folder.path());
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
        assert_eq!(get(&place, "GET", path).status, 404, "{path}");
    }
    for method in ["POST", "PUT", "DELETE", "OPTIONS", "PATCH", "TRACE"] {
        let answer = get(&place, method, "/api/reach/0");
        assert_eq!(answer.status, 405, "{method}");
        assert!(answer.head.contains("allow: get, head"), "{}", answer.head);
    }
    let Place { port, base } = place;
    let own = format!("Host: 127.0.0.1:{port}");
    let line = format!("GET {base}/ HTTP/1.1");
    for hosts in [
        vec!["Host: evil.example".to_owned()],
        vec![format!("Host: evil.example:{port}")],
        vec!["Host: 127.0.0.1".to_owned()],
        vec![own.clone(), "Host: evil.example".to_owned()],
        vec![],
    ] {
        let lines: Vec<&str> = std::iter::once(line.as_str()).chain(hosts.iter().map(String::as_str)).collect();
        assert_eq!(ask(port, &lines).status, 403, "{hosts:?}");
    }
    assert_eq!(ask(port, &[&line, &format!("Host: LOCALHOST:{port}")]).status, 200);
}

/// Tests that the addresses of port 80 count with and without the port, which browsers leave out.
#[test]
fn port_80_may_be_left_out() {
    assert_eq!(hosts(80), ["127.0.0.1:80", "localhost:80", "127.0.0.1", "localhost"]);
    assert_eq!(hosts(8080), ["127.0.0.1:8080", "localhost:8080"]);
}

/// Tests that a request for a range, however large, is answered with the whole content, and that the server says that
/// it does not support ranges.
#[test]
fn ranges_are_ignored() {
    let folder = tempfile::tempdir().unwrap();
    let expected = source(folder.path()).pack(0).unwrap();
    let place = start(folder.path());
    let Place { port, base } = place;
    let (line, host) = (format!("GET {base}/api/reach/0 HTTP/1.1"), format!("Host: 127.0.0.1:{port}"));
    for range in ["bytes=0-18446744073709551615", "bytes=5-1", "bytes=0-0,1-1,2-2,3-3", "bytes=-99999999999999999999"] {
        let answer = ask(port, &[&line, &host, &format!("Range: {range}")]);
        assert_eq!((answer.status, &answer.content), (200, &expected), "{range}");
        assert!(answer.head.contains("accept-ranges: none"), "{}", answer.head);
    }
}

/// Tests that fifty requests at once are all answered.
#[test]
fn fifty_requests_at_once_are_answered() {
    let folder = tempfile::tempdir().unwrap();
    let expected = Arc::new(source(folder.path()).pack(0).unwrap());
    let place = start(folder.path());
    let threads = (0..50).map(|_| {
        let (expected, place) = (Arc::clone(&expected), place.clone());
        std::thread::spawn(move || {
            let answer = get(&place, "GET", "/api/reach/0");
            assert_eq!((answer.status, &answer.content), (200, &*expected));
        })
    });
    let threads: Vec<_> = threads.collect();
    threads.into_iter().for_each(|thread| thread.join().unwrap());
}

/// Tests that an address without the key, or with another one, is refused, whatever follows, with the remedy.
#[test]
fn nothing_is_given_out_without_the_key() {
    let folder = tempfile::tempdir().unwrap();
    let (place, other) = (start(folder.path()), start(folder.path()));
    assert_ne!(place.base, other.base, "each server has a key of its own");
    let own = &place.base;
    for base in ["", &other.base, &own[..own.len() - 1], &format!("{own}0"), &own.to_uppercase(), &format!("/{own}")] {
        for path in ["/", "/api/reaches", "/api/reach/0", "/no/such/page"] {
            for method in ["GET", "HEAD", "POST"] {
                let wrong = Place { base: base.to_owned(), ..place };
                let answer = get(&wrong, method, path);
                assert_eq!(answer.status, 403, "{method} {base}{path}");
                let text = String::from_utf8(answer.content).unwrap();
                assert!(method == "HEAD" || text.contains("printed"), "{text}");
            }
        }
    }
    assert_eq!(get(&place, "GET", "/").status, 200);
}

/// Tests that the policy allows the page's own script and style by their hashes, and no others.
#[test]
fn the_policy_names_script_and_style_by_hash() {
    let folder = tempfile::tempdir().unwrap();
    let page = get(&start(folder.path()), "GET", "/");
    let policy = page.head.lines().find(|line| line.starts_with("content-security-policy: ")).unwrap();
    for source in ["script-src 'sha256-", "style-src 'sha256-", "frame-ancestors 'none'"] {
        assert!(policy.contains(source), "{policy}");
    }
    assert!(!policy.contains("unsafe"), "{policy}");
}

/// Tests that a port that is taken is an error that names it.
#[test]
fn a_taken_port_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let Place { port, .. } = start(folder.path());
    let error = Server::start(source(folder.path()), port).err().unwrap().to_string();
    assert!(error.contains(&port.to_string()) && error.contains("--port"), "{error}");
}
