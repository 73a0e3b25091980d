//! Frames exchanged by a device process and the engine, byte for byte.
//!
//! Each frame is a structure of fixed size without padding, little-endian on every supported machine. Its layout is a
//! text, the ROS 2 message definition beside it: `LAYOUT` is the FNV-1a hash of that text, and a test compares text and
//! structure field by field. The same bytes are the shared memory, the body of the CDR message in a take and the row in
//! Python, so nothing is converted.
//!
//! Units are SI: m, N, s. Forces act *on the hand*. A DOF is a length here, not an angle.

mod about;
mod cause;
mod device;
mod force;
mod mismatch;

pub use about::{About, text};
pub use cause::{CAUSES, Cause, Mode};
pub use device::{DeviceFrame, status};
pub use force::{ForceFrame, flag};
pub use mismatch::FrameMismatch;

/// Degrees of freedom of the largest device: 24 keys and a margin.
pub const DOF: usize = 32;
/// Version of the frames and of the services that carry them.
pub const VERSION: u32 = 1;

/// Returns the FNV-1a hash of a text, for layouts and calibrations.
pub const fn fnv(text: &[u8]) -> u64 {
    let (mut hash, mut i) = (0xcbf2_9ce4_8422_2325_u64, 0);
    while i < text.len() {
        hash = (hash ^ text[i] as u64).wrapping_mul(0x0000_0100_0000_01b3);
        i += 1;
    }
    hash
}

/// Returns the id of a device on the wire: its name, cut to 16 bytes and padded with zeros.
pub fn uid(name: &str) -> [u8; 16] {
    let mut uid = [0; 16];
    for (to, from) in uid.iter_mut().zip(name.bytes()) {
        *to = from;
    }
    uid
}
