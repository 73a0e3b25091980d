//! Flat records of a take, for everything except frames.
//!
//! They are made like frames (`frame/`): structures without padding with a ROS 2 definition, so that the bytes in the
//! file, the row in NumPy and the structure in memory are the same. A macro generates structure and definition from one
//! list of fields, so that they cannot differ; a structure with padding does not compile.

use crate::engine::{GLIDE, ManualEvent};
use ca_core::Balance;
use ca_core::internal::state::FINGERS;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// ROS 2 name of a type.
macro_rules! ros {
    (u32) => {
        "uint32"
    };
    (u64) => {
        "uint64"
    };
    (f64) => {
        "float64"
    };
}

macro_rules! flat {
    ($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $rust:tt),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, FromBytes, IntoBytes, KnownLayout, Immutable)]
        #[repr(C)]
        pub struct $name {
            $($(#[$field_doc])* pub $field: $rust,)*
        }

        impl $name {
            /// ROS 2 message definition of this record.
            pub const SCHEMA: &'static str = concat!($(ros!($rust), " ", stringify!($field), "\n"),*);
        }
    };
}

flat! {
    /// Forces were armed, disarmed or tripped.
    Ordered {
        /// Sound sample before which it took effect.
        tick: u64,
        /// Number of the device; [`Ordered::ALL`] for all.
        port: u32,
        /// 0 arm, 1 disarm, 2 trip.
        order: u32,
        /// [`Cause`](crate::frame::Cause) of a trip.
        cause: u32,
        /// Always 0.
        reserved: u32,
    }
}

impl Ordered {
    /// Number that stands for all devices.
    pub const ALL: u32 = u32::MAX;
}

flat! {
    /// Input without a device acted on the scene.
    Hand {
        /// Sound sample before which it took effect.
        tick: u64,
        /// Displacement of a pulled mass from rest \[m\]. For a port, position \[m\] or force \[N\] in x, duration
        /// \[s\] in y.
        x: f64,
        /// As `x`.
        y: f64,
        /// As `x`.
        z: f64,
        /// 0 grab, 1 pull, 2 release, 3 own gesture, 4 its end, 5 port with the duration of a slider, 6 port.
        act: u32,
        /// Number of the MAT of a grab, whose finger is `x`; finger of a pull or a release; or index of the port into [`State::input`](ca_core::State::input).
        which: u32,
    }
}

impl Hand {
    /// Makes the record of an action at a tick.
    pub fn new(tick: u64, event: ManualEvent) -> Hand {
        let hand = |act, which, [x, y, z]: [f64; 3]| Hand { tick, x, y, z, act, which };
        match event {
            ManualEvent::Grab(finger, mass) => hand(0, mass, [f64::from(finger), 0.0, 0.0]),
            ManualEvent::Pull(finger, to) => hand(1, finger.into(), to),
            ManualEvent::Release(finger) => hand(2, finger.into(), [0.0; 3]),
            ManualEvent::Play => hand(3, 0, [0.0; 3]),
            ManualEvent::Stop => hand(4, 0, [0.0; 3]),
            ManualEvent::Port(port, value, over) => hand(6, port, [value, over, 0.0]),
        }
    }

    /// Returns the action; `None` if it is unknown.
    pub fn event(&self) -> Option<ManualEvent> {
        let finger = |n: f64| (0.0..FINGERS as f64).contains(&n).then_some(n as u8);
        Some(match self.act {
            0 => ManualEvent::Grab(finger(self.x)?, self.which),
            1 => ManualEvent::Pull(finger(self.which.into())?, [self.x, self.y, self.z]),
            2 => ManualEvent::Release(finger(self.which.into())?),
            3 => ManualEvent::Play,
            4 => ManualEvent::Stop,
            5 => ManualEvent::Port(self.which, self.x, GLIDE),
            6 => ManualEvent::Port(self.which, self.x, self.y),
            _ => return None,
        })
    }
}

flat! {
    /// The scene was reset to its state at load.
    Reloaded {
        /// Sound sample before which it took effect.
        tick: u64,
        /// [`ca_core::State::bits`] of the state before.
        bits: u64,
        /// Number of its places of MATs; differs from the scene if the reload was refused.
        places: u32,
        /// Number of its coefficients.
        coefs: u32,
    }
}

flat! {
    /// A hash of the state.
    Hashed {
        /// The next sound sample.
        tick: u64,
        /// [`ca_core::State::bits`].
        bits: u64,
    }
}

flat! {
    /// The energy ledger.
    Energy {
        /// The next sound sample.
        tick: u64,
        /// Energy at load \[J\].
        h0: f64,
        /// Energy now \[J\].
        h: f64,
        /// Heat \[J\].
        lost: f64,
        /// Error of the scheme in non-linear links \[J\].
        source: f64,
        /// Energy received from ports \[J\].
        work: f64,
        /// Energy received by changes \[J\].
        changed: f64,
        /// Residual, which the ledger does not explain \[J\].
        residual: f64,
        /// Scale of the residual \[J\].
        peak: f64,
    }
}

impl Energy {
    /// Makes the record of the ledger at a tick.
    pub fn new(tick: u64, b: &Balance) -> Energy {
        let Balance { h0, h, lost, scheme_error, work, changed, residual, peak, received: _, strayed: _ } = *b;
        Energy { tick, h0, h, lost, source: scheme_error, work, changed, residual, peak }
    }
}

flat! {
    /// Data that did not fit on its way to the take, since the last such record.
    Lost {
        /// Sound sample of the last record before.
        tick: u64,
        /// Frames and events.
        records: u64,
        /// Sound samples of all channels.
        samples: u64,
        /// Views.
        views: u64,
    }
}

flat! {
    /// State of the real-time thread, once a second. Counts are since the start.
    Rt {
        /// The next sound sample.
        tick: u64,
        /// Completed gesture frames.
        frames: u64,
        /// Gesture frames that began after the next one was due.
        missed: u64,
        /// Gesture frames without news of a connected device.
        stale: u64,
        /// Device frames dropped by the input checks.
        dropped: u64,
        /// Faults that latched.
        faults: u64,
        /// Sound samples that hit the peak limit.
        clipped: u64,
        /// Delay from the due time of a frame to its start, median of the last second \[µs\].
        late_p50: f64,
        /// 99th percentile of the same \[µs\].
        late_p99: f64,
        /// Maximum of the same \[µs\].
        late_max: f64,
        /// Part of the last second spent computing.
        busy: f64,
        /// Times that the sound device had nothing to play, or reported so.
        underruns: u64,
        /// Rate of the sound device against the monotonic clock \[ppm\].
        audio_ppm: f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_names_every_field_in_order() {
        assert_eq!(Hashed::SCHEMA, "uint64 tick\nuint64 bits\n");
        assert_eq!(Ordered::SCHEMA, "uint64 tick\nuint32 port\nuint32 order\nuint32 cause\nuint32 reserved\n");
        assert!(Rt::SCHEMA.ends_with("float64 audio_ppm\n"));
    }
}
