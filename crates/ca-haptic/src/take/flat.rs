//! Records of a take that are flat: what happens beside frames.
//!
//! Decides that they are made like frames (`frame/`): a structure without padding whose ROS 2 definition stands beside
//! it, so that bytes in the file, row in NumPy and structure in memory are one. A macro writes both from one list of
//! fields and types, so they cannot differ; a structure with padding does not compile.

use crate::engine::{GLIDE, Touched};
use ca_core::Balance;
use zerocopy::{FromBytes, Immutable, IntoBytes, KnownLayout};

/// The word of ROS 2 for a type.
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
            /// The definition of this record as a ROS 2 message.
            pub const SCHEMA: &'static str = concat!($(ros!($rust), " ", stringify!($field), "\n"),*);
        }
    };
}

flat! {
    /// Forces were armed, disarmed or tripped.
    Ordered {
        /// sound sample before which it took effect
        tick: u64,
        /// number of the device; [`Ordered::ALL`] for all
        port: u32,
        /// 0 arm, 1 disarm, 2 trip
        order: u32,
        /// of a trip, a [`Cause`](crate::frame::Cause)
        cause: u32,
        /// 0
        reserved: u32,
    }
}

impl Ordered {
    /// Number that stands for all devices.
    pub const ALL: u32 = u32::MAX;
}

flat! {
    /// A hand without a device did something.
    Hand {
        /// sound sample before which it took effect
        tick: u64,
        /// where a mass is pulled to, from rest \[m\]; of a port, x is its position \[m\] or force \[N\], y the time
        /// it takes \[s\]
        x: f64,
        /// as `x`
        y: f64,
        /// as `x`
        z: f64,
        /// 0 grab, 1 pull, 2 release, 3 own gesture, 4 its end, 5 port that takes the time of a slider, 6 port
        act: u32,
        /// number of the MAT, or index of the port into [`State::input`](ca_core::State::input)
        which: u32,
    }
}

impl Hand {
    /// What was done at a tick.
    pub fn new(tick: u64, touched: Touched) -> Hand {
        let hand = |act, which, [x, y, z]: [f64; 3]| Hand { tick, x, y, z, act, which };
        match touched {
            Touched::Grab(mass) => hand(0, mass, [0.0; 3]),
            Touched::Pull(to) => hand(1, 0, to),
            Touched::Release => hand(2, 0, [0.0; 3]),
            Touched::Play => hand(3, 0, [0.0; 3]),
            Touched::Stop => hand(4, 0, [0.0; 3]),
            Touched::Port(port, value, over) => hand(6, port, [value, over, 0.0]),
        }
    }

    /// What was done; `None` where it is nothing that is known.
    pub fn touched(&self) -> Option<Touched> {
        Some(match self.act {
            0 => Touched::Grab(self.which),
            1 => Touched::Pull([self.x, self.y, self.z]),
            2 => Touched::Release,
            3 => Touched::Play,
            4 => Touched::Stop,
            5 => Touched::Port(self.which, self.x, GLIDE),
            6 => Touched::Port(self.which, self.x, self.y),
            _ => return None,
        })
    }
}

flat! {
    /// The scene was put back to its state at load.
    Reloaded {
        /// sound sample before which it took effect
        tick: u64,
        /// [`ca_core::State::bits`] of the state that was given up
        bits: u64,
        /// its places of MATs; others than those of the scene where the reload was refused
        places: u32,
        /// its coefficients
        coefs: u32,
    }
}

flat! {
    /// A hash of the state.
    Hashed {
        /// the next sound sample
        tick: u64,
        /// [`ca_core::State::bits`]
        bits: u64,
    }
}

flat! {
    /// The energy ledger.
    Energy {
        /// the next sound sample
        tick: u64,
        /// energy at load \[J\]
        h0: f64,
        /// energy now \[J\]
        h: f64,
        /// heat \[J\]
        lost: f64,
        /// error of the scheme in non-linear links \[J\]
        source: f64,
        /// received from ports \[J\]
        work: f64,
        /// received by changes \[J\]
        changed: f64,
        /// residual, what the ledger does not explain \[J\]
        residual: f64,
        /// scale of the residual \[J\]
        peak: f64,
    }
}

impl Energy {
    /// The ledger at a tick.
    pub fn new(tick: u64, b: &Balance) -> Energy {
        let Balance { h0, h, lost, scheme_error, work, changed, residual, peak, received: _ } = *b;
        Energy { tick, h0, h, lost, source: scheme_error, work, changed, residual, peak }
    }
}

flat! {
    /// What found no room on its way to the take, since the last of these records.
    Lost {
        /// sound sample of the last record before
        tick: u64,
        /// frames and events
        records: u64,
        /// sound samples, of all channels
        samples: u64,
        /// views
        views: u64,
    }
}

flat! {
    /// How the real-time thread does, once a second. Counts are since the start.
    Rt {
        /// the next sound sample
        tick: u64,
        /// gesture frames done
        frames: u64,
        /// gesture frames that began later than the one after was due
        missed: u64,
        /// gesture frames without news of a device that was there
        stale: u64,
        /// device frames dropped by the input checks
        dropped: u64,
        /// faults that latched
        faults: u64,
        /// sound samples that hit the peak limit
        clipped: u64,
        /// time from when a frame was due to when it began, median of the last second \[µs\]
        late_p50: f64,
        /// the same, 99th percentile \[µs\]
        late_p99: f64,
        /// the same, largest \[µs\]
        late_max: f64,
        /// part of the last second spent computing
        busy: f64,
        /// times the device that plays the sound had nothing to play, or said so
        underruns: u64,
        /// its rate against the monotonic clock \[ppm\]
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
