//! Takes: a performance in one MCAP file, replayed to the bit.
//!
//! Decides what a take is: the order of what an engine was given ([`crate::record`]), what it made of it, and all that
//! is needed to make that engine again, nothing of it outside the file. An engine is a pure function of those, so a
//! replay gives the same bytes, and comparing them finds the first thing that differs.
//!
//! | topic | what | encoding |
//! |---|---|---|
//! | `/device/<name>/in`, `/device/<name>/out` | every frame looked at, every frame sent | CDR |
//! | `/change`, `/order`, `/reload`, `/hand`, `/model` | what was asked of the engine; another version of its model | CDR |
//! | `/profile` | what a device said it is | CDR |
//! | `/hash`, `/sound` | a hash of the state each second; sound, 64 bits | CDR |
//! | `/param`, `/energy`, `/rt`, `/lost` | for plots: parameters, energy, timing, what found no room | CDR |
//! | `/gesture/joints`, `/audio`, `/masses`, `/scene`, `/log` | for viewers | protobuf of Foxglove |

pub mod cdr;
mod couplings;
pub mod export;
mod flat;
mod framed;
mod gesture;
mod header;
mod next;
mod read;
mod recover;
mod replay;
mod source;
mod summary;
mod write;

pub use flat::{Energy, Hand, Hashed, Lost, Ordered, Reloaded, Rt};
pub use gesture::gesture;
pub use header::{FORMAT, Header, META};
pub use next::NextModel;
pub use read::{Event, Events, Take};
pub use recover::{Recovered, recover};
pub use replay::{Difference, Replay, ReplayVerdict};
pub use source::End;
pub use summary::{Fault, Summary, Topic};
pub use write::{Finished, Level, TakeWriter};

/// The layout that goes with every take, for Foxglove and Lichtblick.
const LAYOUT: &str = include_str!("../../layouts/ca-foxglove.json");

/// Names of topics.
pub mod topic {
    /// several parameters that changed together, exact
    pub const CHANGE: &str = "/change";
    /// one parameter that changed, for people
    pub const PARAM: &str = "/param";
    /// the scene was loaded again
    pub const RELOAD: &str = "/reload";
    /// another version of the model
    pub const MODEL: &str = "/model";
    /// forces armed, disarmed or tripped
    pub const ORDER: &str = "/order";
    /// hands without a device: pointer, ports, the model's own gesture
    pub const HAND: &str = "/hand";
    /// a device said what it is
    pub const PROFILE: &str = "/profile";
    /// hashes of the state
    pub const HASH: &str = "/hash";
    /// the energy ledger
    pub const ENERGY: &str = "/energy";
    /// what found no room
    pub const LOST: &str = "/lost";
    /// how the real-time thread does
    pub const RT: &str = "/rt";
    /// sound, exact
    pub const SOUND: &str = "/sound";
    /// sound to listen to
    pub const AUDIO: &str = "/audio";
    /// positions and forces of all degrees of freedom, decimated
    pub const JOINTS: &str = "/gesture/joints";
    /// masses in space
    pub const MASSES: &str = "/masses";
    /// links in space
    pub const SCENE: &str = "/scene";
    /// words
    pub const LOG: &str = "/log";

    /// Frames of a device.
    pub fn device(name: &str) -> String {
        format!("/device/{name}/in")
    }
    /// Force frames for a device.
    pub fn force(name: &str) -> String {
        format!("/device/{name}/out")
    }
}

/// How every take is written: compressed, by the thread that writes it alone, and signed with both versions.
fn options() -> mcap::WriteOptions {
    let by = format!("ca {} {}", env!("CARGO_PKG_VERSION"), mcap::LIBRARY_IDENTIFIER);
    let options = mcap::WriteOptions::new().profile("ca").compression(Some(mcap::Compression::Zstd));
    mcap::WriteOptions::library(options, by).compression_threads(0)
}
