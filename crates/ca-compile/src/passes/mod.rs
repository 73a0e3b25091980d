//! Third step: passes that simplify and complete the network, one per file: choice of methods, specialised laws,
//! pruning, solve order of implicit links, waveguides, modes.

pub mod auto;
pub mod gesture_rate;
pub mod implicit;
#[cfg_attr(not(feature = "analysis"), path = "no_modal.rs")]
pub mod modal;
pub mod pefrl;
pub mod prune;
pub mod rates;
pub mod reach;
pub mod single;
pub mod solve_order;
pub mod specialise;
pub mod waves;
