//! Causes for forces being off, and modes of a force.

use serde::{Deserialize, Serialize};

/// Reason why the force is off (H14); a superset of the DHD causes. Values are those on the wire.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
#[repr(u16)]
pub enum Cause {
    /// Forces are on, or about to begin.
    #[default]
    None = 0,
    /// The device is not armed yet, or was disarmed.
    Disarmed = 1,
    /// A button of the device was pressed.
    Button = 2,
    /// The dead man's switch was released.
    Deadman = 3,
    /// The device moved too fast.
    Velocity = 4,
    /// No frames came from the device.
    WatchdogIn = 5,
    /// No forces came from the engine, according to the device.
    WatchdogOut = 6,
    /// The model gave a force that is not finite.
    Nonfinite = 7,
    /// Too many frames were impossible.
    Implausible = 8,
    /// The force was too large for too long.
    Thermal = 9,
    /// The device was lost.
    Disconnect = 10,
    /// A program asked for it.
    Software = 11,
    /// The model diverged.
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
    /// Reads a cause from the wire; an unknown number is [`Cause::Software`].
    pub fn read(n: u16) -> Cause {
        CAUSES.get(usize::from(n)).copied().unwrap_or(Cause::Software)
    }

    /// Returns its name, e.g. `WATCHDOG_IN`.
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

/// Mode of the force in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[repr(u32)]
pub enum Mode {
    /// Zero: disarmed, or waiting until nothing pushes.
    #[default]
    Off = 0,
    /// Fading in.
    Ramp = 1,
    /// The force of the model, within limits.
    On = 2,
    /// Braking.
    Damp = 3,
    /// Zero until the device is armed again.
    Fault = 4,
}

impl Mode {
    /// Reads a mode from the wire; an unknown number is a fault.
    pub fn read(n: u32) -> Mode {
        [Mode::Off, Mode::Ramp, Mode::On, Mode::Damp].get(n as usize).copied().unwrap_or(Mode::Fault)
    }

    /// Returns its name.
    pub fn name(self) -> &'static str {
        ["off", "ramp", "on", "damp", "fault"][self as usize]
    }
}
