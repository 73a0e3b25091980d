//! Records of a running engine, for takes, control and reports.
//!
//! The real-time thread passes plain values through a ring and never waits: a record that does not fit is counted and
//! dropped. Boxes travel the same way, so that another thread frees them.

use crate::engine::{ManualEvent, OwnGesture, Retired, Swap};
use crate::frame::{DeviceFrame, ForceFrame};
use crate::guard::Order;
use crate::guard::wait::Wait;
use ca_core::Balance;

/// One event. `tick` is the sound sample before which it took effect.
// the real-time thread needs a ring of values of one size; most are frames, few have boxes
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug, PartialEq)]
pub enum Record {
    /// A frame that was checked, stamped with the tick; also one that was dropped.
    Device {
        /// Number of the device in the engine.
        port: u32,
        /// The frame.
        frame: DeviceFrame,
    },
    /// A frame that was made, whether it was sent or not, without its publishing time.
    Force {
        /// Number of the device in the engine.
        port: u32,
        /// The frame.
        frame: ForceFrame,
    },
    /// Parameters changed, the scene was loaded again, or a device described itself.
    Retired {
        /// When.
        tick: u64,
        /// Data that the engine no longer uses.
        retired: Retired,
    },
    /// Forces were armed, disarmed or tripped.
    Order {
        /// When.
        tick: u64,
        /// One device, or all.
        port: Option<u32>,
        /// The order.
        order: Order,
    },
    /// The pointer, a gesture or another input without a device acted on the scene.
    Manual {
        /// When.
        tick: u64,
        /// The action.
        event: ManualEvent,
        /// The gesture that it ended.
        gone: Option<Box<OwnGesture>>,
    },
    /// Another version of the scene plays from here on.
    Swapped {
        /// When.
        tick: u64,
        /// Number of versions before it.
        number: u32,
        /// An earlier swap that is out of use now, if any.
        gone: Option<Box<Swap>>,
    },
    /// An [`EngineCommand::Mark`](crate::engine::EngineCommand::Mark), after the records of all earlier commands.
    Marked {
        /// When.
        tick: u64,
        /// [`ca_core::State::bits`].
        bits: u64,
    },
    /// Hash of the state, once a second.
    Hash {
        /// When.
        tick: u64,
        /// [`ca_core::State::bits`].
        bits: u64,
    },
    /// The energy ledger.
    Energy {
        /// When.
        tick: u64,
        /// Its sums.
        balance: Balance,
    },
    /// An armed device is still without force; reported now and then.
    Waiting {
        /// When.
        tick: u64,
        /// Number of the device in the engine.
        port: u32,
        /// Reason why its forces have not begun.
        wait: Wait,
    },
    /// Records are missing here, because the ring was full.
    Lost {
        /// When the ring had capacity again.
        tick: u64,
        /// Number of missing records.
        records: u64,
    },
}

impl Record {
    /// Returns when it happened.
    pub fn tick(&self) -> u64 {
        match self {
            Record::Device { frame, .. } => frame.tick,
            Record::Force { frame, .. } => frame.tick,
            Record::Retired { tick, .. }
            | Record::Order { tick, .. }
            | Record::Manual { tick, .. }
            | Record::Swapped { tick, .. }
            | Record::Marked { tick, .. }
            | Record::Hash { tick, .. }
            | Record::Energy { tick, .. }
            | Record::Waiting { tick, .. }
            | Record::Lost { tick, .. } => *tick,
        }
    }
}
