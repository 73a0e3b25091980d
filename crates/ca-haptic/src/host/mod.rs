//! Devices in other processes: frames over shared memory, and the control of a running server.
//!
//! Only this module uses iceoryx2. Its ports allocate when they publish and when a peer connects, so they live in the
//! [`gateway`] thread, which exchanges frames with the engine through rings. Live frames use publish-subscribe with
//! overflow: a reader gets the newest four, and no writer waits. A blackboard of iceoryx2, a shared value without a
//! queue, would be faster, but a writer that is killed while it writes leaves it locked forever.
//!
//! ```text
//! ca/v1/<device>/in     DeviceFrame   device → engine
//! ca/v1/<device>/out    ForceFrame    engine → device
//! ca/v1/<device>/about  About         device → all, once a second, the last is kept for those who come later
//! ca/v1/<device>/wake   event         a force frame is there
//! ```
//!
//! A [`Site`] is the folder of a user with the shared memory of devices and servers. `ca set`, `ca disarm` and similar
//! commands reach a server over a socket in this folder ([`control`]).
//!
//! The trust boundary is the user: each process of the same user can write to this memory, and no other user can open
//! it. Other users cannot know the names before they are used (`shm/prefix.rs`). Files that they create under these
//! names are ignored (`file_ownership.rs`), and opening has a time limit (`timeout.rs`).

mod claim;
pub mod client;
pub mod control;
mod error;
mod file_ownership;
pub mod force_watchdog;
mod free_memory;
pub mod gateway;
pub mod services;
mod session;
mod shm;
pub mod site;
pub mod stale_shm;
mod timeout;
pub mod user;

pub use client::DeviceClient;
pub use error::{HostError, HostErrorKind};
pub use gateway::{Event, Gateway, Rings, Running, Traffic};
pub use session::session_number;
pub use site::Site;
