//! Integration methods: explicit, implicit, modal, PEFRL, `stable`, `stable3d`, friction.

mod auto;
mod begins;
mod friction;
mod hertz;
mod implicit;
mod modal;
mod modal_stable;
mod pefrl;
mod potential;
mod quadratised;
mod scheme;
mod shared;
pub mod stable;
