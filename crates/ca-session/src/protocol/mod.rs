//! The messages between the page of `ca play` and the program, in both directions.
//!
//! Rare messages are JSON texts: an object with a `type` ([`Request`] from the page, [`Message`] to it). Pictures and
//! sound are bytes ([`binary`]). The macros of `define` declare each type together with its documentation, so that
//! `docs/protocol.md` and the JSDoc types of the page are generated from the same lines ([`page`], [`jsdoc`]). JSON
//! Schema by a derive crate would add a dependency and could not say what the page may leave out.

pub mod binary;
mod define;
mod js;
mod message;
mod pages;
mod request;

pub use define::{Fields, Kind};
pub use message::{Bound, Choices, DeviceState, Message, Param, Picked, PortInfo, PortRole, Preset};
pub use pages::{jsdoc, page};
pub use request::{NumberedRequest, Request};

/// Version of the messages. It grows by one with each change that an older page or program would misunderstand.
pub const VERSION: u32 = 1;
