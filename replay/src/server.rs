//! The server of the page on 127.0.0.1: read-only, and with nothing but the page and the reaches it was given.

use std::io::Cursor;
use std::net::Ipv4Addr;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use tiny_http::{Header, Method, Request, Response};

use crate::page::PAGE;
use crate::{ReplayError, Source};

/// More requests at a time are answered with 503. Choice: a browser opens six connections.
const MAX_REQUESTS: usize = 256;
/// Packed reaches that are kept. Choice: two that are compared, and their neighbours.
const KEPT: usize = 4;

/// The page may run its own script and ask this server for reaches, and nothing else.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; connect-src 'self'; \
                      img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// An answer's status, content type and content.
struct Answer {
    status: u16,
    kind: &'static str,
    bytes: Arc<Vec<u8>>,
}

impl Answer {
    fn new(status: u16, kind: &'static str, bytes: impl Into<Vec<u8>>) -> Self {
        Answer {
            status,
            kind,
            bytes: Arc::new(bytes.into()),
        }
    }

    fn text(status: u16, text: impl Into<String>) -> Self {
        Answer::new(status, "text/plain; charset=utf-8", text.into())
    }
}

/// The packed reaches that were asked for last.
type Kept = Vec<(usize, Arc<Vec<u8>>)>;

/// What all requests share.
struct Shared {
    source: Source,
    /// Values of `Host` that are answered. Others come from pages of other sites that had their name resolve to this
    /// machine.
    hosts: [String; 2],
    kept: Mutex<Kept>,
    running: AtomicUsize,
}

/// A server that listens.
pub struct Server {
    http: tiny_http::Server,
    port: u16,
    shared: Arc<Shared>,
}

impl Server {
    /// Starts to listen on 127.0.0.1; port 0 takes a free one.
    ///
    /// # Errors
    /// [`ReplayError::Serve`] if the port is taken or not allowed.
    pub fn start(source: Source, port: u16) -> Result<Self, ReplayError> {
        let http = tiny_http::Server::http((Ipv4Addr::LOCALHOST, port)).map_err(|error| ReplayError::Serve {
            port,
            source: std::io::Error::other(error.to_string()),
        })?;
        let port = http.server_addr().to_ip().map_or(port, |address| address.port());
        let shared = Shared {
            source,
            hosts: ["127.0.0.1", "localhost"].map(|name| format!("{name}:{port}")),
            kept: Mutex::default(),
            running: AtomicUsize::new(0),
        };
        Ok(Server {
            http,
            port,
            shared: Arc::new(shared),
        })
    }

    /// The address of the page.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
    }

    /// Answers requests until the program ends.
    pub fn run(&self) {
        for request in self.http.incoming_requests() {
            if self.shared.running.fetch_add(1, Ordering::Relaxed) >= MAX_REQUESTS {
                self.shared.running.fetch_sub(1, Ordering::Relaxed);
                respond(request, Answer::text(503, "too many requests at a time"));
                continue;
            }
            let shared = Arc::clone(&self.shared);
            // A thread for each, because one that does not read its answer must not keep the others waiting.
            std::thread::spawn(move || {
                let answer = shared.answer(&request);
                respond(request, answer);
                shared.running.fetch_sub(1, Ordering::Relaxed);
            });
        }
    }
}

impl Shared {
    fn answer(&self, request: &Request) -> Answer {
        let hosts: Vec<&str> = request
            .headers()
            .iter()
            .filter(|header| header.field.equiv("Host"))
            .map(|header| header.value.as_str())
            .collect();
        let known = |host: &str| self.hosts.iter().any(|own| own.eq_ignore_ascii_case(host));
        if hosts.len() != 1 || !known(hosts[0]) {
            return Answer::text(403, "this server answers only for its own address on this machine");
        }
        if !matches!(request.method(), Method::Get | Method::Head) {
            return Answer::text(405, "only GET and HEAD are allowed");
        }
        let path = request.url().split('?').next().unwrap_or_default();
        match path.strip_prefix("/api/reach/") {
            None if path == "/" => Answer::new(200, "text/html; charset=utf-8", PAGE),
            None if path == "/api/reaches" => {
                let list = serde_json::to_vec(self.source.reaches());
                Answer::new(200, "application/json", list.unwrap_or_default())
            }
            Some(number) if is_number(number) => self.reach(number),
            _ => Answer::text(404, "no such page"),
        }
    }

    /// A packed reach. One is packed at a time, so that memory is bounded however many are asked for.
    fn reach(&self, number: &str) -> Answer {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        // A number too large for a place in the list is no place in the list.
        let number = number.parse().unwrap_or(usize::MAX);
        if let Some(place) = kept.iter().position(|(other, _)| *other == number) {
            let found = kept.remove(place);
            kept.push(found);
        } else {
            match self.source.pack(number) {
                Ok(bytes) => kept.push((number, Arc::new(bytes))),
                Err(error @ ReplayError::NoSuchReach { .. }) => return Answer::text(404, error.to_string()),
                Err(error) => return Answer::text(500, error.to_string()),
            }
            let surplus = kept.len().saturating_sub(KEPT);
            kept.drain(..surplus);
        }
        let bytes = kept.last().map(|(_, bytes)| Arc::clone(bytes)).unwrap_or_default();
        Answer {
            status: 200,
            kind: "application/octet-stream",
            bytes,
        }
    }
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}

/// Bytes that several answers share.
struct SharedBytes(Arc<Vec<u8>>);

impl AsRef<[u8]> for SharedBytes {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

fn respond(request: Request, answer: Answer) {
    let headers = [
        ("Content-Type", answer.kind),
        ("Content-Security-Policy", POLICY),
        ("X-Content-Type-Options", "nosniff"),
        ("Cross-Origin-Resource-Policy", "same-origin"),
        ("Referrer-Policy", "no-referrer"),
        ("Cache-Control", "no-store"),
        ("Accept-Ranges", "none"),
        ("Allow", "GET, HEAD"),
    ];
    let headers = headers
        .into_iter()
        .filter_map(|(name, value)| Header::from_bytes(name, value).ok());
    let length = answer.bytes.len();
    let body = Cursor::new(SharedBytes(answer.bytes));
    let response = Response::new(answer.status.into(), headers.collect(), body, Some(length), None);
    // The other side may have left.
    let _ = request.respond(response.with_chunked_threshold(usize::MAX));
}
