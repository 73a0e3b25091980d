//! What a running engine leaves behind for those who write it down.
//!
//! Decides that the real-time thread hands over plain values through a ring and never waits: a record that finds no room
//! is counted and gone. Boxes travel the same way, so that they are freed where freeing is allowed.

use crate::engine::{OwnGesture, Retired, Swap, Touched};
use crate::frame::{DeviceFrame, ForceFrame};
use crate::guard::Order;
use crate::guard::wait::Wait;
use ca_core::Balance;

/// One thing that happened. `tick` is the sound sample before which it took effect.
// frames are the many, boxes the few: a ring of values of one size is what the real-time thread can write
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum Record {
    /// a frame that was looked at, stamped with the tick; also those that were dropped
    Device {
        /// number of the device in the engine
        port: u32,
        /// the frame
        frame: DeviceFrame,
    },
    /// a frame that was sent; its publishing time is not in it
    Force {
        /// number of the device in the engine
        port: u32,
        /// the frame
        frame: ForceFrame,
    },
    /// parameters changed, the scene was loaded again, or a device said what it is
    Retired {
        /// when
        tick: u64,
        /// what it was
        retired: Retired,
    },
    /// forces were armed, disarmed or tripped
    Order {
        /// when
        tick: u64,
        /// one device, or all
        port: Option<u32>,
        /// what was asked
        order: Order,
    },
    /// a hand without a device did something
    Touched {
        /// when
        tick: u64,
        /// what
        touched: Touched,
        /// a gesture that ended by it
        gone: Option<Box<OwnGesture>>,
    },
    /// another version of the scene plays from here on
    Swapped {
        /// when
        tick: u64,
        /// how many there were before it
        number: u32,
        /// the one that faded out when it came
        gone: Option<Box<Swap>>,
    },
    /// an [`EngineCommand::Mark`](crate::engine::EngineCommand::Mark) was executed: all earlier commands have their records before it
    Marked {
        /// when
        tick: u64,
        /// [`ca_core::State::bits`]
        bits: u64,
    },
    /// a hash of the state, once a second
    Hash {
        /// when
        tick: u64,
        /// [`ca_core::State::bits`]
        bits: u64,
    },
    /// the energy ledger
    Energy {
        /// when
        tick: u64,
        /// its sums
        balance: Balance,
    },
    /// an armed device still has no force, reported now and then
    Waiting {
        /// when
        tick: u64,
        /// number of the device in the engine
        port: u32,
        /// what keeps forces from beginning
        wait: Wait,
    },
    /// here so many records are missing: there was no room for them
    Lost {
        /// when there was room again
        tick: u64,
        /// how many
        records: u64,
    },
}

impl Record {
    /// When it happened.
    pub fn tick(&self) -> u64 {
        match self {
            Record::Device { frame, .. } => frame.tick,
            Record::Force { frame, .. } => frame.tick,
            Record::Retired { tick, .. }
            | Record::Order { tick, .. }
            | Record::Touched { tick, .. }
            | Record::Swapped { tick, .. }
            | Record::Marked { tick, .. }
            | Record::Hash { tick, .. }
            | Record::Energy { tick, .. }
            | Record::Waiting { tick, .. }
            | Record::Lost { tick, .. } => *tick,
        }
    }
}
