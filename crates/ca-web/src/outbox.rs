//! Messages of the engine to its page, in order.

use ca_session::Pages;
use ca_session::protocol::Message;
use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;

/// Largest number of messages that wait. Older ones are dropped, in case the caller fetches none.
const LARGEST: usize = 1024;

/// Messages that wait for the page: JSON texts, and bytes of [`ca_session::protocol::binary`].
#[derive(Clone, Default)]
pub struct Outbox(Rc<Waiting>);

#[derive(Default)]
struct Waiting {
    messages: RefCell<VecDeque<Vec<u8>>>,
    heard: Cell<bool>,
}

impl Outbox {
    /// Adds a message.
    pub fn put(&self, message: Vec<u8>) {
        let mut messages = self.0.messages.borrow_mut();
        if messages.len() >= LARGEST {
            messages.pop_front();
        }
        messages.push_back(message);
    }

    /// Takes the oldest message.
    pub fn next(&self) -> Option<Vec<u8>> {
        self.0.messages.borrow_mut().pop_front()
    }

    /// Sets whether the page wants sound.
    pub fn hear(&self, on: bool) {
        self.0.heard.set(on);
    }
}

impl Pages for Outbox {
    fn greet(&self, scene: &Message) {
        self.send_all(scene);
    }

    fn send(&self, _: u64, message: &Message) {
        self.send_all(message);
    }

    fn send_all(&self, message: &Message) {
        self.put(message.text().into_bytes());
    }

    fn count(&self) -> usize {
        1
    }

    fn is_heard(&self) -> bool {
        self.0.heard.get()
    }

    fn view(&self, picture: &[u8]) {
        self.put(picture.to_vec());
    }

    fn sound(&self, block: &[u8]) {
        self.put(block.to_vec());
    }
}
