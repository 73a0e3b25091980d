//! Devices in other processes: frames over shared memory, and the control of a running server.
//!
//! Decides that iceoryx2 is seen nowhere but in this folder. Its ports allocate when they publish and when a peer
//! connects, so they live in the [`gateway`] thread, which the engine meets through rings only. Live frames go by
//! publish and subscribe with overflow: the newest four, nobody ever waits. A blackboard would be faster, and locked for
//! good by a writer that is killed.
//!
//! ```text
//! ca/v1/<device>/in     DeviceFrame   device → engine
//! ca/v1/<device>/out    ForceFrame    engine → device
//! ca/v1/<device>/about  About         device → all, once a second, the last is kept for those who come later
//! ca/v1/<device>/wake   event         a force frame is there
//! ```
//!
//! `ca set`, `ca disarm` and the like speak to a server over a socket in the folder of the place ([`control`]).
//!
//! The trust boundary is the user: every process of the same user can write into this memory, no other can open it. Other
//! users cannot know its names before they are used (`shm/prefix.rs`), their files under such names are ignored (`ours.rs`), and
//! opening has a limit of time (`within.rs`).

mod claim;
pub mod client;
pub mod control;
mod error;
pub mod gateway;
pub mod lines;
mod ours;
mod room;
mod session;
mod shm;
pub mod site;
pub mod stale_shm;
pub mod user;
pub mod watch;
mod within;

pub use client::DeviceClient;
pub use error::{HostError, HostErrorKind};
pub use gateway::{Event, Gateway, Rings, Running, Traffic};
pub use session::session;
pub use site::Site;
