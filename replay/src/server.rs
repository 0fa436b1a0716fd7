//! The server of the page on 127.0.0.1. It serves nothing but the page and the reaches it was given, and only to who
//! has the key in its address. It is read-only, except for the commands to a running reach.

use std::io;
use std::net::{Ipv4Addr, TcpListener};
use std::sync::{Arc, Mutex, PoisonError};

use underbrush_recording::Fault;

use crate::http::{self, Limits, Request, Response};
use crate::live::{Live, Running};
use crate::page::PAGE;
use crate::{ReplayContext, Source};

/// Packed reaches that are kept. Choice: two that are compared, and their neighbours.
const KEPT: usize = 4;

/// Path for the status of a running reach.
const STATUS: &str = "/api/live";
/// Beginning of the paths for commands to a running reach.
const COMMAND: &str = "/api/live/";

/// The packed reaches that were asked for last, the newest first.
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
    /// The hash of the key. Comparing hashes takes the same time wherever two keys differ.
    key: blake3::Hash,
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
    listener: TcpListener,
    /// The address of the page. Anyone who knows it can read the reaches, and command a running one.
    pub address: String,
    shared: Shared,
}

impl Server {
    /// Starts to listen on 127.0.0.1; port 0 takes a free one.
    ///
    /// # Errors
    /// [`Fault::Run`] if the port is taken or not allowed.
    pub fn start(source: Source, port: u16) -> Result<Self, Fault> {
        Server::of(Content::Stored(Box::new(source), Mutex::default()), port)
    }

    /// As [`Server::start`], with one reach that is being simulated.
    ///
    /// # Errors
    /// [`Fault::Run`] if the port is taken or not allowed.
    pub fn watch(live: Arc<Live>, known: ReplayContext, port: u16) -> Result<Self, Fault> {
        Server::of(Content::Running(Running { live, known }), port)
    }

    fn of(content: Content, port: u16) -> Result<Self, Fault> {
        let refused = |error: io::Error| {
            let text = format!("cannot serve on 127.0.0.1, port {port}: {error}");
            Fault::Run(format!("{text}; choose another --port, or 0 for any free one"))
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(refused)?;
        let port = listener.local_addr().map_err(refused)?.port();
        let key = random_key().map_err(refused)?;
        Ok(Server {
            listener,
            address: format!("http://127.0.0.1:{port}/{key}/"),
            shared: Shared { content, hosts: hosts(port), key: blake3::hash(key.as_bytes()) },
        })
    }

    /// Answers requests until the program ends.
    pub fn run(self) {
        let limits = Limits::default();
        let shared = self.shared;
        http::serve(&self.listener, limits, move |request| shared.serve(request, &limits));
    }
}

/// 128 random bits in hexadecimal digits.
fn random_key() -> io::Result<String> {
    let mut bytes = [0; 16];
    getrandom::fill(&mut bytes).map_err(io::Error::other)?;
    Ok(format!("{:032x}", u128::from_ne_bytes(bytes)))
}

impl Shared {
    fn serve(&self, request: Request, limits: &Limits) {
        let path = self.path(&request.head.target).map(str::to_owned);
        let answer = match &path {
            Some(path) => self.refusal(&request, path).unwrap_or_else(|| self.answer(&request, path)),
            None => Response::text(
                403,
                "the address lacks the key of this server; open the whole address that the program has printed",
            ),
        };
        match &self.content {
            // The status is sent until the reach ends.
            Content::Running(running) if answer.status == 200 && path.as_deref() == Some(STATUS) => {
                running.tell(request.stream);
            }
            _ => request.respond(&answer, limits),
        }
    }

    /// What follows the key in an address, with its slash if there is one; `None` without the key.
    fn path<'a>(&self, target: &'a str) -> Option<&'a str> {
        let rest = target.strip_prefix('/')?;
        let key = rest.split(['/', '?']).next()?;
        (blake3::hash(key.as_bytes()) == self.key).then(|| &rest[key.len()..])
    }

    /// The answer to a request that is refused; `None` if the request is allowed.
    fn refusal(&self, request: &Request, path: &str) -> Option<Response> {
        let known = |host: &str| self.hosts.iter().any(|own| own.eq_ignore_ascii_case(host));
        if !request.value("Host").is_some_and(known) {
            return Some(Response::text(403, "this server answers only for its own address on this machine"));
        }
        let commands = matches!(self.content, Content::Running(_));
        match request.head.method.as_str() {
            "GET" | "HEAD" => None,
            // Another site could send a command, but not with this server as its origin.
            "POST" if commands && path.starts_with(COMMAND) => {
                let own = request.value("Origin").and_then(|origin| origin.strip_prefix("http://"));
                (!own.is_some_and(known)).then(|| Response::text(403, "only the page of this server can give commands"))
            }
            _ => Some(Response::text(405, "only GET and HEAD are allowed here")),
        }
    }

    fn answer(&self, request: &Request, target: &str) -> Response {
        let (path, query) = target.split_once('?').unwrap_or((target, ""));
        let is_number = |text: &&str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        let number = path.strip_prefix("/api/reach/").filter(is_number);
        // A number that does not fit into `usize` is not in the list either.
        let number = number.map(|number| number.parse().unwrap_or(usize::MAX));
        let command = path.strip_prefix(COMMAND).filter(|_| request.head.method == "POST");
        match (&self.content, number, command) {
            _ if path.is_empty() => Response::redirect(format!("{}/{target}", request.head.target.replace(target, ""))),
            _ if path == "/" => Response::new(200, "text/html; charset=utf-8", PAGE.as_bytes()),
            (Content::Stored(source, _), ..) if path == "/api/reaches" => Response::list(&source.reaches),
            (Content::Stored(source, kept), Some(number), _) => reach(source, kept, number),
            (Content::Running(running), ..) if path == "/api/reaches" => running.list(),
            (Content::Running(running), Some(number), _) => running.reach(number, query),
            (Content::Running(running), _, Some(command)) => running.command(command),
            (Content::Running(_), ..) if path == STATUS && request.head.method == "GET" => Response::text(200, ""),
            _ => Response::text(404, "no such page"),
        }
    }
}

/// A packed reach. Only one is packed at a time, so memory stays bounded however many are asked for.
fn reach(source: &Source, kept: &Mutex<Kept>, number: usize) -> Response {
    let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
    let place = kept.iter().position(|(other, _)| *other == number);
    let bytes = place.map_or_else(|| source.pack(number).map(Arc::new), |place| Ok(kept.remove(place).1));
    match bytes {
        Ok(bytes) => {
            kept.insert(0, (number, Arc::clone(&bytes)));
            kept.truncate(KEPT);
            Response::reach(bytes)
        }
        Err(error) => Response::text(if number < source.reaches.len() { 500 } else { 404 }, error.to_string()),
    }
}
