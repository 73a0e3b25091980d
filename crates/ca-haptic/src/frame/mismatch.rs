//! Why a frame is none of this build, or of another device.
//!
//! Decides to name the first thing that is wrong, in the order in which a reader must trust a head: what it is, its version,
//! its layout, its size, whom it is for. So a layout that somebody changed is not called a version.

use super::{DOF, VERSION, text};
use std::fmt;

/// What is wrong with the head of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameMismatch {
    /// it does not begin as such a frame does
    Magic(u32),
    /// it is of this version, and not of ours
    Version(u32),
    /// the hash of its definition is not ours: fields were added, removed or moved
    Layout(u64),
    /// it has no degree of freedom, or more than there can be
    Size(u16),
    /// it is for this device
    Device(String),
}

impl FrameMismatch {
    /// The first thing wrong with a head: magic and layout as they are and as they should be, version, number of DOF.
    pub(super) fn find(magic: [u32; 2], layout: [u64; 2], version: u32, n: u16) -> Option<FrameMismatch> {
        if magic[0] != magic[1] {
            Some(FrameMismatch::Magic(magic[0]))
        } else if version != VERSION {
            Some(FrameMismatch::Version(version))
        } else if layout[0] != layout[1] {
            Some(FrameMismatch::Layout(layout[0]))
        } else if n == 0 || usize::from(n) > DOF {
            Some(FrameMismatch::Size(n))
        } else {
            None
        }
    }

    /// Another device than `wanted`.
    pub(super) fn other(device: [u8; 16], wanted: [u8; 16]) -> Option<FrameMismatch> {
        (device != wanted).then(|| FrameMismatch::Device(text(&device)))
    }
}

impl FrameMismatch {
    /// What to do about it.
    pub fn fix(&self) -> &'static str {
        match self {
            FrameMismatch::Magic(_) | FrameMismatch::Version(_) | FrameMismatch::Layout(_) => {
                "build the device process with this release of ca"
            }
            FrameMismatch::Size(_) => "set `n` of its frames",
            FrameMismatch::Device(_) => "write the name of the line into its frames",
        }
    }
}

impl fmt::Display for FrameMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FrameMismatch::Magic(m) => write!(f, "begin with {m:08x}, which no frame does"),
            FrameMismatch::Version(v) => write!(f, "are of version {v}, and this is version {VERSION}"),
            FrameMismatch::Layout(l) => write!(f, "are of version {VERSION} but of another layout ({l:016x})"),
            FrameMismatch::Size(n) => write!(f, "have {n} degrees of freedom; a frame has 1 to {DOF}"),
            FrameMismatch::Device(d) => write!(f, "are for `{d}`"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{About, DeviceFrame, ForceFrame, uid};

    #[test]
    fn what_is_wrong_with_a_head_is_called_what_it_is() {
        type Wrong = (&'static str, fn(&mut DeviceFrame));
        let good = DeviceFrame::new("key", 1);
        let cases: [Wrong; 7] = [
            ("are of version 7", |f| f.version = 7),
            ("of another layout", |f| f.layout ^= 1),
            ("of another layout", |f| f.layout = ForceFrame::LAYOUT),
            ("which no frame does", |f| f.magic = About::MAGIC),
            ("have 0 degrees", |f| f.n = 0),
            ("have 33 degrees", |f| f.n = 33),
            ("are for `keys`", |f| f.device = uid("keys")),
        ];
        assert_eq!(good.mismatch(uid("key")), None);
        for (want, wrong) in cases {
            let mut f = good;
            wrong(&mut f);
            let why = f.mismatch(uid("key")).expect(want);
            assert!(why.to_string().contains(want) && !why.fix().is_empty(), "{why}");
            assert_eq!(f.is_ours(), matches!(why, FrameMismatch::Device(_)));
        }
        // neither a force nor what a device says of itself can be of no degree of freedom
        assert!(!ForceFrame::new("key", 0).is_ours() && ForceFrame::new("key", 1).is_ours());
        assert!(!About::new("key", 1000, 0).is_ours() && About::new("key", 1000, 32).is_ours());
    }
}
