//! Takes: a performance in one MCAP file, replayed to the bit.
//!
//! A take holds the ordered input of an engine ([`crate::record`]), its output, and everything needed to build that
//! engine again; nothing is outside the file. An engine is a pure function of its input, so a replay gives the same
//! bytes, and a comparison finds the first difference.
//!
//! | topic | what | encoding |
//! |---|---|---|
//! | `/device/<name>/in`, `/device/<name>/out` | every frame checked, every force frame made | CDR |
//! | `/change`, `/order`, `/reload`, `/hand`, `/model` | requests to the engine; another version of its model | CDR |
//! | `/profile` | self-description of a device | CDR |
//! | `/hash`, `/sound` | a hash of the state each second; sound, 64 bits | CDR |
//! | `/param`, `/energy`, `/rt`, `/lost` | for plots: parameters, energy, timing, losses | CDR |
//! | `/gesture/joints`, `/audio`, `/masses`, `/scene`, `/log` | for viewers | protobuf of Foxglove |

pub mod cdr;
mod couplings;
pub mod export;
mod gesture;
mod header;
mod mcap_records;
mod next_version;
mod read;
mod records;
mod recover;
mod replay;
mod source;
mod summary;
mod write;

pub use gesture::gesture;
pub use header::{FORMAT, Header, META};
pub use next_version::NextModel;
pub use read::{Event, Events, Take};
pub use records::{Energy, Hand, Hashed, Lost, Ordered, Reloaded, Rt};
pub use recover::{Recovered, recover};
pub use replay::{Difference, Replay, ReplayVerdict};
pub use source::End;
pub use summary::{Fault, Summary, Topic};
pub use write::{Finished, Level, TakeWriter};

/// Layout stored in every take, for Foxglove and Lichtblick.
const LAYOUT: &str = include_str!("../../layouts/ca-foxglove.json");

/// Names of topics.
pub mod topic {
    /// Parameters that changed together, exact.
    pub const CHANGE: &str = "/change";
    /// One changed parameter, for people.
    pub const PARAM: &str = "/param";
    /// The scene was loaded again.
    pub const RELOAD: &str = "/reload";
    /// Another version of the model.
    pub const MODEL: &str = "/model";
    /// Forces were armed, disarmed or tripped.
    pub const ORDER: &str = "/order";
    /// Input without a device: pointer, ports, the model's own gesture.
    pub const HAND: &str = "/hand";
    /// A device described itself.
    pub const PROFILE: &str = "/profile";
    /// Hashes of the state.
    pub const HASH: &str = "/hash";
    /// The energy ledger.
    pub const ENERGY: &str = "/energy";
    /// Data that did not fit.
    pub const LOST: &str = "/lost";
    /// State of the real-time thread.
    pub const RT: &str = "/rt";
    /// Sound, exact.
    pub const SOUND: &str = "/sound";
    /// Sound for listening.
    pub const AUDIO: &str = "/audio";
    /// Positions and forces of all degrees of freedom, decimated.
    pub const JOINTS: &str = "/gesture/joints";
    /// Masses in space.
    pub const MASSES: &str = "/masses";
    /// Links in space.
    pub const SCENE: &str = "/scene";
    /// Text messages.
    pub const LOG: &str = "/log";

    /// Returns the topic of the frames of a device.
    pub fn device(name: &str) -> String {
        format!("/device/{name}/in")
    }
    /// Returns the topic of the force frames for a device.
    pub fn force(name: &str) -> String {
        format!("/device/{name}/out")
    }
}

/// Options of every take: compressed on the writing thread itself, and signed with both versions.
fn options() -> mcap::WriteOptions {
    let by = format!("ca {} {}", env!("CARGO_PKG_VERSION"), mcap::LIBRARY_IDENTIFIER);
    let options = mcap::WriteOptions::new().profile("ca").compression(Some(mcap::Compression::Zstd));
    mcap::WriteOptions::library(options, by).compression_threads(0)
}
