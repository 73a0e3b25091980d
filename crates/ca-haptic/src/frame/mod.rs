//! Frames: what a device process and the engine say to each other, byte for byte.
//!
//! Decides on structures of fixed size without padding, little-endian by nature of every machine we run on, whose
//! layout *is* a text: each structure has its ROS 2 message definition beside it, `LAYOUT` is the FNV-1a hash of that
//! text, and a test compares text and structure field by field. So one frame is the shared memory, the body of the CDR
//! message in a take and the row a Python user reads, and nothing is ever converted. SI throughout: m, N, s. Forces are
//! those *on the hand*. Angles would be a device's own axes; a DOF is a length here.

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

/// Degrees of freedom of the largest device: 24 keys, and room.
pub const DOF: usize = 32;
/// Version of the frames and of the services that carry them.
pub const VERSION: u32 = 1;

/// FNV-1a of a text, for layouts and calibrations.
pub const fn fnv(text: &[u8]) -> u64 {
    let (mut hash, mut i) = (0xcbf2_9ce4_8422_2325_u64, 0);
    while i < text.len() {
        hash = (hash ^ text[i] as u64).wrapping_mul(0x0000_0100_0000_01b3);
        i += 1;
    }
    hash
}

/// What names a device on the wire: its name, cut to 16 bytes, zeros after it.
pub fn uid(name: &str) -> [u8; 16] {
    let mut uid = [0; 16];
    for (to, from) in uid.iter_mut().zip(name.bytes()) {
        *to = from;
    }
    uid
}
