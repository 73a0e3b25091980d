//! Connections that have not sent the token yet.
//!
//! Every user of this machine can connect, so these connections have slots separate from those for pages. At most
//! [`MOST`] wait at a time. A further connection drops the oldest one. So many silent connections cannot block a new
//! one, which sends its request at once.

use std::collections::VecDeque;
use std::net::{Shutdown, TcpStream};
use std::sync::{Condvar, Mutex, PoisonError};

/// Limit on waiting connections.
const MOST: usize = 64;

/// Waiting connections, oldest first.
#[derive(Default)]
pub(crate) struct Pending {
    list: Mutex<VecDeque<(u64, TcpStream)>>,
    fewer: Condvar,
}

impl Pending {
    /// Adds a connection. If there are too many, drops the oldest and waits until its thread has noticed.
    pub(crate) fn add(&self, number: u64, stream: TcpStream) {
        let mut list = self.list.lock().unwrap_or_else(PoisonError::into_inner);
        while list.len() >= MOST {
            if let Some((_, oldest)) = list.front() {
                // ends the read of its thread
                let _ = oldest.shutdown(Shutdown::Both);
            }
            list = self.fewer.wait(list).unwrap_or_else(PoisonError::into_inner);
        }
        list.push_back((number, stream));
    }

    /// Removes a connection that has sent the token or is closed.
    pub(crate) fn remove(&self, number: u64) {
        self.list.lock().unwrap_or_else(PoisonError::into_inner).retain(|(n, _)| *n != number);
        self.fewer.notify_one();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read as _;
    use std::net::TcpListener;

    #[test]
    fn one_more_drops_the_oldest_and_takes_its_place() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let mut ends: Vec<TcpStream> = Vec::new();
        let mut connection = || {
            ends.push(TcpStream::connect(listener.local_addr().expect("an address")).expect("connected"));
            listener.accept().expect("accepted").0
        };
        let pending = Pending::default();
        for number in 0..MOST as u64 {
            pending.add(number, connection());
        }
        let more = connection();
        std::thread::scope(|s| {
            let added = s.spawn(|| pending.add(MOST as u64, more));
            // the client end is closed too
            assert_eq!(ends[0].read(&mut [0; 8]).expect("closed"), 0);
            assert!(!added.is_finished(), "it waits for the place");
            pending.remove(0);
            added.join().expect("no panic");
        });
        let list = pending.list.lock().expect("no panic");
        assert!(list.iter().map(|(n, _)| *n).eq(1..=MOST as u64));
        // no other connection was dropped
        ends[1].set_nonblocking(true).expect("set");
        assert!(ends[1].read(&mut [0; 8]).is_err_and(|e| e.kind() == std::io::ErrorKind::WouldBlock));
    }
}
