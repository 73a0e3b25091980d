//! Frame from the engine: the force on the hand.

use super::{Cause, DOF, FrameMismatch, Mode, VERSION, fnv};
#[cfg(feature = "iceoryx")]
use iceoryx2::prelude::ZeroCopySend;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Bits of [`ForceFrame::flags`]: effects of the guard on this frame.
pub mod flag {
    /// Cut to the largest force.
    pub const SATURATED: u32 = 1;
    /// Limited in its rate of change.
    pub const SLEWED: u32 = 2;
    /// A viscosity was added, to dissipate energy that the rate boundary made.
    pub const PASSIVITY: u32 = 4;
    /// Weakened because it oscillated.
    pub const OSCILLATION: u32 = 8;
    /// Weakened to spare the motors.
    pub const THERMAL: u32 = 16;
    /// The hand is in the soft edge of its travel.
    pub const EDGE: u32 = 32;
    /// Computed from positions that are not fresh.
    pub const STALE: u32 = 64;
    /// Armed, and waiting until nothing pushes.
    pub const WAIT_CLEAR: u32 = 128;
    /// The injection of the passivity stage gave energy to the hand, and is off for a while.
    pub const PASSIVITY_OFF: u32 = 256;
    /// A key feels softer than in the model, because the device cannot render it.
    pub const COUPLED: u32 = 512;
}

/// One frame of forces, 240 bytes.
#[derive(Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[cfg_attr(feature = "iceoryx", derive(ZeroCopySend), type_name("ca.v1.ForceFrame"))]
#[repr(C)]
pub struct ForceFrame {
    /// [`ForceFrame::MAGIC`].
    pub magic: u32,
    /// [`VERSION`].
    pub version: u32,
    /// [`ForceFrame::LAYOUT`].
    pub layout: u64,
    /// Name of the device, padded with zeros.
    pub device: [u8; 16],
    /// Number that changes whenever the engine starts.
    pub session: u64,
    /// Number of the force frame in its session, from 1.
    pub seq: u64,
    /// Session of the device whose frame was used.
    pub ack_session: u64,
    /// `seq` of the device frame that was used; 0 before any.
    pub ack: u64,
    /// `CLOCK_MONOTONIC` when published \[ns\].
    pub t_host_ns: u64,
    /// Sound sample at which it was computed.
    pub tick: u64,
    /// Id of the calibration applied; 0 for none.
    pub calibration: u64,
    /// Time after which the device ends the force if no other frame came \[µs\].
    pub ttl_us: u32,
    /// A [`Mode`].
    pub mode: u32,
    /// A [`Cause`].
    pub cause: u16,
    /// Degrees of freedom in use.
    pub n: u16,
    /// Bits of [`flag`].
    pub flags: u32,
    /// Largest viscosity that the passivity stage added to any DOF \[N s/m\].
    pub inject: f32,
    /// Always 0.
    pub reserved: u32,
    /// Forces on the hand \[N\].
    pub force: [f32; DOF],
}

impl ForceFrame {
    /// The bytes "caFF".
    pub const MAGIC: u32 = u32::from_le_bytes(*b"caFF");
    /// ROS 2 message definition of this frame.
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
    /// Hash of [`ForceFrame::SCHEMA`].
    pub const LAYOUT: u64 = fnv(Self::SCHEMA.as_bytes());

    /// Makes a frame without force for a device with `n` degrees of freedom.
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

    /// Returns true if magic, version and layout match this build, and it has 1 to [`DOF`] degrees of freedom.
    pub fn has_this_layout(&self) -> bool {
        self.wrong().is_none()
    }

    fn wrong(&self) -> Option<FrameMismatch> {
        FrameMismatch::find([self.magic, Self::MAGIC], [self.layout, Self::LAYOUT], self.version, self.n)
    }
}
