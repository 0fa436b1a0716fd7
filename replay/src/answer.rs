//! What the server sends back.

use std::io::Cursor;
use std::sync::Arc;

use tiny_http::{Header, Request, Response};

use crate::Summary;

/// The page may run its own script and ask this server for reaches, and nothing else.
const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; connect-src 'self'; \
                      img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// An answer's status, content type and content.
pub struct Answer {
    /// The status.
    pub status: u16,
    kind: &'static str,
    bytes: Arc<Vec<u8>>,
}

impl Answer {
    /// An answer with this content.
    pub fn new(status: u16, kind: &'static str, bytes: impl Into<Vec<u8>>) -> Self {
        Answer {
            status,
            kind,
            bytes: Arc::new(bytes.into()),
        }
    }

    /// An answer with a sentence as plain text.
    pub fn text(status: u16, text: impl Into<String>) -> Self {
        Answer::new(status, "text/plain; charset=utf-8", text.into())
    }

    /// A packed reach.
    pub fn reach(bytes: Arc<Vec<u8>>) -> Self {
        Answer {
            status: 200,
            kind: "application/octet-stream",
            bytes,
        }
    }

    /// The list of reaches.
    pub fn list(reaches: &[Summary]) -> Self {
        // Plain data can always be written.
        Answer::new(200, "application/json", serde_json::to_vec(reaches).unwrap_or_default())
    }
}

/// Bytes that several answers share.
struct SharedBytes(Arc<Vec<u8>>);

impl AsRef<[u8]> for SharedBytes {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

impl Answer {
    /// Sends the answer.
    pub fn send(self, request: Request) {
        let headers = [
            ("Content-Type", self.kind),
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
        let length = self.bytes.len();
        let body = Cursor::new(SharedBytes(self.bytes));
        let response = Response::new(self.status.into(), headers.collect(), body, Some(length), None);
        // The other side may have left.
        let _ = request.respond(response.with_chunked_threshold(usize::MAX));
    }
}
