//! The server of the page on 127.0.0.1. It serves nothing but the page and the reaches it was given. It is read-only,
//! except for the commands to a running reach.

use std::net::Ipv4Addr;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use tiny_http::{Method, Request};

use crate::answer::Answer;
use crate::page::PAGE;
use crate::running::Running;
use crate::{Known, Live, ReplayError, Source};

/// While this many requests are in progress, further ones are answered with 503. Choice: a browser opens six
/// connections.
const MAX_REQUESTS: usize = 256;
/// Packed reaches that are kept. Choice: two that are compared, and their neighbours.
const KEPT: usize = 4;

/// Paths of the news of a running reach and of commands to it.
const NEWS: &str = "/api/live";
const COMMAND: &str = "/api/live/";

/// The packed reaches that were asked for last.
type Kept = Vec<(usize, Arc<Vec<u8>>)>;

/// Where the reaches come from.
enum Content {
    Stored(Box<Source>, Mutex<Kept>),
    Running(Running),
}

/// What all requests share.
struct Shared {
    content: Content,
    /// Values of `Host` that are answered. Requests with other values come from pages of other sites that let their
    /// name resolve to this machine.
    hosts: Vec<String>,
    requests: AtomicUsize,
}

/// The values of `Host` that browsers send for this machine and a port. They leave out port 80, the default of HTTP.
pub fn hosts(port: u16) -> Vec<String> {
    let names = ["127.0.0.1", "localhost"];
    let mut hosts = names.map(|name| format!("{name}:{port}")).to_vec();
    if port == 80 {
        hosts.extend(names.map(str::to_owned));
    }
    hosts
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
        Server::of(Content::Stored(Box::new(source), Mutex::default()), port)
    }

    /// As [`Server::start`], with one reach that is being simulated.
    ///
    /// # Errors
    /// [`ReplayError::Serve`] if the port is taken or not allowed.
    pub fn watch(live: Arc<Live>, known: Known, port: u16) -> Result<Self, ReplayError> {
        Server::of(Content::Running(Running { live, known }), port)
    }

    fn of(content: Content, port: u16) -> Result<Self, ReplayError> {
        let http = tiny_http::Server::http((Ipv4Addr::LOCALHOST, port)).map_err(|error| ReplayError::Serve {
            port,
            source: std::io::Error::other(error.to_string()),
        })?;
        let port = http.server_addr().to_ip().map_or(port, |address| address.port());
        let shared = Shared {
            content,
            hosts: hosts(port),
            requests: AtomicUsize::new(0),
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
            if self.shared.requests.fetch_add(1, Ordering::Relaxed) >= MAX_REQUESTS {
                self.shared.requests.fetch_sub(1, Ordering::Relaxed);
                Answer::text(503, "too many requests at a time").send(request);
                continue;
            }
            let shared = Arc::clone(&self.shared);
            // Each request has a thread, because a client that does not read its answer must not keep the others
            // waiting.
            std::thread::spawn(move || {
                let slot = Slot(shared);
                slot.0.serve(request);
            });
        }
    }
}

/// A request that is being answered. It counts until this is dropped, even if the answer panics.
struct Slot(Arc<Shared>);

impl Drop for Slot {
    fn drop(&mut self) {
        self.0.requests.fetch_sub(1, Ordering::Relaxed);
    }
}

impl Shared {
    fn serve(&self, request: Request) {
        let answer = self.refusal(&request).unwrap_or_else(|| self.answer(&request));
        match &self.content {
            // News is sent until the reach ends.
            Content::Running(running) if answer.status == 200 && request.url() == NEWS => running.tell(request),
            _ => answer.send(request),
        }
    }

    /// The answer to a request that is refused; `None` if the request is allowed.
    fn refusal(&self, request: &Request) -> Option<Answer> {
        let values = |name: &'static str| -> Vec<&str> {
            let headers = request.headers().iter();
            let own = headers.filter(|header| header.field.equiv(name));
            own.map(|header| header.value.as_str()).collect()
        };
        let known = |host: &str| self.hosts.iter().any(|own| own.eq_ignore_ascii_case(host));
        let hosts = values("Host");
        if hosts.len() != 1 || !known(hosts[0]) {
            return Some(Answer::text(
                403,
                "this server answers only for its own address on this machine",
            ));
        }
        let commands = matches!(self.content, Content::Running(_));
        match request.method() {
            Method::Get | Method::Head => None,
            // Another site could send a command, but not with this server as its origin.
            Method::Post if commands && request.url().starts_with(COMMAND) => {
                let origins = values("Origin");
                let own = origins.first().and_then(|origin| origin.strip_prefix("http://"));
                (origins.len() != 1 || !own.is_some_and(known))
                    .then(|| Answer::text(403, "only the page of this server can give commands"))
            }
            _ => Some(Answer::text(405, "only GET and HEAD are allowed here")),
        }
    }

    fn answer(&self, request: &Request) -> Answer {
        let (path, query) = request.url().split_once('?').unwrap_or((request.url(), ""));
        let number = path.strip_prefix("/api/reach/").filter(|number| is_number(number));
        let command = path.strip_prefix(COMMAND).filter(|_| *request.method() == Method::Post);
        match (&self.content, number, command) {
            _ if path == "/" => Answer::new(200, "text/html; charset=utf-8", PAGE),
            (Content::Stored(source, _), ..) if path == "/api/reaches" => Answer::list(source.reaches()),
            (Content::Stored(source, kept), Some(number), _) => reach(source, kept, number),
            (Content::Running(running), ..) if path == "/api/reaches" => running.list(),
            (Content::Running(running), Some(number), _) => running.reach(number, query),
            (Content::Running(running), _, Some(command)) => running.command(command),
            (Content::Running(_), ..) if path == NEWS && *request.method() == Method::Get => Answer::text(200, ""),
            _ => Answer::text(404, "no such page"),
        }
    }
}

/// A packed reach. Only one is packed at a time, so memory stays bounded however many are asked for.
fn reach(source: &Source, kept: &Mutex<Kept>, number: &str) -> Answer {
    let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
    // A number that does not fit into `usize` is not in the list either.
    let number = number.parse().unwrap_or(usize::MAX);
    if let Some(place) = kept.iter().position(|(other, _)| *other == number) {
        let found = kept.remove(place);
        kept.push(found);
    } else {
        match source.pack(number) {
            Ok(bytes) => kept.push((number, Arc::new(bytes))),
            Err(error @ ReplayError::NoSuchReach { .. }) => return Answer::text(404, error.to_string()),
            Err(error) => return Answer::text(500, error.to_string()),
        }
        let surplus = kept.len().saturating_sub(KEPT);
        kept.drain(..surplus);
    }
    let bytes = kept.last().map(|(_, bytes)| Arc::clone(bytes)).unwrap_or_default();
    Answer::reach(bytes)
}

fn is_number(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())
}
