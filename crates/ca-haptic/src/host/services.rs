//! Opens the services of a device, for both sides.
//!
//! All queue sizes are here, so that either side may make the services. A service has one publisher: a second device of
//! the same name, or a second server, gets an error with the name of the process that is the publisher. The publisher
//! of a killed process is removed and replaced.

use super::error::{HostError, HostErrorKind};
use super::site::{Ipc, Site};
use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::prelude::{
    BackpressureStrategy, CallbackProgression, Node, PortFactory as _, Service as _, ServiceName, ZeroCopySend,
};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeCreateError as Create, PublishSubscribeOpenError as Open,
    PublishSubscribeOpenOrCreateError as Either,
};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use std::fmt::Debug;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Length of the queue of a reader: the newest frames.
const BUFFER: usize = 4;
/// Maximum number of readers of a service: the other side, and processes that list or watch.
const READERS: usize = 8;
/// Longest wait for another process that is just starting or ending.
const PATIENCE: Duration = Duration::from_secs(1);

/// A service of a device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Service {
    /// Device frames.
    In,
    /// Force frames.
    Out,
    /// Description of the device.
    About,
    /// Event that wakes the device.
    Wake,
}

impl Service {
    /// Returns the name of this service for a device.
    pub fn of(self, device: &str) -> String {
        let end = match self {
            Service::In => "in",
            Service::Out => "out",
            Service::About => "about",
            Service::Wake => "wake",
        };
        format!("ca/v{}/{device}/{end}", crate::frame::VERSION)
    }
}

/// Checks the name of a device: 1 to 16 ASCII letters, digits, `_`, `-` or `.`
///
/// # Errors
/// If the name is not of this form.
pub fn check_name(name: &str) -> Result<(), HostError> {
    let plain = name.bytes().all(|b| b.is_ascii_alphanumeric() || matches!(b, b'_' | b'-' | b'.'));
    if (1..=16).contains(&name.len()) && plain {
        return Ok(());
    }
    let what = format!("invalid device name `{}`", name.escape_debug());
    Err(HostError::new(HostErrorKind::Name, what, "use 1 to 16 characters from a-z A-Z 0-9 _ - ."))
}

fn service_name(name: &str) -> Result<ServiceName, HostError> {
    ServiceName::new(name).map_err(|e| HostError::system(format!("`{name}`"), e))
}

pub(super) struct Frames<T: Debug + ZeroCopySend + 'static> {
    name: String,
    device: String,
    factory: PortFactory<Ipc, T, ()>,
}

impl<T: Debug + Copy + ZeroCopySend + 'static> Frames<T> {
    /// Opens or makes the service. A later reader gets up to `history` past frames.
    pub fn open(node: &Node<Ipc>, device: &str, line: Service, history: usize) -> Result<Frames<T>, HostError> {
        let name = line.of(device);
        let service = service_name(&name)?;
        let end = Instant::now() + PATIENCE;
        loop {
            let made = node
                .service_builder(&service)
                .publish_subscribe::<T>()
                .enable_safe_overflow(true)
                .history_size(history)
                .subscriber_max_buffer_size(BUFFER)
                .subscriber_max_borrowed_samples(2)
                .max_publishers(1)
                .max_subscribers(READERS)
                .max_nodes(4 * READERS)
                .open_or_create();
            match made {
                Ok(factory) => return Ok(Frames { name, device: device.into(), factory }),
                Err(e) if passing(e) && Instant::now() < end => sleep(Duration::from_millis(5)),
                Err(e) => return Err(refused(&name, e)),
            }
        }
    }

    /// Makes the publisher. It never waits: a late reader loses the oldest frames.
    pub fn publisher(&self, site: &Site) -> Result<Publisher<Ipc, T, ()>, HostError> {
        let end = Instant::now() + PATIENCE;
        loop {
            let made =
                self.factory.publisher_builder().backpressure_strategy(BackpressureStrategy::DiscardData).create();
            match made {
                Ok(port) => return Ok(port),
                Err(PublisherCreateError::ExceedsMaxSupportedPublishers) => {
                    let swept = site.swept();
                    if swept.removed == 0 && (self.holder(site).is_some() || Instant::now() > end) {
                        return Err(self.busy(site));
                    }
                    sleep(Duration::from_millis(5));
                }
                Err(e) => return Err(HostError::system(format!("`{}` cannot be written", self.name), e)),
            }
        }
    }

    /// Makes a subscriber with a queue of [`BUFFER`] frames, even if a recording process made the service for longer
    /// ones.
    pub fn subscriber(&self, site: &Site, history: usize) -> Result<Subscriber<Ipc, T, ()>, HostError> {
        let end = Instant::now() + PATIENCE;
        loop {
            match self.factory.subscriber_builder().buffer_size(BUFFER).history_request(history).create() {
                Ok(port) => return Ok(port),
                Err(SubscriberCreateError::ExceedsMaxSupportedSubscribers) if Instant::now() < end => {
                    site.swept();
                    sleep(Duration::from_millis(5));
                }
                Err(SubscriberCreateError::ExceedsMaxSupportedSubscribers) => {
                    let what = format!("`{}` already has {READERS} readers, the most that it can have", self.name);
                    return Err(HostError::new(HostErrorKind::Busy, what, "stop one of them"));
                }
                Err(e) => return Err(HostError::system(format!("`{}` cannot be read", self.name), e)),
            }
        }
    }

    fn holder(&self, site: &Site) -> Option<String> {
        let mut node = None;
        self.factory.dynamic_config().list_publishers(|p| {
            node = Some(p.node_id);
            CallbackProgression::Stop
        });
        let node = node?;
        site.who(|id| *id == node)
    }

    pub fn writers(&self) -> usize {
        self.factory.dynamic_config().number_of_publishers()
    }

    fn busy(&self, site: &Site) -> HostError {
        let who = self.holder(site).unwrap_or_else(|| "another process".into());
        let (role, fix) = if self.name.ends_with("/out") {
            ("a server", "only one server can use a device: stop it, or set CA_SHM_ROOT to another folder")
        } else {
            ("a device", "stop that process, or give this device another name")
        };
        HostError::new(HostErrorKind::Busy, format!("`{}` already has {role}: {who}", self.device), fix)
    }
}

/// Returns true for an error that passes, because another process is just making or removing the service.
fn passing(e: Either) -> bool {
    use Either::{PublishSubscribeCreateError as C, PublishSubscribeOpenError as O};
    matches!(
        e,
        O(Open::DoesNotExist | Open::HangsInCreation | Open::IsMarkedForDestruction | Open::ServiceInCorruptedState)
            | C(Create::AlreadyExists | Create::HangsInCreation | Create::IsBeingCreatedByAnotherInstance)
    )
}

fn refused(name: &str, e: Either) -> HostError {
    use Either::PublishSubscribeOpenError as O;
    let kind = HostErrorKind::Version;
    match e {
        O(Open::IncompatibleTypes) => HostError::new(
            kind,
            format!("`{name}` is already open with another frame layout"),
            "build or install the same release of ca for both processes",
        ),
        O(
            Open::IncompatibleOverflowBehavior
            | Open::DoesNotSupportRequestedMinBufferSize
            | Open::DoesNotSupportRequestedMinHistorySize
            | Open::DoesNotSupportRequestedMinSubscriberBorrowedSamples
            | Open::DoesNotSupportRequestedAmountOfPublishers
            | Open::DoesNotSupportRequestedAmountOfSubscribers
            | Open::DoesNotSupportRequestedAmountOfNodes
            | Open::IncompatibleMessagingPattern,
        ) => HostError::new(
            kind,
            format!("`{name}` is already open with other queue settings ({e:?})"),
            "open it as the examples of ca-haptic do: overflow, buffer 4, one writer",
        ),
        O(Open::VersionMismatch) => HostError::new(
            kind,
            format!("`{name}` was created by another release of iceoryx2"),
            "run `ca shm clean`, then start both processes with the same release of ca",
        ),
        O(Open::ServiceInCorruptedState) => HostError::new(
            HostErrorKind::System,
            format!("`{name}` is incomplete: the process that created it was killed"),
            "run `ca shm clean`",
        ),
        e => HostError::system(format!("`{name}` cannot be opened"), e),
    }
}

/// Lists the names of the devices that have services at this site.
pub(super) fn devices(site: &Site) -> Result<Vec<String>, HostError> {
    let (start, end) = (format!("ca/v{}/", crate::frame::VERSION), "/about");
    let mut names = Vec::new();
    Ipc::list(&site.config(), |service| {
        let name = service.static_details.name().as_str();
        if let Some(device) = name.strip_prefix(&start).and_then(|n| n.strip_suffix(end))
            && check_name(device).is_ok()
        {
            names.push(device.to_owned());
        }
        CallbackProgression::Continue
    })
    .map_err(|e| HostError::system(format!("`{}` cannot be listed", site.root().display()), e))?;
    names.sort();
    names.dedup();
    Ok(names)
}

pub(super) struct Wakeup {
    factory: iceoryx2::service::port_factory::event::PortFactory<Ipc>,
    name: String,
}

impl Wakeup {
    pub fn open(node: &Node<Ipc>, device: &str) -> Result<Wakeup, HostError> {
        let name = Service::Wake.of(device);
        let service = service_name(&name)?;
        let end = Instant::now() + PATIENCE;
        loop {
            let made = node
                .service_builder(&service)
                .event()
                .event_id_max_value(1)
                .max_notifiers(READERS)
                .max_listeners(READERS)
                .max_nodes(4 * READERS)
                .open_or_create();
            match made {
                Ok(factory) => return Ok(Wakeup { factory, name }),
                // every error is retried until `end`
                Err(_) if Instant::now() < end => sleep(Duration::from_millis(5)),
                Err(e) => return Err(HostError::system(format!("`{name}` cannot be opened"), e)),
            }
        }
    }

    pub fn notifier(&self, site: &Site) -> Result<Notifier<Ipc>, HostError> {
        self.port(site, || self.factory.notifier_builder().create())
    }

    pub fn listener(&self, site: &Site) -> Result<Listener<Ipc>, HostError> {
        self.port(site, || self.factory.listener_builder().create())
    }

    fn port<P, E: Debug>(&self, site: &Site, make: impl Fn() -> Result<P, E>) -> Result<P, HostError> {
        make().or_else(|_| {
            site.swept();
            make().map_err(|e| HostError::system(format!("cannot connect to `{}`", self.name), e))
        })
    }
}
