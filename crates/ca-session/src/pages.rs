//! Open pages, as a session and its sink use them.

use crate::protocol::Message;

/// Open pages. No method waits for a page.
pub trait Pages {
    /// Sends the message `scene` to all pages, and to each later page.
    fn greet(&self, scene: &Message);

    /// Sends a message to one page.
    fn send(&self, page: u64, message: &Message);

    /// Sends a message to all pages.
    fn send_all(&self, message: &Message);

    /// Returns the number of open pages.
    fn count(&self) -> usize;

    /// Returns true if a page is open.
    fn is_seen(&self) -> bool {
        self.count() > 0
    }

    /// Returns true if a page wants sound.
    fn is_heard(&self) -> bool;

    /// Sends a picture ([`binary::view`](crate::protocol::binary::view)), in place of one not yet fetched.
    fn view(&self, picture: &[u8]);

    /// Sends sound ([`binary::sound`](crate::protocol::binary::sound)) to the pages that want it.
    fn sound(&self, block: &[u8]);
}
