//! Last: from the network to the arrays and passes of a [`Scene`](ca_core::Scene).

pub mod cost;
pub mod cutoff;
mod driven;
pub mod implicit;
pub mod masses;
pub mod milib;
pub mod ordering;
pub mod oversample;
pub mod pass_list;
pub mod pefrl;
pub mod penetration;
pub mod plan;
pub mod points;
pub mod rows;
pub mod schedule;
pub mod slow;
pub mod waves;
