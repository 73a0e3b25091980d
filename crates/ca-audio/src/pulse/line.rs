//! The line to a PulseAudio server: its socket, and messages over it.
//!
//! Decides that messages are read and written here, with those of the crate `pulseaudio`, and that its client is left: it has
//! a thread of its own that no priority can be asked for, allocates a megabyte for each message, and says nothing of
//! underruns. Once sound flows, this reads into one buffer and allocates for nothing that comes more than once in a while.

use pulseaudio::protocol::{
    self, AuthParams, AuthReply, Command, CommandReply, CommandTag, Prop, Props, TagStructReader,
};
use std::env;
use std::io::{Cursor, Error, ErrorKind, Read as _, Result, Write as _};
use std::os::unix::net::UnixStream;
use std::path::PathBuf;
use std::time::Duration;

/// A message from the server is never longer \[bytes\].
const LONGEST: usize = 1 << 20;
/// Nor does it ever ask for more at once \[bytes\]; servers queue 4 MiB at most, and ask for as much again for each gap.
const LARGEST: u32 = 1 << 26;
/// What is read; other messages may have texts and tables of any length.
const HEARD: [CommandTag; 5] = [
    CommandTag::Error,
    CommandTag::Reply,
    CommandTag::Request,
    CommandTag::Underflow,
    CommandTag::PlaybackStreamKilled,
];
/// Length of a cookie \[bytes\]; who has none sends zeros, and is known by the socket.
const COOKIE: usize = 256;

/// An open line.
pub(super) struct Line {
    socket: UnixStream,
    version: u16,
    sequence: u32,
    /// the last message
    message: Vec<u8>,
    /// what the server has asked for and was not given \[bytes\]
    pub(super) owed: usize,
}

/// What came.
pub(super) enum News {
    /// an answer to the command of this number; what it says begins here in the message
    Answer(u32, usize),
    /// a command was refused, in words
    Refused(String),
    /// there was nothing to play
    Underflow,
    /// the stream has ended
    Killed,
    /// nothing of interest
    Other,
}

/// The socket of a server on this machine: as `PULSE_SERVER` says, or where one is by default.
fn socket() -> Option<PathBuf> {
    if let Ok(server) = env::var("PULSE_SERVER") {
        // `{machine}unix:/path other`; those of other machines are none of ours
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

impl Line {
    /// Opens a line to the server, which has this long for each of its answers.
    pub(super) fn open(patience: Duration) -> Result<Line> {
        let socket = UnixStream::connect(socket().ok_or(ErrorKind::NotFound)?)?;
        socket.set_read_timeout(Some(patience))?;
        socket.set_write_timeout(Some(patience))?;
        let version = protocol::MAX_VERSION;
        let mut line = Line { socket, version, sequence: 0, message: Vec::with_capacity(1 << 16), owed: 0 };
        let mut cookie = pulseaudio::cookie_path_from_env().and_then(|p| std::fs::read(p).ok()).unwrap_or_default();
        cookie.resize(COOKIE, 0);
        let auth = AuthParams { version, supports_shm: false, supports_memfd: false, cookie };
        let AuthReply { version: theirs, .. } = line.ask(&Command::Auth(auth))?;
        line.version = version.min(theirs);
        let mut props = Props::new();
        props.set(Prop::ApplicationName, c"ca");
        let _: protocol::SetClientNameReply = line.ask(&Command::SetClientName(props))?;
        Ok(line)
    }

    /// Waits for messages as long as it takes, from now on.
    pub(super) fn wait(&mut self) -> Result<()> {
        self.socket.set_read_timeout(None)?;
        self.socket.set_write_timeout(None)
    }

    /// A handle that can end the line from another thread.
    pub(super) fn end(&self) -> Result<UnixStream> {
        self.socket.try_clone()
    }

    /// A command as it goes over the line, and its number.
    pub(super) fn encoded(&mut self, command: &Command) -> Result<(u32, Vec<u8>)> {
        let mut bytes = Vec::new();
        self.sequence += 1;
        protocol::encode_command_message(&mut bytes, self.sequence, command, self.version).map_err(wrong)?;
        Ok((self.sequence, bytes))
    }

    /// Sends what is encoded.
    pub(super) fn send(&mut self, bytes: &[u8]) -> Result<()> {
        self.socket.write_all(bytes)
    }

    /// Asks, and waits for the answer.
    pub(super) fn ask<R: CommandReply>(&mut self, command: &Command) -> Result<R> {
        let at = self.order(command)?;
        self.answer(at)
    }

    /// Tells the server to do something, and waits until it has; where its answer begins.
    pub(super) fn order(&mut self, command: &Command) -> Result<usize> {
        let (number, bytes) = self.encoded(command)?;
        self.send(&bytes)?;
        loop {
            match self.next()? {
                News::Answer(n, at) if n == number => return Ok(at),
                News::Refused(why) => return Err(Error::other(why)),
                _ => {}
            }
        }
    }

    /// What the last message answers.
    pub(super) fn answer<R: CommandReply>(&self, at: usize) -> Result<R> {
        let mut rest = Cursor::new(self.message.get(at..).unwrap_or_default());
        TagStructReader::new(&mut rest, self.version).read().map_err(wrong)
    }

    /// Waits for the next message. What is asked for is added to what is owed.
    pub(super) fn next(&mut self) -> Result<News> {
        loop {
            let mut head = [0; protocol::DESCRIPTOR_SIZE];
            self.socket.read_exact(&mut head)?;
            let head = protocol::read_descriptor(&mut Cursor::new(head)).map_err(wrong)?;
            let length = head.length as usize;
            if length > LONGEST {
                return Err(wrong("a message that is too long"));
            }
            self.message.resize(length, 0);
            self.socket.read_exact(&mut self.message)?;
            // sound is for those that record
            if head.channel != u32::MAX {
                continue;
            }
            let tag = self.message.get(1..5).and_then(|b| Some(u32::from_be_bytes(b.try_into().ok()?)));
            if !HEARD.iter().any(|h| tag == Some(*h as u32)) {
                return Ok(News::Other);
            }
            let mut body = Cursor::new(&self.message[..]);
            let news = match Command::read_tag_prefixed(&mut body, self.version).map_err(wrong)? {
                (number, Command::Reply) => News::Answer(number, body.position() as usize),
                (_, Command::Request(r)) if r.length > LARGEST => return Err(wrong("it asks for too much at once")),
                (_, Command::Request(r)) => {
                    self.owed = self.owed.saturating_add(r.length as usize);
                    News::Other
                }
                (_, Command::Error(e)) => News::Refused(format!("{e:?}")),
                (_, Command::Underflow(_)) => News::Underflow,
                (_, Command::PlaybackStreamKilled(_)) => News::Killed,
                _ => News::Other,
            };
            return Ok(news);
        }
    }
}
