//! What plays a scene by hand: devices, their safety, the real-time loop and takes. Files of others (gestures, sounds,
//! clouds of points) and a scene played to its end without a device are in `ca-io`.
//!
//! ```text
//! frame, profile, calibration, equivalence → guard → engine → coupling, admission, record, version → serve
//!                                 rt, stats ──────────────────────────────┘
//! simulated (a device as physics)    host (shared memory, feature `iceoryx`)    take (MCAP, feature `mcap`)
//! ```
//! The feature `host`, on by default, is `iceoryx` and `mcap`; each of them needs `system`. Without any feature the guard, the engine
//! and the loop remain: no threads, no clock ([`time`]), no compiler.
//!
//! What stands between a model and a hand, with every number, is in `docs/safety.md`: read it before a device has power. A device process
//! needs the client of [`host`] alone (`examples/device.rs`, `examples/device.c`, docs/devices.md); `ca_live::play` plays a scene by all of this.
//!
//! What is not here: the tick (`ca-core`), models (`ca-model`, `ca-compile`), and what people type and see (`ca-cli`, `ca-play`).
#[cfg(feature = "system")]
pub mod admission;
mod blocks;
pub mod calibration;
pub mod control;
#[cfg(feature = "system")]
pub mod coupling;
pub mod engine;
pub mod equivalence;
pub mod frame;
pub mod guard;
#[cfg(feature = "iceoryx")]
pub mod host;
pub mod profile;
pub mod record;
#[cfg(feature = "system")]
pub mod rt;
pub mod serve;
pub mod simulated;
pub mod stats;
#[cfg(feature = "mcap")]
pub mod take;
pub mod time;
pub mod version;
