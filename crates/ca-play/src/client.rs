//! Connection to one open page.
//!
//! A slow client must not delay the engine or another client. So each client has a thread and bounded queues: only the
//! newest picture and a quarter of a second of sound are kept. A client that does not read its messages, or sends more
//! than any hand could cause, is closed. The code of the close frame gives the reason.

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::protocol::{CloseFrame, Role, WebSocketConfig};
use tungstenite::{Bytes, Error, Message, Utf8Bytes, WebSocket};

/// Longest message of a client \[bytes\].
const LONGEST: usize = 1 << 16;
/// Limit on messages from a client per second; dragging sends 480.
const MOST: f64 = 1000.0;
/// Limit on bytes from a client per second. It also covers empty frames, which do not count as messages.
const BYTES: f64 = (1 << 20) as f64;
/// Limit on text messages queued for a client.
const NEWS: usize = 1024;
/// Limit on queued blocks of sound, of 5 ms each.
const BLOCKS: usize = 50;
/// Period of polling the socket and the queues.
const LOOK: Duration = Duration::from_millis(2);
/// Time between pings, and time without an answer after which a client loses what it holds.
const PING: Duration = Duration::from_secs(1);
const ANSWERS: Duration = Duration::from_secs(6);
/// Longest time in which a client accepts no data.
const STUCK: Duration = Duration::from_secs(5);

/// Request made on behalf of a client that stays connected but does not answer.
const RELEASE: &str = r#"{"type":"release"}"#;

#[derive(Default)]
struct Outbox {
    news: VecDeque<Utf8Bytes>,
    view: Option<Bytes>,
    sound: VecDeque<Bytes>,
    /// Reason for closing, if the client is to be closed.
    close: Option<CloseCode>,
}

/// A client, from the side of the server.
pub(crate) struct Client {
    pub(crate) number: u64,
    /// True if the client wants sound.
    pub(crate) wants_sound: AtomicBool,
    waiting: Mutex<Outbox>,
}

impl Client {
    pub(crate) fn new(number: u64) -> Client {
        Client { number, wants_sound: AtomicBool::new(false), waiting: Mutex::default() }
    }

    fn waiting(&self) -> MutexGuard<'_, Outbox> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn send(&self, text: Utf8Bytes) {
        let mut waiting = self.waiting();
        if waiting.news.len() < NEWS {
            waiting.news.push_back(text);
        } else {
            waiting.close = Some(CloseCode::Policy);
        }
    }

    pub(crate) fn view(&self, picture: Bytes) {
        self.waiting().view = Some(picture);
    }

    pub(crate) fn sound(&self, block: Bytes) {
        if self.wants_sound.load(Relaxed) {
            let mut waiting = self.waiting();
            if waiting.sound.len() >= BLOCKS {
                waiting.sound.pop_front();
            }
            waiting.sound.push_back(block);
        }
    }

    pub(crate) fn close(&self, code: CloseCode) {
        self.waiting().close = Some(code);
    }

    /// Transfers messages between the socket and the queues until one side ends. `asked` receives the requests.
    pub(crate) fn run(&self, stream: TcpStream, rest: Vec<u8>, asked: &mut impl FnMut(&str)) {
        let waits = stream.set_nodelay(true).and(stream.set_read_timeout(Some(LOOK)));
        if waits.and(stream.set_write_timeout(Some(STUCK))).is_err() {
            return;
        }
        let config = WebSocketConfig::default()
            .max_message_size(Some(LONGEST))
            .max_frame_size(Some(LONGEST))
            .read_buffer_size(4096)
            .write_buffer_size(0);
        let stream = RateLimited { stream, budget: Budget::new(BYTES) };
        let mut socket = WebSocket::from_partially_read(stream, rest, Role::Server, Some(config));
        let code = self.talk(&mut socket, asked);
        let reason = CloseFrame { code, reason: Utf8Bytes::default() };
        let _ = socket.close(Some(reason)).and_then(|()| socket.flush());
    }

    /// Transfers messages until there is a reason to close, and returns it.
    fn talk(&self, socket: &mut WebSocket<RateLimited>, asked: &mut impl FnMut(&str)) -> CloseCode {
        let mut budget = Budget::new(MOST);
        let (mut heard, mut pinged, mut held) = (Instant::now(), Instant::now(), true);
        loop {
            let read = socket.read();
            let now = Instant::now();
            if read.is_ok() {
                (heard, held) = (now, true);
            } else if held && now > heard + ANSWERS {
                held = false;
                asked(RELEASE);
            }
            match read {
                Ok(Message::Text(text)) => {
                    if !budget.spend(1.0) {
                        return CloseCode::Policy;
                    }
                    asked(&text);
                }
                Ok(Message::Binary(_)) => return CloseCode::Unsupported,
                // the library answers pings
                Ok(Message::Ping(_) | Message::Pong(_) | Message::Frame(_)) => {
                    if !budget.spend(1.0) {
                        return CloseCode::Policy;
                    }
                }
                Ok(Message::Close(_)) => return CloseCode::Normal,
                Err(Error::Io(e)) if matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                Err(Error::Io(e)) if e.kind() == ErrorKind::QuotaExceeded => return CloseCode::Policy,
                Err(Error::Capacity(_)) => return CloseCode::Size,
                Err(_) => return CloseCode::Protocol,
            }
            if now > pinged + PING {
                pinged = now;
                if socket.send(Message::Ping(Bytes::new())).is_err() {
                    return CloseCode::Protocol;
                }
            }
            let waiting = std::mem::take(&mut *self.waiting());
            let news = waiting.news.into_iter().map(Message::Text);
            let bytes = waiting.sound.into_iter().chain(waiting.view).map(Message::Binary);
            for message in news.chain(bytes) {
                if socket.send(message).is_err() {
                    return CloseCode::Protocol;
                }
            }
            if let Some(code) = waiting.close {
                return code;
            }
        }
    }
}

/// Rate limit of a client, with a burst of up to one second's worth.
struct Budget {
    most: f64,
    left: f64,
    at: Instant,
}

impl Budget {
    fn new(most: f64) -> Budget {
        Budget { most, left: most, at: Instant::now() }
    }

    fn spend(&mut self, n: f64) -> bool {
        let now = Instant::now();
        self.left = (self.left + self.most * now.duration_since(self.at).as_secs_f64()).min(self.most) - n;
        self.at = now;
        self.left >= 0.0
    }
}

/// Stream of a client that fails if more than [`BYTES`] arrive per second.
struct RateLimited {
    stream: TcpStream,
    budget: Budget,
}

impl Read for RateLimited {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        let n = self.stream.read(to)?;
        if self.budget.spend(n as f64) { Ok(n) } else { Err(ErrorKind::QuotaExceeded.into()) }
    }
}

impl Write for RateLimited {
    fn write(&mut self, from: &[u8]) -> std::io::Result<usize> {
        self.stream.write(from)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.stream.flush()
    }
}
