//! Self-description of a device, sent once a second so that a process that starts later receives it without asking.

use super::{DOF, FrameMismatch, VERSION, fnv};
#[cfg(feature = "iceoryx")]
use iceoryx2::prelude::ZeroCopySend;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Capabilities of a device, 904 bytes. Texts are UTF-8, padded with zeros.
#[derive(Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[cfg_attr(feature = "iceoryx", derive(ZeroCopySend), type_name("ca.v1.About"))]
#[repr(C)]
pub struct About {
    /// [`About::MAGIC`].
    pub magic: u32,
    /// [`VERSION`].
    pub version: u32,
    /// [`About::LAYOUT`].
    pub layout: u64,
    /// Name of the device.
    pub device: [u8; 16],
    /// Session, as in its frames.
    pub session: u64,
    /// Calibration, as in its frames.
    pub calibration: u64,
    /// Make and model.
    pub model: [u8; 32],
    /// Serial number.
    pub serial: [u8; 32],
    /// Firmware version.
    pub firmware: [u8; 16],
    /// Frames a second.
    pub rate: u32,
    /// Degrees of freedom.
    pub n: u16,
    /// Number of neighbouring DOF in one force vector: 1 for keys, 3 for a stylus.
    pub axes: u16,
    /// Least position \[m\].
    pub low: [f32; DOF],
    /// Largest position \[m\].
    pub high: [f32; DOF],
    /// Largest force \[N\].
    pub force: [f32; DOF],
    /// Largest continuous force \[N\].
    pub continuous: [f32; DOF],
    /// Largest stiffness that it renders \[N/m\]; 0 if not known.
    pub stiffness: [f32; DOF],
    /// Largest viscosity that it renders \[N s/m\]; 0 if not known.
    pub damping: [f32; DOF],
}

impl About {
    /// The bytes "caAB".
    pub const MAGIC: u32 = u32::from_le_bytes(*b"caAB");
    /// ROS 2 message definition of this record.
    pub const SCHEMA: &'static str = "\
uint32 magic
uint32 version
uint64 layout
uint8[16] device
uint64 session
uint64 calibration
uint8[32] model
uint8[32] serial
uint8[16] firmware
uint32 rate
uint16 n
uint16 axes
float32[32] low
float32[32] high
float32[32] force
float32[32] continuous
float32[32] stiffness
float32[32] damping
";
    /// Hash of [`About::SCHEMA`].
    pub const LAYOUT: u64 = fnv(Self::SCHEMA.as_bytes());

    /// Makes a description with `n` keys, `rate` frames a second, and nothing else known.
    pub fn new(name: &str, rate: u32, n: usize) -> About {
        About {
            magic: Self::MAGIC,
            version: VERSION,
            layout: Self::LAYOUT,
            device: super::uid(name),
            session: 0,
            calibration: 0,
            model: [0; 32],
            serial: [0; 32],
            firmware: [0; 16],
            rate,
            n: n.min(DOF) as u16,
            axes: 1,
            low: [0.0; DOF],
            high: [0.0; DOF],
            force: [0.0; DOF],
            continuous: [0.0; DOF],
            stiffness: [0.0; DOF],
            damping: [0.0; DOF],
        }
    }

    /// Returns true if magic, version and layout match this build, and it has 1 to [`DOF`] degrees of freedom.
    pub fn has_this_layout(&self) -> bool {
        self.wrong().is_none()
    }

    fn wrong(&self) -> Option<FrameMismatch> {
        FrameMismatch::find([self.magic, Self::MAGIC], [self.layout, Self::LAYOUT], self.version, self.n)
    }
}

/// Decodes a text of fixed length, up to its first zero.
pub fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}
