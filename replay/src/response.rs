//! What the server sends back.

use std::io::{self, Write};
use std::sync::Arc;

use crate::Summary;
use crate::page::policy;

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
