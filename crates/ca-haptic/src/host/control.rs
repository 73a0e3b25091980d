//! What people ask of a running server: parameters, arming, status.
//!
//! Decides on JSON texts over a request and response service of the same place, apart from the frames: whoever can reach
//! the devices can reach this, nobody else, and a person can read what is said. One server a place. All values of one
//! request land in one tick.

use super::error::{HostError, HostErrorKind};
use super::room;
use super::site::{Ipc, Site};
use super::within::{LIMIT, within};
use crate::frame::VERSION;
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::{
    AllocationStrategy, BackpressureStrategy, CallbackProgression, Node, PortFactory as _, ServiceName,
};
use iceoryx2::service::builder::request_response::{Builder, RequestResponseOpenError as Open};
use iceoryx2::service::port_factory::server::ServerCreateError;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Callers at a time.
const CALLERS: usize = 8;
/// Length texts begin with; they grow \[bytes\].
const LENGTH: usize = 4096;
/// Texts that have places in memory at a time, as iceoryx2 reckons for these numbers of callers.
const UNDER_WAY: u64 = 96;

/// A value as it was typed: a number in SI units, or a text with its unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Given {
    /// in the model's units
    Number(f64),
    /// `8 kN/m`
    Text(String),
}

/// What is asked.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "lowercase", deny_unknown_fields)]
pub enum Request {
    /// new values of live parameters, all in one tick
    Set {
        /// by name
        values: BTreeMap<String, Given>,
    },
    /// forces on, once nothing pushes
    Arm {
        /// one device; all if absent
        device: Option<String>,
    },
    /// forces off
    Disarm {
        /// one device; all if absent
        device: Option<String>,
    },
    /// how it goes
    Status,
    /// the end
    Stop,
}

/// What is answered.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reply {
    /// whether it was done
    pub ok: bool,
    /// for people: what was done, or why not
    #[serde(default)]
    pub text: String,
    /// for programs
    #[serde(default)]
    pub fields: Map<String, Value>,
}

impl Reply {
    /// It was done.
    pub fn done(text: impl Into<String>) -> Reply {
        Reply { ok: true, text: text.into(), fields: Map::new() }
    }
    /// It was not.
    pub fn refused(text: impl Into<String>) -> Reply {
        Reply { ok: false, text: text.into(), fields: Map::new() }
    }
}

type Service = Builder<[u8], (), [u8], (), Ipc>;
type Call = ActiveRequest<Ipc, [u8], (), [u8], ()>;

fn service(node: &Node<Ipc>) -> Result<(String, Service), HostError> {
    let name = format!("ca/v{VERSION}/control");
    let service = ServiceName::new(&name).map_err(|e| HostError::system(format!("`{name}`"), e))?;
    let builder = node
        .service_builder(&service)
        .request_response::<[u8], [u8]>()
        .max_servers(1)
        .max_clients(CALLERS)
        .max_nodes(4 * CALLERS)
        .max_active_requests_per_client(1)
        .max_response_buffer_size(1);
    Ok((name, builder))
}

/// Time for the last who asked to read their answer before its memory goes with the server.
const READ: Duration = Duration::from_secs(1);

/// The server's end.
pub struct ControlServer {
    /// Answered by the last [`ControlServer::poll`]: an answer is lost where its memory goes before it is mapped.
    answered: Vec<Call>,
    server: Server<Ipc, [u8], (), [u8], ()>,
    _node: Node<Ipc>,
}

impl ControlServer {
    /// Opens it. Another server at this place is an error; one that was killed is not.
    ///
    /// # Errors
    /// Where another server has the place, or the shared memory cannot be made.
    pub fn open(site: &Site) -> Result<ControlServer, HostError> {
        super::stale_shm::strangers(site)?;
        within(site, room::CONTROL, LIMIT, ControlServer::made)
    }

    fn made(site: &Site) -> Result<ControlServer, HostError> {
        let node = site.node("control")?;
        let (name, _) = service(&node)?;
        let end = Instant::now() + Duration::from_secs(1);
        loop {
            let factory = match service(&node)?.1.open_or_create() {
                Ok(factory) => factory,
                Err(_) if Instant::now() < end => {
                    sleep(Duration::from_millis(5));
                    continue;
                }
                Err(e) => return Err(HostError::system(format!("`{name}` cannot be opened"), e)),
            };
            let made = factory
                .server_builder()
                .initial_max_slice_len(LENGTH)
                .allocation_strategy(AllocationStrategy::PowerOfTwo)
                .backpressure_strategy(BackpressureStrategy::DiscardData)
                .create();
            match made {
                Ok(server) => return Ok(ControlServer { answered: Vec::new(), server, _node: node }),
                Err(ServerCreateError::ExceedsMaxSupportedServers) => {
                    let mut id = None;
                    factory.dynamic_config().list_servers(|s| {
                        id = Some(s.node_id);
                        CallbackProgression::Stop
                    });
                    let who = id.and_then(|id| site.who(|other| *other == id));
                    if let (0, Some(who)) = (site.swept().removed, who) {
                        let what = format!("a server runs at `{}` already: {who}", site.root().display());
                        let fix = "stop it, or set another CA_SHM_ROOT";
                        return Err(HostError::new(HostErrorKind::Busy, what, fix));
                    }
                    if Instant::now() > end {
                        return Err(HostError::system(format!("`{name}` has a server that is not there"), made.err()));
                    }
                    sleep(Duration::from_millis(5));
                }
                Err(e) => return Err(HostError::system(format!("`{name}` cannot be served"), e)),
            }
        }
    }

    /// Answers what was asked. What cannot be read is answered here.
    pub fn poll(&mut self, answer: &mut dyn FnMut(Request) -> Reply) {
        self.answered.clear();
        while let Ok(Some(call)) = self.server.receive() {
            let reply = match serde_json::from_slice(call.payload()) {
                Ok(request) => answer(request),
                Err(e) => Reply::refused(format!("not a request: {e}")),
            };
            let text = serde_json::to_vec(&reply).unwrap_or_default();
            // one who asked and left gets no answer, nor does a question for whose answer there is no room
            if !fits(text.len()) {
                continue;
            }
            if let Ok(room) = call.loan_slice_uninit(text.len()) {
                let _ = room.write_from_slice(&text).send();
                self.answered.retain(Call::is_connected);
                self.answered.push(call);
            }
        }
    }
}

impl Drop for ControlServer {
    /// Waits until the last answers were read: one of them may be the answer to [`Request::Stop`].
    fn drop(&mut self) {
        let end = Instant::now() + READ;
        while self.answered.iter().any(Call::is_connected) && Instant::now() < end {
            sleep(Duration::from_millis(1));
        }
    }
}

/// Most that a text of `length` bytes makes of new memory \[bytes\]: a place for each that may be under way.
fn grown(length: usize) -> u64 {
    if length <= LENGTH { 0 } else { UNDER_WAY * length.next_power_of_two() as u64 }
}

/// Whether there is room for a text.
fn fits(length: usize) -> bool {
    length <= LENGTH || room::check(grown(length)).is_ok()
}

/// Asks the server of this place, and waits for its answer at most this long.
///
/// # Errors
/// Where nobody answers within `patience`, or more than one server is there.
pub fn ask(site: &Site, request: &Request, patience: Duration) -> Result<Reply, HostError> {
    super::stale_shm::strangers(site)?;
    let text = serde_json::to_vec(request).map_err(|e| HostError::system("a request cannot be written", e))?;
    let need = room::ASK.max(grown(text.len()));
    within(site, need, LIMIT.saturating_add(patience), move |site| asked(site, &text, patience))
}

fn asked(site: &Site, text: &[u8], patience: Duration) -> Result<Reply, HostError> {
    let node = site.node("ask")?;
    let absent = || {
        let what = format!("no server runs at `{}`", site.root().display());
        HostError::new(HostErrorKind::Absent, what, "start one: `ca serve MODEL`")
    };
    let (name, builder) = service(&node)?;
    let factory = match builder.open() {
        Ok(factory) => factory,
        Err(Open::DoesNotExist | Open::IsMarkedForDestruction) => return Err(absent()),
        Err(e) => return Err(HostError::system(format!("`{name}` cannot be opened"), e)),
    };
    if factory.dynamic_config().number_of_servers() == 0 {
        return Err(absent());
    }
    let failed = |e: &dyn std::fmt::Debug| HostError::system(format!("`{name}` cannot be asked"), e);
    let client = factory
        .client_builder()
        .initial_max_slice_len(LENGTH)
        .allocation_strategy(AllocationStrategy::PowerOfTwo)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
        .map_err(|e| failed(&e))?;
    let room = client.loan_slice_uninit(text.len()).map_err(|e| failed(&e))?;
    let pending = room.write_from_slice(text).send().map_err(|e| failed(&e))?;
    let end = Instant::now() + patience;
    loop {
        // asked first: one who answers and ends has left its answer
        let there = pending.is_connected();
        if let Some(answer) = pending.receive().map_err(|e| failed(&e))? {
            return serde_json::from_slice(answer.payload()).map_err(|e| {
                let what = format!("the server at `{}` answers what is no reply: {e}", site.root().display());
                HostError::new(HostErrorKind::Answer, what, "run both sides from one release of ca")
            });
        }
        if !there {
            return Err(absent());
        }
        if Instant::now() > end {
            let what = format!("the server at `{}` does not answer within {patience:?}", site.root().display());
            return Err(HostError::new(HostErrorKind::Absent, what, "see whether it is stopped, or start it again"));
        }
        sleep(Duration::from_millis(1));
    }
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
