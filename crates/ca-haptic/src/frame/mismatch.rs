//! Reasons why a frame does not match this build or device.
//!
//! The first mismatch is reported, in the order in which a reader must trust a header: magic, version, layout, size,
//! device. A modified layout is therefore not reported as another version.

use super::{DOF, VERSION, text};
use std::fmt;

/// Mismatch in the header of a frame.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum FrameMismatch {
    /// The magic number is another one.
    Magic(u32),
    /// The version is another one.
    Version(u32),
    /// The hash of the definition is another one: fields were added, removed or moved.
    Layout(u64),
    /// The number of degrees of freedom is 0 or more than [`DOF`].
    Size(u16),
    /// The frame is for this other device.
    Device(String),
}

impl FrameMismatch {
    /// Returns the first mismatch; `magic` and `layout` hold the actual and the expected value.
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

    pub(super) fn other(device: [u8; 16], wanted: [u8; 16]) -> Option<FrameMismatch> {
        (device != wanted).then(|| FrameMismatch::Device(text(&device)))
    }
}

impl FrameMismatch {
    /// Returns how to fix it.
    pub fn fix(&self) -> &'static str {
        match self {
            FrameMismatch::Magic(_) | FrameMismatch::Version(_) | FrameMismatch::Layout(_) => {
                "build the device process with this release of ca"
            }
            FrameMismatch::Size(_) => "set `n` of its frames to its degrees of freedom",
            FrameMismatch::Device(_) => "write the name of the device into its frames",
        }
    }
}

impl fmt::Display for FrameMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FrameMismatch::Magic(m) => write!(f, "begin with {m:08x} instead of the magic number"),
            FrameMismatch::Version(v) => write!(f, "are of version {v} instead of {VERSION}"),
            FrameMismatch::Layout(l) => write!(f, "are of version {VERSION} but of another layout ({l:016x})"),
            FrameMismatch::Size(n) => write!(f, "have {n} degrees of freedom instead of 1 to {DOF}"),
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
            ("instead of the magic number", |f| f.magic = About::MAGIC),
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
            assert_eq!(f.has_this_layout(), matches!(why, FrameMismatch::Device(_)));
        }
        // force frames and descriptions need a degree of freedom too
        assert!(!ForceFrame::new("key", 0).has_this_layout() && ForceFrame::new("key", 1).has_this_layout());
        assert!(!About::new("key", 1000, 0).has_this_layout() && About::new("key", 1000, 32).has_this_layout());
    }
}
