//! Opens the lines of a device like independent software: with iceoryx2 alone, by name and layout.

use ca_haptic::host::Site;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use std::fmt::Debug;
use std::time::{Duration, Instant};

/// Frames in the queue of a reader.
const QUEUE: usize = 4;

/// Node that keeps lines open; ports are dropped before it.
pub struct RawSite(Node<ipc::Service>);

impl RawSite {
    pub fn new(site: &Site) -> RawSite {
        let node = NodeBuilder::new()
            .config(&site.config())
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .unwrap();
        RawSite(node)
    }

    fn line<T: Debug + Copy + ZeroCopySend + 'static>(
        &self,
        device: &str,
        line: &str,
        history: usize,
        queue: usize,
    ) -> PortFactory<ipc::Service, T, ()> {
        let name = ServiceName::new(&format!("ca/v1/{device}/{line}")).unwrap();
        let end = Instant::now() + Duration::from_secs(30);
        loop {
            let made = self
                .0
                .service_builder(&name)
                .publish_subscribe::<T>()
                .enable_safe_overflow(true)
                .history_size(history)
                .subscriber_max_buffer_size(queue)
                .subscriber_max_borrowed_samples(2)
                .max_publishers(1)
                .max_subscribers(8)
                .max_nodes(32)
                .open_or_create();
            match made {
                Ok(factory) => return factory,
                // another process opens or closes the line at this moment
                Err(e) => assert!(Instant::now() < end, "{name}: {e:?}"),
            }
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    pub fn writer<T: Debug + Copy + ZeroCopySend + 'static>(
        &self,
        device: &str,
        line: &str,
        history: usize,
    ) -> Publisher<ipc::Service, T, ()> {
        let factory = self.line::<T>(device, line, history, QUEUE);
        factory.publisher_builder().backpressure_strategy(BackpressureStrategy::DiscardData).create().unwrap()
    }

    pub fn reader<T: Debug + Copy + ZeroCopySend + 'static>(
        &self,
        device: &str,
        line: &str,
    ) -> Subscriber<ipc::Service, T, ()> {
        self.deep_reader(device, line, QUEUE)
    }

    /// Opens a reader with a longer queue than devices and servers use. Only the creator of a line can do this.
    pub fn deep_reader<T: Debug + Copy + ZeroCopySend + 'static>(
        &self,
        device: &str,
        line: &str,
        queue: usize,
    ) -> Subscriber<ipc::Service, T, ()> {
        self.line::<T>(device, line, 0, queue).subscriber_builder().buffer_size(queue).create().unwrap()
    }
}
