//! One page that is open.
//!
//! Decides that no client stands in the way of the engine, or of another client: each has a thread, and what waits for it
//! is bounded. Of pictures only the newest waits, of sound a quarter of a second; a client that does not fetch its news
//! either, or asks faster than any hand moves, is closed, with the reason as the code of the close frame.

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
/// Messages of a client a second at most; a hand that drags sends 120.
const MOST: f64 = 1000.0;
/// Bytes of a client a second at most, whatever they are: frames without a word in them are no messages.
const BYTES: f64 = (1 << 20) as f64;
/// News that wait for a client at most.
const NEWS: usize = 1024;
/// Blocks of sound that wait for a client at most, of 5 ms.
const BLOCKS: usize = 50;
/// Between two looks at what waits.
const LOOK: Duration = Duration::from_millis(2);
/// Between two pings, and how long a client that answers none may hold what it holds.
const PING: Duration = Duration::from_secs(1);
const ANSWERS: Duration = Duration::from_secs(6);
/// Longest time in which a client takes nothing.
const STUCK: Duration = Duration::from_secs(5);

/// What is asked for a client that is there and answers nothing.
const RELEASE: &str = r#"{"type":"release"}"#;

/// What waits for a client.
#[derive(Default)]
struct Waiting {
    news: VecDeque<Utf8Bytes>,
    view: Option<Bytes>,
    sound: VecDeque<Bytes>,
    /// why it is to be closed
    close: Option<CloseCode>,
}

/// A client as its server sees it.
pub(crate) struct Client {
    pub(crate) number: u64,
    /// it wants sound
    pub(crate) hears: AtomicBool,
    waiting: Mutex<Waiting>,
}

impl Client {
    pub(crate) fn new(number: u64) -> Client {
        Client { number, hears: AtomicBool::new(false), waiting: Mutex::default() }
    }

    fn waiting(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn tell(&self, text: Utf8Bytes) {
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
        if self.hears.load(Relaxed) {
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

    /// Moves messages between the socket and the queues until one side ends; `asked` takes what came.
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
        let stream = Paced { stream, budget: Budget::new(BYTES) };
        let mut socket = WebSocket::from_partially_read(stream, rest, Role::Server, Some(config));
        let code = self.talk(&mut socket, asked);
        let reason = CloseFrame { code, reason: Utf8Bytes::default() };
        let _ = socket.close(Some(reason)).and_then(|()| socket.flush());
    }

    /// Until there is a reason to close.
    fn talk(&self, socket: &mut WebSocket<Paced>, asked: &mut impl FnMut(&str)) -> CloseCode {
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
                // answers to a ping are written by the library
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

/// How much of something a client may send now: as much as in a second, at once.
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

/// The line of a client, which is cut where more comes than [`BYTES`].
struct Paced {
    stream: TcpStream,
    budget: Budget,
}

impl Read for Paced {
    fn read(&mut self, to: &mut [u8]) -> std::io::Result<usize> {
        let n = self.stream.read(to)?;
        if self.budget.spend(n as f64) { Ok(n) } else { Err(ErrorKind::QuotaExceeded.into()) }
    }
}

impl Write for Paced {
    fn write(&mut self, from: &[u8]) -> std::io::Result<usize> {
        self.stream.write(from)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.stream.flush()
    }
}
