//! HTTP/1.1 as far as the page needs it: a connection brings one request without a body, gets one answer and is closed.
//! Everything that a client could make large or slow is bounded.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::Summary;
use crate::page::policy;

/// Most header fields of a request. Choice: browsers send about 15.
const MAX_FIELDS: usize = 64;

/// What one client may take from the others.
#[derive(Clone, Copy)]
pub struct Limits {
    /// Bytes of a request line with all header fields.
    pub head_bytes: usize,
    /// Time within which the whole head must have arrived.
    pub head_time: Duration,
    /// Time limit of a single send. What is left of it is sent again, so a client that stops reading may keep its connection up
    /// to three times as long.
    pub write_time: Duration,
    /// How long a client that has its answer may keep sending. What it sends is discarded.
    pub linger: Duration,
    /// Connections at a time, each of which has a thread.
    pub connections: usize,
}

impl Default for Limits {
    /// Choice: browsers send heads of less than 1 kB at once, and open six connections to a server.
    fn default() -> Self {
        Limits {
            head_bytes: 16_384,
            head_time: Duration::from_secs(5),
            write_time: Duration::from_secs(10),
            linger: Duration::from_secs(1),
            connections: 64,
        }
    }
}

/// A request whose head has arrived.
pub struct Request {
    /// Its head.
    pub head: Head,
    /// The connection, for an answer that is sent piece by piece.
    pub stream: TcpStream,
}

/// The head of a request.
pub struct Head {
    /// The method, in capitals.
    pub method: String,
    /// The path with the query.
    pub target: String,
    fields: Vec<(String, String)>,
}

impl Request {
    /// The value of a header field that is given once.
    pub fn value(&self, name: &str) -> Option<&str> {
        let mut own = self.head.fields.iter().filter(|(field, _)| field.eq_ignore_ascii_case(name));
        let (_, value) = own.next().filter(|_| own.next().is_none())?;
        Some(value)
    }

    /// Sends the answer and closes the connection.
    pub fn respond(mut self, answer: &Response, limits: &Limits) {
        // The other side may have left.
        if answer.write(&mut self.stream, self.head.method == "HEAD").is_ok() {
            close(self.stream, limits);
        }
    }
}

/// Header fields of all answers. They keep other sites away from what the server gives out.
pub const FIELDS: &str = "X-Content-Type-Options: nosniff\r\n\
                          Cross-Origin-Resource-Policy: same-origin\r\n\
                          Referrer-Policy: no-referrer\r\n\
                          Cache-Control: no-store\r\n\
                          Connection: close\r\n";

/// An answer's status, content type and content.
pub struct Response {
    /// The status.
    pub status: u16,
    kind: &'static str,
    bytes: Arc<Vec<u8>>,
    /// Where the content is instead.
    location: Option<String>,
}

impl Response {
    /// An answer with this content.
    pub fn new(status: u16, kind: &'static str, bytes: impl Into<Vec<u8>>) -> Self {
        Response { status, kind, bytes: Arc::new(bytes.into()), location: None }
    }

    /// An answer with a sentence as plain text.
    pub fn text(status: u16, text: impl Into<String>) -> Self {
        Response::new(status, "text/plain; charset=utf-8", text.into())
    }

    /// A packed reach.
    pub fn reach(bytes: Arc<Vec<u8>>) -> Self {
        Response { status: 200, kind: "application/octet-stream", bytes, location: None }
    }

    /// Sends the client to another path.
    pub fn redirect(path: String) -> Self {
        Response { location: Some(path), ..Response::text(308, "this page is at the same address with a slash") }
    }

    /// The list of reaches.
    pub fn list(reaches: &[Summary]) -> Self {
        // Plain data can always be written.
        Response::new(200, "application/json", serde_json::to_vec(reaches).unwrap_or_default())
    }

    /// Writes the answer, with `head_only` without its content.
    pub fn write(&self, to: &mut impl Write, head_only: bool) -> io::Result<()> {
        let location = self.location.as_ref().map(|path| format!("Location: {path}\r\n"));
        let head = format!(
            "HTTP/1.1 {} \r\nContent-Type: {}\r\nContent-Length: {}\r\nContent-Security-Policy: {}; \
             frame-ancestors 'none'\r\nAccept-Ranges: none\r\nAllow: GET, HEAD\r\n{}{FIELDS}\r\n",
            self.status,
            self.kind,
            self.bytes.len(),
            policy(),
            location.unwrap_or_default(),
        );
        to.write_all(head.as_bytes())?;
        if !head_only {
            to.write_all(&self.bytes)?;
        }
        to.flush()
    }
}

/// Passes the requests to `handle`, each in a thread of its own, so that a slow client does not keep others waiting.
/// Does not return.
pub fn serve(listener: &TcpListener, limits: Limits, handle: impl Fn(Request) + Send + Sync + 'static) {
    // Each open connection holds one reference more. It is returned even if the thread panics.
    let handle = Arc::new(handle);
    for stream in listener.incoming() {
        let Ok(stream) = stream else {
            // The system lacks memory or file descriptors, or the client has left already.
            std::thread::sleep(Duration::from_millis(20));
            continue;
        };
        if Arc::strong_count(&handle) > limits.connections {
            refuse_at_once(&stream);
            continue;
        }
        let handle = Arc::clone(&handle);
        // If no thread can be started, the connection is closed.
        let _ = std::thread::Builder::new().spawn(move || converse(stream, limits, &*handle));
    }
}

/// Answers without a thread, and so without waiting for anything.
fn refuse_at_once(mut stream: &TcpStream) {
    let answer = Response::text(503, "too many connections at a time; try again");
    if stream.set_nonblocking(true).is_ok() && answer.write(&mut stream, false).is_ok() {
        let _ = stream.shutdown(Shutdown::Write);
        // What has been read cannot turn the close into a reset.
        let _ = stream.read(&mut [0; 4096]);
    }
}

fn converse(mut stream: TcpStream, limits: Limits, handle: &impl Fn(Request)) {
    if stream.set_write_timeout(Some(limits.write_time)).is_err() {
        return;
    }
    match read(&mut stream, &limits) {
        Ok(head) => handle(Request { head, stream }),
        Err(Some(refusal)) if refusal.write(&mut stream, false).is_ok() => close(stream, &limits),
        Err(_) => {}
    }
}

/// Ends a connection whose answer has been sent. A close with unread bytes is a reset, after which the other side may
/// lose the answer, so that what it still sends is read for a while.
fn close(mut stream: TcpStream, limits: &Limits) {
    let deadline = Instant::now() + limits.linger;
    if stream.shutdown(Shutdown::Write).is_err() {
        return;
    }
    while let Ok(1..) = read_until(&mut stream, deadline, &mut [0; 4096]) {}
}

/// Reads some bytes; the error is `TimedOut` after the deadline.
fn read_until(stream: &mut TcpStream, deadline: Instant, bytes: &mut [u8]) -> io::Result<usize> {
    loop {
        let left = deadline.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        stream.set_read_timeout(Some(left))?;
        match stream.read(bytes) {
            // Which of the two a read timeout is depends on the system.
            Err(error) if [ErrorKind::WouldBlock, ErrorKind::Interrupted].contains(&error.kind()) => {}
            done => return done,
        }
    }
}

/// Why there is no request: it is refused with this answer, or the client has left or has not sent anything, as browsers
/// do with spare connections.
type NoRequest = Option<Response>;

fn refused(status: u16, text: &str) -> Result<Head, NoRequest> {
    Err(Some(Response::text(status, text)))
}

fn read(stream: &mut TcpStream, limits: &Limits) -> Result<Head, NoRequest> {
    let deadline = Instant::now() + limits.head_time;
    let mut bytes = Vec::new();
    let mut part = [0; 4096];
    loop {
        match read_until(stream, deadline, &mut part) {
            Ok(count @ 1..) => bytes.extend_from_slice(&part[..count]),
            Err(error) if error.kind() == ErrorKind::TimedOut && !bytes.is_empty() => {
                return refused(408, "the request took too long to arrive");
            }
            _ => return Err(None),
        }
        let mut fields = [httparse::EMPTY_HEADER; MAX_FIELDS];
        let mut request = httparse::Request::new(&mut fields);
        match request.parse(&bytes) {
            Ok(httparse::Status::Complete(length)) if length <= limits.head_bytes => return complete(&request),
            Ok(httparse::Status::Partial) if bytes.len() < limits.head_bytes => {}
            Ok(_) | Err(httparse::Error::TooManyHeaders) => {
                return refused(431, "the head of the request is too large");
            }
            Err(_) => return refused(400, "this is no HTTP/1.1 request"),
        }
    }
}

fn complete(request: &httparse::Request) -> Result<Head, NoRequest> {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let fields = request.headers.iter();
    let fields: Vec<(String, String)> = fields.map(|field| (field.name.to_owned(), text(field.value))).collect();
    for (name, value) in &fields {
        if name.eq_ignore_ascii_case("transfer-encoding") {
            return refused(400, "requests have no body here; leave Transfer-Encoding out");
        }
        if name.eq_ignore_ascii_case("content-length") && value != "0" {
            return refused(413, "requests have no body here");
        }
    }
    let [method, target] = [request.method, request.path].map(|part| part.unwrap_or_default().to_owned());
    Ok(Head { method, target, fields })
}
