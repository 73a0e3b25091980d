//! What the engine says: the force on the hand.

use super::{Cause, DOF, FrameMismatch, Mode, VERSION, fnv};
#[cfg(feature = "iceoryx")]
use iceoryx2::prelude::ZeroCopySend;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Bits of [`ForceFrame::flags`]: what the guard did to this frame.
pub mod flag {
    /// cut to the largest force
    pub const SATURATED: u32 = 1;
    /// slowed down
    pub const SLEWED: u32 = 2;
    /// a viscosity was added to take out energy that the rate boundary made
    pub const PASSIVITY: u32 = 4;
    /// weakened because it oscillated
    pub const OSCILLATION: u32 = 8;
    /// weakened to spare the motors
    pub const THERMAL: u32 = 16;
    /// the hand is in the soft edge of its travel
    pub const EDGE: u32 = 32;
    /// made from positions that are not fresh
    pub const STALE: u32 = 64;
    /// armed, and waiting until nothing pushes
    pub const WAIT_CLEAR: u32 = 128;
    /// the injection of the passivity stage gave energy to the hand, and is off for a while
    pub const PASSIVITY_OFF: u32 = 256;
    /// a key of the device is felt softer than it is in the model, since the device cannot render it
    pub const COUPLED: u32 = 512;
}

/// One frame of forces, 240 bytes.
#[derive(Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[cfg_attr(feature = "iceoryx", derive(ZeroCopySend), type_name("ca.v1.ForceFrame"))]
#[repr(C)]
pub struct ForceFrame {
    /// [`ForceFrame::MAGIC`]
    pub magic: u32,
    /// [`VERSION`]
    pub version: u32,
    /// [`ForceFrame::LAYOUT`]
    pub layout: u64,
    /// name of the device it is for, zeros after it
    pub device: [u8; 16],
    /// a number that changes whenever the engine starts
    pub session: u64,
    /// counts force frames of a session, from 1
    pub seq: u64,
    /// session of the device whose frame was used
    pub ack_session: u64,
    /// `seq` of the device frame that was used; 0 before any
    pub ack: u64,
    /// `CLOCK_MONOTONIC` when published \[ns\]
    pub t_host_ns: u64,
    /// sound sample at which it was known
    pub tick: u64,
    /// id of the calibration it was made with; 0 for none
    pub calibration: u64,
    /// after this time without another frame the device gives no force \[µs\]
    pub ttl_us: u32,
    /// a [`Mode`]
    pub mode: u32,
    /// a [`Cause`]
    pub cause: u16,
    /// degrees of freedom in use
    pub n: u16,
    /// bits of [`flag`]
    pub flags: u32,
    /// viscosity that the passivity stage added, the largest of all DOF \[N s/m\]
    pub inject: f32,
    /// 0
    pub reserved: u32,
    /// forces on the hand \[N\]
    pub force: [f32; DOF],
}

impl ForceFrame {
    /// "caFF"
    pub const MAGIC: u32 = u32::from_le_bytes(*b"caFF");
    /// The definition of this frame as a ROS 2 message.
    pub const SCHEMA: &'static str = "\
uint32 magic
uint32 version
uint64 layout
uint8[16] device
uint64 session
uint64 seq
uint64 ack_session
uint64 ack
uint64 t_host_ns
uint64 tick
uint64 calibration
uint32 ttl_us
uint32 mode
uint16 cause
uint16 n
uint32 flags
float32 inject
uint32 reserved
float32[32] force
";
    /// Hash of that text.
    pub const LAYOUT: u64 = fnv(Self::SCHEMA.as_bytes());

    /// A frame of no force for a device with `n` degrees of freedom.
    pub fn new(name: &str, n: usize) -> ForceFrame {
        ForceFrame {
            magic: Self::MAGIC,
            version: VERSION,
            layout: Self::LAYOUT,
            device: super::uid(name),
            session: 0,
            seq: 0,
            ack_session: 0,
            ack: 0,
            t_host_ns: 0,
            tick: 0,
            calibration: 0,
            ttl_us: 0,
            mode: Mode::Off as u32,
            cause: Cause::Disarmed as u16,
            n: n.min(DOF) as u16,
            flags: 0,
            inject: 0.0,
            reserved: 0,
            force: [0.0; DOF],
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
