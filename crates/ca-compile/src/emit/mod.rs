//! Last: from the network to the arrays and passes of a [`Scene`](ca_core::Scene).

pub mod added;
pub mod bands;
pub mod batches;
pub mod cutoff;
pub mod fold;
pub mod fuse;
pub mod implicit;
pub mod links;
pub mod milib;
pub mod ordering;
pub mod oversample;
pub mod pass_list;
pub mod pefrl;
pub mod penetration;
pub mod plan;
pub mod schedule;
pub mod waves;
pub mod written;
