//! Server of a page.
//!
//! It listens only on the loopback interface. A connection occupies a slot only after it has sent the token.
//! Connections with the token have at most [`MOST`] slots; connections of other users get none. Requests are queued in
//! order, up to a limit. A page that exceeds the limit gets an immediate refusal.

use crate::asset;
use crate::client::Client;
use crate::http::{self, Head, Place};
use crate::offers::Offers;
use crate::pending::Pending;
use ca_session::Pages;
use ca_session::protocol::{Message, NumberedRequest, Request};
use serde_json::Value;
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering::Relaxed};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};
use tungstenite::protocol::frame::coding::CloseCode;
use tungstenite::{Bytes, Utf8Bytes};

/// Limit on connections with the token.
const MOST: usize = 32;
/// Limit on queued requests.
const ASKED: usize = 256;
/// Longest wait for pages to close at the end.
const LEAVE: Duration = Duration::from_millis(200);

/// A request or the departure of a page.
#[derive(Clone, Debug, PartialEq)]
pub struct PageRequest {
    /// Number of the client.
    pub client: u64,
    /// Request; `None` if the client has left.
    pub request: Option<NumberedRequest>,
}

/// State shared by all threads.
struct Hub {
    place: Place,
    offers: Offers,
    clients: Mutex<Vec<Arc<Client>>>,
    /// First message to a client.
    greeting: Mutex<Utf8Bytes>,
    pending: Pending,
    connections: AtomicUsize,
    number: AtomicU64,
    stop: AtomicBool,
    asked: SyncSender<PageRequest>,
}

/// A served page; the server stops on drop.
pub struct Page {
    hub: Arc<Hub>,
    asked: Receiver<PageRequest>,
    thread: Option<JoinHandle<()>>,
}

fn locked<T>(what: &Mutex<T>) -> MutexGuard<'_, T> {
    what.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Page {
    /// Serves the page at `port` of this machine; 0 takes a free port. Each client first receives `greeting`. `framed`
    /// lets other pages of this machine show the page in a frame, and `offers` is what it offers beside playing.
    ///
    /// # Errors
    /// Fails if the port is in use, or if the system provides no random numbers or no thread.
    pub fn open(port: u16, greeting: &Message, framed: bool, offers: Offers) -> std::io::Result<Page> {
        let mut random = [0_u8; 16];
        getrandom::fill(&mut random).map_err(std::io::Error::other)?;
        let token = random.iter().fold(String::new(), |s, b| s + &format!("{b:02x}"));
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let place = Place { port: listener.local_addr()?.port(), token, framed };
        let (tell, asked) = sync_channel(ASKED);
        let hub = Arc::new(Hub {
            place,
            offers,
            clients: Mutex::default(),
            greeting: Mutex::new(text(greeting)),
            pending: Pending::default(),
            connections: AtomicUsize::new(0),
            number: AtomicU64::new(0),
            stop: AtomicBool::new(false),
            asked: tell,
        });
        let of = hub.clone();
        let thread = Builder::new().name("ca page".into()).spawn(move || accept(&of, &listener))?;
        Ok(Page { hub, asked, thread: Some(thread) })
    }

    /// Returns the address of the page. Anybody with this address can play.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.hub.place.port, self.hub.place.token)
    }

    /// Returns the requests since the last call, in order.
    pub fn requests(&self) -> impl Iterator<Item = PageRequest> {
        self.asked.try_iter()
    }

    /// Returns a handle to the open pages.
    pub fn feed(&self) -> Feed {
        Feed(self.hub.clone())
    }
}

impl Drop for Page {
    /// Closes all pages, without waiting for clients that do not respond.
    fn drop(&mut self) {
        self.hub.stop.store(true, Relaxed);
        self.hub.all(|c| c.close(CloseCode::Away));
        // wakes the accepting thread, so that it sees `stop`
        let woken = TcpStream::connect((Ipv4Addr::LOCALHOST, self.hub.place.port));
        if let Some(thread) = self.thread.take().filter(|_| woken.is_ok()) {
            let _ = thread.join();
        }
        let end = Instant::now() + LEAVE;
        while self.hub.connections.load(Relaxed) > 0 && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

/// Handle to the open pages, for any thread.
#[derive(Clone)]
pub struct Feed(Arc<Hub>);

impl Pages for Feed {
    fn greet(&self, scene: &Message) {
        let text = text(scene);
        (*locked(&self.0.greeting)).clone_from(&text);
        self.0.all(|c| c.send(text.clone()));
    }

    fn send(&self, page: u64, message: &Message) {
        self.0.all(|c| {
            if c.number == page {
                c.send(text(message));
            }
        });
    }

    fn send_all(&self, message: &Message) {
        let text = text(message);
        self.0.all(|c| c.send(text.clone()));
    }

    fn count(&self) -> usize {
        locked(&self.0.clients).len()
    }

    fn is_heard(&self) -> bool {
        locked(&self.0.clients).iter().any(|c| c.wants_sound.load(Relaxed))
    }

    fn view(&self, picture: &[u8]) {
        let bytes = Bytes::copy_from_slice(picture);
        self.0.all(|c| c.view(bytes.clone()));
    }

    fn sound(&self, block: &[u8]) {
        let bytes = Bytes::copy_from_slice(block);
        self.0.all(|c| c.sound(bytes.clone()));
    }
}

impl Hub {
    fn all(&self, f: impl Fn(&Client)) {
        locked(&self.clients).iter().for_each(|c| f(c));
    }

    fn serve(self: &Arc<Hub>, mut stream: TcpStream, waits: PendingGuard) {
        let _ = stream.set_write_timeout(Some(http::STUCK));
        let head = match self.place.read(&mut stream) {
            None => return,
            Some(Head::Refused(status)) => {
                let _ = http::refuse(&mut stream, status);
                return;
            }
            Some(head) => head,
        };
        drop(waits);
        let _counted = CountGuard(self.clone());
        if self.connections.fetch_add(1, Relaxed) >= MOST {
            let _ = http::refuse(&mut stream, 503);
            return;
        }
        match head {
            Head::File(name) => {
                let _ = self.send_file(&mut stream, &name);
            }
            Head::Socket(key, rest) if http::agree(&mut stream, &key).is_ok() => self.talk(stream, rest),
            _ => {}
        }
    }

    fn send_file(&self, stream: &mut TcpStream, name: &str) -> std::io::Result<()> {
        if let Some((kind, text)) = self.offers.file(name) {
            return http::send(stream, (kind, text.as_bytes()), self.place.framed);
        }
        match asset::find(name) {
            Some(file) => http::send(stream, (file.kind, file.bytes), self.place.framed),
            None => http::refuse(stream, 404),
        }
    }

    /// Serves a client until its socket closes.
    fn talk(&self, stream: TcpStream, rest: Vec<u8>) {
        let client = Arc::new(Client::new(self.number.fetch_add(1, Relaxed)));
        {
            // greeting and registration share one lock, so that the client does not miss the greeting of a new scene
            let mut clients = locked(&self.clients);
            client.send(locked(&self.greeting).clone());
            clients.push(client.clone());
        }
        client.run(stream, rest, &mut |text| self.queue_request(&client, text));
        locked(&self.clients).retain(|c| c.number != client.number);
        let mut gone = PageRequest { client: client.number, request: None };
        // the session must release what the client held, so this waits for space in the queue
        while let Err(std::sync::mpsc::TrySendError::Full(back)) = self.asked.try_send(gone) {
            if self.stop.load(Relaxed) {
                return;
            }
            gone = back;
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Queues a request, or replies with the reason for refusing it.
    fn queue_request(&self, client: &Client, message: &str) {
        let reply = |id: Option<Value>, ok, why: &str| {
            let id = id.unwrap_or_default();
            client.send(text(&Message::Reply { id, ok, text: why.into(), picked: None }));
        };
        let object = match serde_json::from_str::<Value>(message) {
            Ok(object) if object.is_object() => object,
            Ok(_) => return reply(None, false, "a request must be a JSON object"),
            Err(e) => return reply(None, false, &format!("the request is not JSON: {e}")),
        };
        let asked = NumberedRequest::read(object);
        let id = asked.id.clone();
        if let Ok(Request::Sound { on }) = asked.request {
            client.wants_sound.store(on, Relaxed);
            return reply(id, true, if on { "sound" } else { "silent" });
        }
        if self.asked.try_send(PageRequest { client: client.number, request: Some(asked) }).is_err() {
            reply(id, false, "too many requests are waiting; try again");
        }
    }
}

/// Counts a connection with the token until its thread ends.
struct CountGuard(Arc<Hub>);

impl Drop for CountGuard {
    fn drop(&mut self) {
        self.0.connections.fetch_sub(1, Relaxed);
    }
}

/// Occupies the slot of a connection without the token until its thread ends.
struct PendingGuard(Arc<Hub>, u64);

impl Drop for PendingGuard {
    fn drop(&mut self) {
        self.0.pending.remove(self.1);
    }
}

fn accept(hub: &Arc<Hub>, listener: &TcpListener) {
    for (number, stream) in (0..).zip(listener.incoming()) {
        if hub.stop.load(Relaxed) {
            return;
        }
        let both = stream.and_then(|stream| Ok((stream.try_clone()?, stream)));
        let Ok((other, stream)) = both else {
            // no file descriptor is free until another connection ends
            std::thread::sleep(Duration::from_millis(20));
            continue;
        };
        hub.pending.add(number, other);
        let waits = PendingGuard(hub.clone(), number);
        // closes the connection if no thread is available
        let _ = Builder::new().name("ca client".into()).spawn(move || {
            let hub = waits.0.clone();
            hub.serve(stream, waits);
        });
    }
}

fn text(message: &Message) -> Utf8Bytes {
    message.text().into()
}
