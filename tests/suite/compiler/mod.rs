//! The compiler: passes, certificate, both sides of every limit, modes, and the oracle, a plain interpreter.

pub mod certificate;
mod compile_fuzz;
mod contact_depth;
mod fused;
mod growth;
mod link_order;
mod modes;
mod oracle;
mod random_networks;
mod reach;
mod sets;
mod single;
mod thresholds;
