//! Control of a running server: parameters, arming, status.
//!
//! Requests and replies are JSON texts, one line each, over a stream socket in the folder of the site. A new socket can
//! be opened by other users until its mode is changed, so it is in a folder of mode 0700. Only processes of the same user
//! can reach it, as with the shared memory of devices. It does not use `/dev/shm`, so forces can be disarmed whatever other users put there. A
//! lock allows one server for each site, and the kernel releases it when the server is killed. All values of one
//! request take effect in one tick.

use super::error::{HostError, HostErrorKind};
use super::site::Site;
pub use crate::control::{Given, Reply, Request};
use crate::frame::VERSION;
use std::fs::{self, File, OpenOptions, Permissions, TryLockError};
use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::fs::{DirBuilderExt, FileExt, OpenOptionsExt, PermissionsExt};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::thread::sleep;
use std::time::{Duration, Instant};

const CALLERS: usize = 8;
/// Longest request \[bytes\].
const LONGEST: usize = 16 << 20;
/// Time limit of a caller to send its request, and to read the reply.
const CALL: Duration = Duration::from_secs(2);

fn folder(site: &Site) -> PathBuf {
    site.root().join("control")
}

fn socket(site: &Site) -> PathBuf {
    folder(site).join(format!("v{VERSION}"))
}

/// Time limit of the last callers to read their replies when the server ends.
const READ: Duration = Duration::from_secs(1);

/// The server side of the control socket.
pub struct ControlServer {
    listener: UnixListener,
    calls: Vec<Call>,
    socket: PathBuf,
    _lock: File,
}

impl ControlServer {
    /// Opens the socket. A socket left by a killed server is replaced.
    ///
    /// # Errors
    /// If another server runs at this site, or the folder cannot be written.
    pub fn open(site: &Site) -> Result<ControlServer, HostError> {
        super::stale_shm::strangers(site)?;
        let failed = |e: io::Error| HostError::system(format!("cannot listen at `{}`", socket(site).display()), e);
        let lock = match locked(site).map_err(failed)? {
            Ok(lock) => lock,
            Err(holder) => {
                let what = format!("a server is already running at `{}`: {holder}", site.root().display());
                return Err(HostError::new(HostErrorKind::Busy, what, "stop it, or set CA_SHM_ROOT to another folder"));
            }
        };
        let socket = socket(site);
        let listen = || {
            match fs::remove_file(&socket) {
                Err(e) if e.kind() != ErrorKind::NotFound => return Err(e),
                _ => {}
            }
            let listener = UnixListener::bind(&socket)?;
            listener.set_nonblocking(true)?;
            Ok(listener)
        };
        Ok(ControlServer {
            listener: listen().map_err(failed)?,
            calls: Vec::new(),
            socket: socket.clone(),
            _lock: lock,
        })
    }

    /// Answers waiting requests with `answer`, without blocking. A request that cannot be parsed is refused here.
    pub fn poll(&mut self, answer: &mut dyn FnMut(Request) -> Reply) {
        while self.calls.len() < CALLERS {
            let Ok((stream, _)) = self.listener.accept() else { break };
            if stream.set_nonblocking(true).is_ok() {
                self.calls.push(Call { stream, asked: Vec::new(), answer: None, since: Instant::now() });
            }
        }
        self.calls.retain_mut(|call| call.poll(answer));
    }
}

impl Drop for ControlServer {
    /// Waits until the last replies are read: one of them may be the reply to [`Request::Stop`].
    fn drop(&mut self) {
        let end = Instant::now() + READ;
        self.calls.retain(|call| call.answer.is_some());
        while !self.calls.is_empty() && Instant::now() < end {
            self.calls.retain_mut(|call| call.poll(&mut |_| Reply::refused("the server is stopping")));
            sleep(Duration::from_millis(1));
        }
        // the lock is still held, so this is the socket of this server
        let _ = fs::remove_file(&self.socket);
    }
}

/// Returns the lock of the site, or the process that has it.
fn locked(site: &Site) -> io::Result<Result<File, String>> {
    let folder = folder(site);
    match fs::DirBuilder::new().mode(0o700).create(&folder) {
        Err(e) if e.kind() == ErrorKind::AlreadyExists => fs::set_permissions(&folder, Permissions::from_mode(0o700))?,
        made => made?,
    }
    let path = folder.join("lock");
    let mut options = OpenOptions::new();
    let lock = options.read(true).write(true).create(true).truncate(false).mode(0o600).open(path)?;
    match lock.try_lock() {
        Ok(()) => {
            let name = fs::read_to_string("/proc/self/comm").unwrap_or_default();
            lock.set_len(0)?;
            lock.write_all_at(format!("process {} (`{}`)", std::process::id(), name.trim()).as_bytes(), 0)?;
            Ok(Ok(lock))
        }
        Err(TryLockError::WouldBlock) => {
            let mut who = String::new();
            (&lock).take(200).read_to_string(&mut who)?;
            Ok(Err(if who.is_empty() { "another process".into() } else { who }))
        }
        Err(TryLockError::Error(e)) => Err(e),
    }
}

struct Call {
    stream: UnixStream,
    asked: Vec<u8>,
    /// Rest of the reply.
    answer: Option<Vec<u8>>,
    /// Start of the current time limit: connection, then reply.
    since: Instant,
}

impl Call {
    /// Continues as far as possible without blocking. Returns false at the end of the call.
    fn poll(&mut self, answer: &mut dyn FnMut(Request) -> Reply) -> bool {
        if self.answer.is_none() {
            let Ok(there) = self.read_request() else { return false };
            if let Some(length) = there {
                let reply = match serde_json::from_slice(&self.asked[..length]) {
                    Ok(request) => answer(request),
                    Err(e) => Reply::refused(format!("invalid request: {e}")),
                };
                let mut text = serde_json::to_vec(&reply).unwrap_or_default();
                text.push(b'\n');
                (self.answer, self.since) = (Some(text), Instant::now());
            }
        }
        let Some(text) = &mut self.answer else { return self.since.elapsed() < CALL };
        while !text.is_empty() {
            match self.stream.write(text) {
                Ok(0) => return false,
                Ok(n) => drop(text.drain(..n)),
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) => return e.kind() == ErrorKind::WouldBlock && self.since.elapsed() < CALL,
            }
        }
        false
    }

    /// Reads available bytes. Returns the length of the request once it is complete.
    fn read_request(&mut self) -> io::Result<Option<usize>> {
        let mut block = [0; 4096];
        loop {
            match self.stream.read(&mut block) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(n) => {
                    let before = self.asked.len();
                    self.asked.extend_from_slice(&block[..n]);
                    if let Some(end) = block[..n].iter().position(|b| *b == b'\n') {
                        return Ok(Some(before + end));
                    }
                    if self.asked.len() > LONGEST {
                        return Err(ErrorKind::FileTooLarge.into());
                    }
                }
                Err(e) if e.kind() == ErrorKind::WouldBlock => return Ok(None),
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) => return Err(e),
            }
        }
    }
}

/// Sends a request to the server of this site and returns its reply.
///
/// # Errors
/// If no server answers within `patience`.
pub fn ask(site: &Site, request: &Request, patience: Duration) -> Result<Reply, HostError> {
    let mut text = serde_json::to_vec(request).map_err(|e| HostError::system("a request cannot be written", e))?;
    text.push(b'\n');
    let answer = exchange(site, &text, patience).map_err(|e| match e.kind() {
        ErrorKind::NotFound
        | ErrorKind::ConnectionRefused
        | ErrorKind::ConnectionReset
        | ErrorKind::BrokenPipe
        | ErrorKind::UnexpectedEof => super::stale_shm::strangers(site).err().unwrap_or_else(|| {
            let what = format!("no server is running at `{}`", site.root().display());
            HostError::new(HostErrorKind::Absent, what, "start one: `ca serve MODEL`")
        }),
        ErrorKind::WouldBlock | ErrorKind::TimedOut => {
            let what = format!("the server at `{}` does not answer within {patience:?}", site.root().display());
            HostError::new(HostErrorKind::Absent, what, "check if it is suspended, or start it again")
        }
        _ => HostError::system(format!("cannot send a request to `{}`", socket(site).display()), e),
    })?;
    serde_json::from_slice(&answer).map_err(|e| {
        let what = format!("the server at `{}` sent an invalid reply: {e}", site.root().display());
        HostError::new(HostErrorKind::Answer, what, "use the same release of ca for both processes")
    })
}

fn exchange(site: &Site, text: &[u8], patience: Duration) -> io::Result<Vec<u8>> {
    let begin = Instant::now();
    // the system refuses a timeout of zero
    let left = || patience.checked_sub(begin.elapsed()).filter(|d| !d.is_zero()).ok_or(ErrorKind::TimedOut);
    let mut stream = UnixStream::connect(socket(site))?;
    stream.set_write_timeout(Some(left()?))?;
    stream.write_all(text)?;
    let (mut answer, mut block) = (Vec::new(), [0; 4096]);
    while answer.last() != Some(&b'\n') {
        stream.set_read_timeout(Some(left()?))?;
        match stream.read(&mut block) {
            Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
            Ok(n) => answer.extend_from_slice(&block[..n]),
            Err(e) if e.kind() == ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
    Ok(answer)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_what_a_person_would_write() {
        let set = r#"{"do":"set","values":{"a.k":8000.0,"a.z":"0.5 N s/m"}}"#;
        let request: Request = serde_json::from_str(set).unwrap();
        let Request::Set { values } = &request else { panic!("{request:?}") };
        assert_eq!(values["a.k"], Given::Number(8000.0));
        assert_eq!(values["a.z"], Given::Text("0.5 N s/m".into()));
        assert_eq!(serde_json::to_string(&request).unwrap(), set);
        assert_eq!(serde_json::from_str::<Request>(r#"{"do":"arm"}"#).unwrap(), Request::Arm { device: None });
        for bad in [r#"{"do":"fly"}"#, r#"{"do":"arm","devices":"x"}"#, "", "[]", r#"{"do":"set","values":{"a":[1]}}"#]
        {
            assert!(serde_json::from_str::<Request>(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn a_server_that_answers_and_ends_is_heard() {
        let dir = tempfile::Builder::new().prefix("cac").tempdir_in("/tmp").expect("a folder");
        let site = Site::at(dir.path()).expect("a place");
        for _ in 0..20 {
            let mut server = ControlServer::open(&site).expect("a control");
            let here = site.clone();
            let asking = std::thread::spawn(move || ask(&here, &Request::Stop, Duration::from_secs(30)));
            let mut leave = false;
            while !leave && !asking.is_finished() {
                server.poll(&mut |_| {
                    leave = true;
                    Reply::done("ends")
                });
            }
            drop(server);
            assert_eq!(asking.join().expect("no panic").map_err(|e| e.to_string()), Ok(Reply::done("ends")));
        }
    }
}
