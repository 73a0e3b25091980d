//! Third: the network made cheaper and complete, one pass a file: methods chosen, laws specialised, what nobody hears
//! left out, the order in which implicit links are solved, strings of waves tuned, modes in place of masses.

pub mod implicit;
#[cfg_attr(not(feature = "analysis"), path = "no_modal.rs")]
pub mod modal;
pub mod pefrl;
pub mod prune;
pub mod rates;
pub mod reach;
pub mod single;
pub mod slow;
pub mod solve_order;
pub mod specialise;
pub mod waves;
