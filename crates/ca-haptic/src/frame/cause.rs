//! Why forces are off, and how they are sent.

use serde::{Deserialize, Serialize};

/// Why the force is off (H14); a superset of what DHD reports. Numbers are those on the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
#[repr(u16)]
pub enum Cause {
    /// forces are on, or on their way
    #[default]
    None = 0,
    /// nobody has armed the device yet, or it was disarmed
    Disarmed = 1,
    /// a button of the device
    Button = 2,
    /// the dead man's switch was released
    Deadman = 3,
    /// faster than the device may move
    Velocity = 4,
    /// frames of the device stayed away
    WatchdogIn = 5,
    /// forces of the engine stayed away, as the device saw it
    WatchdogOut = 6,
    /// the model gave a force that is not finite
    Nonfinite = 7,
    /// too many frames that cannot be true
    Implausible = 8,
    /// too much force for too long
    Thermal = 9,
    /// the device went away
    Disconnect = 10,
    /// a program asked for it
    Software = 11,
    /// the model diverged
    ModelUnstable = 12,
}

/// All causes, in the order of their numbers.
pub const CAUSES: [Cause; 13] = [
    Cause::None,
    Cause::Disarmed,
    Cause::Button,
    Cause::Deadman,
    Cause::Velocity,
    Cause::WatchdogIn,
    Cause::WatchdogOut,
    Cause::Nonfinite,
    Cause::Implausible,
    Cause::Thermal,
    Cause::Disconnect,
    Cause::Software,
    Cause::ModelUnstable,
];

impl Cause {
    /// From the wire; what has no name is [`Cause::Software`].
    pub fn read(n: u16) -> Cause {
        CAUSES.get(usize::from(n)).copied().unwrap_or(Cause::Software)
    }

    /// Its name as people read it, e.g. `WATCHDOG_IN`.
    pub fn name(self) -> &'static str {
        [
            "NONE",
            "DISARMED",
            "BUTTON",
            "DEADMAN",
            "VELOCITY",
            "WATCHDOG_IN",
            "WATCHDOG_OUT",
            "NONFINITE",
            "IMPLAUSIBLE",
            "THERMAL",
            "DISCONNECT",
            "SOFTWARE",
            "MODEL_UNSTABLE",
        ][self as usize]
    }
}

/// What the force of a frame is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Mode {
    /// zero: disarmed, or waiting until the hand is clear of everything
    #[default]
    Off = 0,
    /// fading in
    Ramp = 1,
    /// as the model says, within limits
    On = 2,
    /// braking
    Damp = 3,
    /// zero until somebody arms again
    Fault = 4,
}

impl Mode {
    /// From the wire; what has no name is a fault.
    pub fn read(n: u32) -> Mode {
        [Mode::Off, Mode::Ramp, Mode::On, Mode::Damp].get(n as usize).copied().unwrap_or(Mode::Fault)
    }

    /// Its name as people read it.
    pub fn name(self) -> &'static str {
        ["off", "ramp", "on", "damp", "fault"][self as usize]
    }
}
