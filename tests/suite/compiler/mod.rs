//! The compiler: passes, certificate, both sides of every limit, modes, and the oracle, a plain interpreter.

mod any_order;
mod certificate;
mod chance;
mod compile_fuzz;
mod depth;
mod fused;
mod growth;
mod modes;
mod oracle;
mod reach;
mod sets;
mod single;
mod thresholds;
