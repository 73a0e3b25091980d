//! Parses the head of a request and decides whether a client may connect.
//!
//! Any page in the same browser can send requests to this machine, so the address alone must not grant access:
//!
//! - The path must begin with the token of this run (128 random bits).
//! - `Host` must be this server, by its address or as `localhost`. This blocks DNS rebinding, where an attacker points
//!   another name at this machine.
//! - `Origin`, if present, must be this page. A socket requires it.
//! - Only `GET` without a body is accepted, with a head of at most [`HEAD`] bytes that arrives within [`PATIENCE`].
//!
//! `httparse` parses the head. A refusal carries a status only, without a reason that could help an attacker.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Longest head of a request \[bytes\].
const HEAD: usize = 8192;
const HEADERS: usize = 64;
/// Longest time from a connection to the end of its head.
const PATIENCE: Duration = Duration::from_secs(2);
/// Longest time in which a client accepts no data of an answer.
pub(crate) const STUCK: Duration = Duration::from_secs(5);

/// Content security policy: a page may load its own files and open a socket to its server.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; \
                      worker-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors ";
/// Pages that may show this one in a frame: none, or pages of this machine such as a notebook.
const FRAMES: [&str; 2] = ["'none'", "http://127.0.0.1:* http://localhost:*"];

#[derive(Debug, PartialEq)]
pub(crate) enum Head {
    /// File of the page, by name.
    File(String),
    /// Socket: key of the handshake, and bytes received after the head.
    Socket(String, Vec<u8>),
    /// Refusal, with its status.
    Refused(u16),
}

/// Address of this server.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub(crate) port: u16,
    pub(crate) token: String,
    /// True if pages of this machine may show the page in a frame.
    pub(crate) framed: bool,
}

impl Place {
    fn is_host(&self, host: &str) -> bool {
        // browsers omit the default port
        let (name, port) = host.split_once(':').unwrap_or((host, "80"));
        ["127.0.0.1", "localhost"].contains(&name) && port == self.port.to_string()
    }

    /// Checks a complete head; `rest` is received after it.
    fn judge(&self, head: &httparse::Request, rest: &[u8]) -> Head {
        // a duplicate header never comes from an honest client
        let one = |name: &str| {
            let mut all = head.headers.iter().filter(|h| h.name.eq_ignore_ascii_case(name));
            match (all.next(), all.next()) {
                (Some(h), None) => Ok(Some(std::str::from_utf8(h.value).map_err(|_| ())?)),
                (None, _) => Ok(None),
                _ => Err(()),
            }
        };
        let header = |name: &str| one(name).unwrap_or(Some("\0"));
        if head.method != Some("GET") {
            return Head::Refused(405);
        }
        if !header("host").is_some_and(|h| self.is_host(h)) {
            return Head::Refused(403);
        }
        let origin = header("origin");
        if !origin.is_none_or(|o| o.strip_prefix("http://").is_some_and(|h| self.is_host(h))) {
            return Head::Refused(403);
        }
        if header("content-length").is_some_and(|n| n != "0") || header("transfer-encoding").is_some() {
            return Head::Refused(400);
        }
        let path = head.path.unwrap_or_default().split('?').next().unwrap_or_default();
        let inside = path.strip_prefix('/').and_then(|p| p.strip_prefix(self.token.as_str())?.strip_prefix('/'));
        let Some(name) = inside else { return Head::Refused(404) };
        if name != "ws" {
            return Head::File(name.into());
        }
        let upgrade = header("upgrade").is_some_and(|u| u.eq_ignore_ascii_case("websocket"));
        let version = header("sec-websocket-version") == Some("13");
        match header("sec-websocket-key") {
            Some(key) if upgrade && version && key.len() == 24 && origin.is_some() => {
                Head::Socket(key.into(), rest.to_vec())
            }
            _ => Head::Refused(400),
        }
    }

    /// Reads the head of a request. Returns `None` if no complete head arrives in time.
    pub(crate) fn read(&self, stream: &mut TcpStream) -> Option<Head> {
        let end = Instant::now() + PATIENCE;
        let mut all = Vec::new();
        let mut block = [0; 2048];
        loop {
            let left = end.checked_duration_since(Instant::now()).filter(|d| !d.is_zero())?;
            stream.set_read_timeout(Some(left)).ok()?;
            let n = stream.read(&mut block).ok().filter(|n| *n > 0)?;
            all.extend_from_slice(&block[..n]);
            let mut headers = [httparse::EMPTY_HEADER; HEADERS];
            let mut head = httparse::Request::new(&mut headers);
            match head.parse(&all) {
                Ok(httparse::Status::Complete(length)) => return Some(self.judge(&head, &all[length..])),
                Ok(httparse::Status::Partial) if all.len() < HEAD => {}
                Ok(httparse::Status::Partial) => return Some(Head::Refused(431)),
                Err(_) => return Some(Head::Refused(400)),
            }
        }
    }
}

/// Sends the bytes of a file of a kind (its media type).
pub(crate) fn send(stream: &mut TcpStream, (kind, bytes): (&str, &[u8]), framed: bool) -> std::io::Result<()> {
    let frames = FRAMES[usize::from(framed)];
    let head = format!(
        "HTTP/1.1 200 OK\r\nContent-Type: {}\r\nContent-Length: {}\r\nContent-Security-Policy: {POLICY}{frames}\r\n\
         X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
         Cache-Control: no-store\r\nConnection: close\r\n\r\n",
        kind,
        bytes.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(bytes)
}

pub(crate) fn refuse(stream: &mut TcpStream, status: u16) -> std::io::Result<()> {
    let text = format!("HTTP/1.1 {status} Refused\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
    stream.write_all(text.as_bytes())
}

pub(crate) fn agree(stream: &mut TcpStream, key: &str) -> std::io::Result<()> {
    let accept = tungstenite::handshake::derive_accept_key(key.as_bytes());
    let text = format!(
        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
         Sec-WebSocket-Accept: {accept}\r\n\r\n"
    );
    stream.write_all(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(text: &str) -> Head {
        let place = Place { port: 4000, token: "secret".into(), framed: false };
        let mut headers = [httparse::EMPTY_HEADER; HEADERS];
        let mut head = httparse::Request::new(&mut headers);
        let text = text.replace('\n', "\r\n");
        let httparse::Status::Complete(n) = head.parse(text.as_bytes()).unwrap() else { panic!("{text}") };
        place.judge(&head, &text.as_bytes()[n..])
    }

    #[test]
    fn only_the_page_of_this_run_is_let_in() {
        let file = |name: &str| Head::File(name.into());
        for (text, want) in [
            ("GET /secret/ HTTP/1.1\nHost: 127.0.0.1:4000\n\n", file("")),
            ("GET /secret/main.js?x HTTP/1.1\nHost: localhost:4000\n\n", file("main.js")),
            ("GET /secret/ HTTP/1.1\nHost: localhost:4000\nOrigin: http://localhost:4000\n\n", file("")),
            ("GET / HTTP/1.1\nHost: localhost:4000\n\n", Head::Refused(404)),
            ("GET /secre/ HTTP/1.1\nHost: localhost:4000\n\n", Head::Refused(404)),
            ("GET /secretly/ HTTP/1.1\nHost: localhost:4000\n\n", Head::Refused(404)),
            ("GET /secret HTTP/1.1\nHost: localhost:4000\n\n", Head::Refused(404)),
            ("GET http://localhost:4000/secret/ HTTP/1.1\nHost: localhost:4000\n\n", Head::Refused(404)),
            ("GET /secret/ HTTP/1.1\nHost: evil.example:4000\n\n", Head::Refused(403)),
            ("GET /secret/ HTTP/1.1\nHost: localhost\n\n", Head::Refused(403)),
            ("GET /secret/ HTTP/1.1\nHost: localhost:04000\n\n", Head::Refused(403)),
            ("GET /secret/ HTTP/1.1\n\n", Head::Refused(403)),
            ("GET /secret/ HTTP/1.1\nHost: localhost:4000\nHost: localhost:4000\n\n", Head::Refused(403)),
            ("GET /secret/ HTTP/1.1\nHost: localhost:4000\nOrigin: http://evil.example\n\n", Head::Refused(403)),
            ("GET /secret/ HTTP/1.1\nHost: localhost:4000\nOrigin: null\n\n", Head::Refused(403)),
            ("POST /secret/ HTTP/1.1\nHost: localhost:4000\n\n", Head::Refused(405)),
            ("GET /secret/ HTTP/1.1\nHost: localhost:4000\nContent-Length: 5\n\n", Head::Refused(400)),
        ] {
            assert_eq!(judged(text), want, "{text}");
        }
    }

    #[test]
    fn a_socket_says_where_it_comes_from() {
        let head = "GET /secret/ws HTTP/1.1\nHost: localhost:4000\nUpgrade: websocket\nConnection: Upgrade\n\
                    Sec-WebSocket-Version: 13\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\n";
        let key = "dGhlIHNhbXBsZSBub25jZQ==".to_string();
        assert_eq!(judged(&format!("{head}Origin: http://localhost:4000\n\nmore")), Head::Socket(key, b"more".into()));
        assert_eq!(judged(&format!("{head}\n")), Head::Refused(400), "no origin");
        assert_eq!(judged(&format!("{head}Origin: https://localhost:4000\n\n")), Head::Refused(403), "another scheme");
        let old = head.replace("13", "8");
        assert_eq!(judged(&format!("{old}Origin: http://localhost:4000\n\n")), Head::Refused(400), "another version");
    }
}
