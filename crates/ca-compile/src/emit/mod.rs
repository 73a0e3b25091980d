//! Last step: converts the network to the arrays and passes of a [`Scene`](ca_core::Scene).

pub mod clusters;
pub mod cost;
mod driven;
pub mod gesture_rate;
pub mod high_pass;
pub mod layout_builder;
pub mod masses;
pub mod methods;
pub mod milib;
pub mod ordering;
pub mod pass_list;
pub mod penetration;
pub mod points;
pub mod rows;
pub mod schedule;
pub mod waves;
