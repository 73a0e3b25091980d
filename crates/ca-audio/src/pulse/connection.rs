//! Connection to a PulseAudio server: its socket and its messages.
//!
//! This module encodes messages with the crate `pulseaudio`, but does not use its client. The client has its own
//! thread, whose priority cannot be set, allocates a megabyte for each message, and does not report underruns. Once
//! sound flows, this module reads into one buffer and allocates only for rare messages.

use pulseaudio::protocol::{
    self, AuthParams, AuthReply, Command, CommandReply, CommandTag, Prop, Props, TagStructReader,
};
use std::env;
use std::io::{Cursor, Error, ErrorKind, Read as _, Result, Write as _};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::time::Duration;

/// Longest message from the server \[bytes\].
const LONGEST: usize = 1 << 20;
/// Largest request \[bytes\]; servers queue at most 4 MiB, and request as much again for each gap.
const LARGEST: u32 = 1 << 26;
/// Messages that are parsed; others may have texts and tables of any length.
const HEARD: [CommandTag; 5] = [
    CommandTag::Error,
    CommandTag::Reply,
    CommandTag::Request,
    CommandTag::Underflow,
    CommandTag::PlaybackStreamKilled,
];
/// Length of a cookie \[bytes\]; without one, zeros are sent and the socket identifies the user.
const COOKIE: usize = 256;

pub(super) struct Connection {
    socket: UnixStream,
    version: u16,
    sequence: u32,
    message: Vec<u8>,
    /// Requested but not yet sent \[bytes\].
    pub(super) pending_bytes: usize,
}

pub(super) enum ServerMessage {
    /// Answer to the command of this number; its content begins at this offset in the message.
    Answer(u32, usize),
    /// Reason why a command was refused.
    Refused(String),
    /// The queue was empty.
    Underflow,
    /// The stream has ended.
    Killed,
    /// Any other message.
    Other,
}

/// Returns the socket of a server on this machine, from `PULSE_SERVER` or at its default place.
fn socket() -> Option<PathBuf> {
    if let Ok(server) = env::var("PULSE_SERVER") {
        // `{machine}unix:/path other`: only the first server, and only a socket on this machine
        let first = server.split_whitespace().next()?;
        let path = first.rsplit('}').next()?;
        return path.strip_prefix("unix:").or_else(|| path.starts_with('/').then_some(path)).map(PathBuf::from);
    }
    let runtime = env::var_os("PULSE_RUNTIME_PATH").map(|d| PathBuf::from(d).join("native"));
    runtime.or_else(|| env::var_os("XDG_RUNTIME_DIR").map(|d| PathBuf::from(d).join("pulse/native")))
}

pub(super) fn wrong(what: impl std::fmt::Display) -> Error {
    Error::new(ErrorKind::InvalidData, format!("{what}"))
}

impl Connection {
    /// Connects to the server, with this time limit for each answer.
    pub(super) fn open(patience: Duration) -> Result<Connection> {
        let socket = UnixStream::connect(socket().ok_or(ErrorKind::NotFound)?)?;
        socket.set_read_timeout(Some(patience))?;
        socket.set_write_timeout(Some(patience))?;
        let version = protocol::MAX_VERSION;
        let mut line =
            Connection { socket, version, sequence: 0, message: Vec::with_capacity(1 << 16), pending_bytes: 0 };
        let mut cookie = pulseaudio::cookie_path_from_env().and_then(|p| std::fs::read(p).ok()).unwrap_or_default();
        cookie.resize(COOKIE, 0);
        let auth = AuthParams { version, supports_shm: false, supports_memfd: false, cookie };
        let AuthReply { version: theirs, .. } = line.request(&Command::Auth(auth))?;
        line.version = version.min(theirs);
        let mut props = Props::new();
        props.set(Prop::ApplicationName, c"ca");
        let _: protocol::SetClientNameReply = line.request(&Command::SetClientName(props))?;
        Ok(line)
    }

    /// Removes the time limit.
    pub(super) fn wait(&mut self) -> Result<()> {
        self.socket.set_read_timeout(None)?;
        self.socket.set_write_timeout(None)
    }

    /// Returns a handle that can end the connection from another thread.
    pub(super) fn end(&self) -> Result<UnixStream> {
        self.socket.try_clone()
    }

    /// Encodes a command and returns its number too.
    pub(super) fn encoded(&mut self, command: &Command) -> Result<(u32, Vec<u8>)> {
        let mut bytes = Vec::new();
        self.sequence += 1;
        protocol::encode_command_message(&mut bytes, self.sequence, command, self.version).map_err(wrong)?;
        Ok((self.sequence, bytes))
    }

    pub(super) fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.socket.write_all(bytes)
    }

    pub(super) fn request<R: CommandReply>(&mut self, command: &Command) -> Result<R> {
        let at = self.order(command)?;
        self.answer(at)
    }

    /// Sends a command, waits until it is done, and returns the offset of its answer.
    pub(super) fn order(&mut self, command: &Command) -> Result<usize> {
        let (number, bytes) = self.encoded(command)?;
        self.send(&bytes)?;
        loop {
            match self.next()? {
                ServerMessage::Answer(n, at) if n == number => return Ok(at),
                ServerMessage::Refused(why) => return Err(Error::other(why)),
                _ => {}
            }
        }
    }

    /// Decodes the answer at this offset in the last message.
    pub(super) fn answer<R: CommandReply>(&self, at: usize) -> Result<R> {
        let mut rest = Cursor::new(self.message.get(at..).unwrap_or_default());
        TagStructReader::new(&mut rest, self.version).read().map_err(wrong)
    }

    /// Waits for the next message. A request is added to [`Connection::pending_bytes`].
    pub(super) fn next(&mut self) -> Result<ServerMessage> {
        loop {
            let mut head = [0; protocol::DESCRIPTOR_SIZE];
            self.socket.read_exact(&mut head)?;
            let head = protocol::read_descriptor(&mut Cursor::new(head)).map_err(wrong)?;
            let length = head.length as usize;
            if length > LONGEST {
                return Err(wrong("it sent a message that is too long"));
            }
            self.message.resize(length, 0);
            self.socket.read_exact(&mut self.message)?;
            // a message of samples is only for recording
            if head.channel != u32::MAX {
                continue;
            }
            let tag = self.message.get(1..5).and_then(|b| Some(u32::from_be_bytes(b.try_into().ok()?)));
            if !HEARD.iter().any(|h| tag == Some(*h as u32)) {
                return Ok(ServerMessage::Other);
            }
            let mut body = Cursor::new(&self.message[..]);
            let news = match Command::read_tag_prefixed(&mut body, self.version).map_err(wrong)? {
                (number, Command::Reply) => ServerMessage::Answer(number, body.position() as usize),
                (_, Command::Request(r)) if r.length > LARGEST => {
                    return Err(wrong("it requested too many samples at once"));
                }
                (_, Command::Request(r)) => {
                    self.pending_bytes = self.pending_bytes.saturating_add(r.length as usize);
                    ServerMessage::Other
                }
                (_, Command::Error(e)) => ServerMessage::Refused(format!("{e:?}")),
                (_, Command::Underflow(_)) => ServerMessage::Underflow,
                (_, Command::PlaybackStreamKilled(_)) => ServerMessage::Killed,
                _ => ServerMessage::Other,
            };
            return Ok(news);
        }
    }
}
