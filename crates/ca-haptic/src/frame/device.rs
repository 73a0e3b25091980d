//! Frame from a device: the position of the hand.

use super::{DOF, FrameMismatch, VERSION, fnv};
#[cfg(feature = "iceoryx")]
use iceoryx2::prelude::ZeroCopySend;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// Bits of [`DeviceFrame::status`].
pub mod status {
    /// The process reaches its hardware.
    pub const CONNECTED: u32 = 1;
    /// Its motors have power.
    pub const POWERED: u32 = 2;
    /// Positions are metres, forces newtons.
    pub const CALIBRATED: u32 = 4;
    /// The device is held.
    pub const IN_USE: u32 = 8;
    /// The dead man's switch exists and is released.
    pub const DEADMAN: u32 = 16;
    /// The motors are shorted.
    pub const BRAKE: u32 = 32;
    /// The motors are warm.
    pub const THERMAL: u32 = 64;
    /// The position is at the end of the travel.
    pub const EDGE: u32 = 128;
    /// There is no hardware: a simulation.
    pub const SIMULATED: u32 = 256;
}

/// One frame of a device, 792 bytes.
#[derive(Clone, Copy, Debug, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable)]
#[cfg_attr(feature = "iceoryx", derive(ZeroCopySend), type_name("ca.v1.DeviceFrame"))]
#[repr(C)]
pub struct DeviceFrame {
    /// [`DeviceFrame::MAGIC`].
    pub magic: u32,
    /// [`VERSION`].
    pub version: u32,
    /// [`DeviceFrame::LAYOUT`].
    pub layout: u64,
    /// Name of the device, padded with zeros.
    pub device: [u8; 16],
    /// Number that changes whenever the device process starts.
    pub session: u64,
    /// Number of the frame in its session, from 1.
    pub seq: u64,
    /// `seq` of the force frame that the motors held while the hand came to this position; 0 if not known.
    pub ack: u64,
    /// Clock of the device \[ns\].
    pub t_device_ns: u64,
    /// `CLOCK_MONOTONIC` when published \[ns\].
    pub t_host_ns: u64,
    /// Id of the calibration of the positions; 0 for none.
    pub calibration: u64,
    /// Sound sample at which the engine used it; 0 on the wire.
    pub tick: u64,
    /// Time between frames \[ns\].
    pub period_ns: u32,
    /// Bits of [`status`].
    pub status: u32,
    /// Reason why the device itself gives no force, a [`Cause`](super::Cause).
    pub cause: u16,
    /// Degrees of freedom in use, at most [`DOF`].
    pub n: u16,
    /// Valid positions, a bit each.
    pub mask: u32,
    /// Measured velocities, a bit each.
    pub vel_mask: u32,
    /// Buttons, a bit each.
    pub buttons: u32,
    /// Positions \[m\].
    pub pos: [f64; DOF],
    /// Velocities \[m/s\], where measured.
    pub vel: [f64; DOF],
    /// Forces measured \[N\]; 0 where not.
    pub force_measured: [f32; DOF],
    /// Orientation; zeros if there is none.
    pub quat: [f32; 4],
    /// Pressure, grip and the like.
    pub aux: [f32; 4],
    /// Temperature of the motors \[°C\]; 0 if not measured.
    pub temperature: f32,
    /// Always 0.
    pub reserved: u32,
}

impl DeviceFrame {
    /// The bytes "caDF".
    pub const MAGIC: u32 = u32::from_le_bytes(*b"caDF");
    /// ROS 2 message definition of this frame.
    pub const SCHEMA: &'static str = "\
uint32 magic
uint32 version
uint64 layout
uint8[16] device
uint64 session
uint64 seq
uint64 ack
uint64 t_device_ns
uint64 t_host_ns
uint64 calibration
uint64 tick
uint32 period_ns
uint32 status
uint16 cause
uint16 n
uint32 mask
uint32 vel_mask
uint32 buttons
float64[32] pos
float64[32] vel
float32[32] force_measured
float32[4] quat
float32[4] aux
float32 temperature
uint32 reserved
";
    /// Hash of [`DeviceFrame::SCHEMA`].
    pub const LAYOUT: u64 = fnv(Self::SCHEMA.as_bytes());

    /// Makes a frame of a device with `n` degrees of freedom at rest, connected, powered and calibrated.
    pub fn new(name: &str, n: usize) -> DeviceFrame {
        let n = n.min(DOF);
        DeviceFrame {
            magic: Self::MAGIC,
            version: VERSION,
            layout: Self::LAYOUT,
            device: super::uid(name),
            session: 0,
            seq: 0,
            ack: 0,
            t_device_ns: 0,
            t_host_ns: 0,
            calibration: 0,
            tick: 0,
            period_ns: 0,
            status: status::CONNECTED | status::POWERED | status::CALIBRATED,
            cause: 0,
            n: n as u16,
            mask: if n == DOF { u32::MAX } else { (1 << n) - 1 },
            vel_mask: 0,
            buttons: 0,
            pos: [0.0; DOF],
            vel: [0.0; DOF],
            force_measured: [0.0; DOF],
            quat: [0.0; 4],
            aux: [0.0; 4],
            temperature: 0.0,
            reserved: 0,
        }
    }

    /// Returns true if magic, version and layout match this build, and it has 1 to [`DOF`] degrees of freedom.
    pub fn has_this_layout(&self) -> bool {
        self.wrong().is_none()
    }

    /// Returns why it does not match this build or the device with this uid, if so.
    pub fn mismatch(&self, device: [u8; 16]) -> Option<FrameMismatch> {
        self.wrong().or_else(|| FrameMismatch::other(self.device, device))
    }

    fn wrong(&self) -> Option<FrameMismatch> {
        FrameMismatch::find([self.magic, Self::MAGIC], [self.layout, Self::LAYOUT], self.version, self.n)
    }
}
