//! What a device says of itself, once a second: a process that comes later learns it without asking.

use super::{DOF, FrameMismatch, VERSION, fnv};
#[cfg(feature = "iceoryx")]
use iceoryx2::prelude::ZeroCopySend;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// The capabilities of a device, 904 bytes. Texts are UTF-8 with zeros after them.
#[derive(Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[cfg_attr(feature = "iceoryx", derive(ZeroCopySend), type_name("ca.v1.About"))]
#[repr(C)]
pub struct About {
    /// [`About::MAGIC`]
    pub magic: u32,
    /// [`VERSION`]
    pub version: u32,
    /// [`About::LAYOUT`]
    pub layout: u64,
    /// name of the device
    pub device: [u8; 16],
    /// as in its frames
    pub session: u64,
    /// as in its frames
    pub calibration: u64,
    /// make and model
    pub model: [u8; 32],
    /// serial number
    pub serial: [u8; 32],
    /// firmware
    pub firmware: [u8; 16],
    /// frames a second
    pub rate: u32,
    /// degrees of freedom
    pub n: u16,
    /// how many neighbouring DOF make one force vector: 1 for keys, 3 for a stylus
    pub axes: u16,
    /// least position \[m\]
    pub low: [f32; DOF],
    /// largest position \[m\]
    pub high: [f32; DOF],
    /// largest force \[N\]
    pub force: [f32; DOF],
    /// largest force for ever \[N\]
    pub continuous: [f32; DOF],
    /// largest stiffness it renders \[N/m\]; 0 where not known
    pub stiffness: [f32; DOF],
    /// largest viscosity it renders \[N s/m\]; 0 where not known
    pub damping: [f32; DOF],
}

impl About {
    /// "caAB"
    pub const MAGIC: u32 = u32::from_le_bytes(*b"caAB");
    /// The definition of this record as a ROS 2 message.
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
    /// Hash of that text.
    pub const LAYOUT: u64 = fnv(Self::SCHEMA.as_bytes());

    /// Of a device of `n` keys that says nothing more of itself than `rate` frames a second.
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

    /// True where magic, version and layout are those of this build, and it has 1 to [`DOF`] degrees of freedom.
    pub fn is_ours(&self) -> bool {
        self.wrong().is_none()
    }

    /// What is wrong with its head.
    fn wrong(&self) -> Option<FrameMismatch> {
        FrameMismatch::find([self.magic, Self::MAGIC], [self.layout, Self::LAYOUT], self.version, self.n)
    }
}

/// A text of fixed length as people read it.
pub fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}
