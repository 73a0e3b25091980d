//! From a model to a scene: passes, what is the same by each of them, what is proven, and both sides of every limit.

mod any_order;
mod certificate;
mod chance;
mod compile_fuzz;
mod fused;
mod halves;
mod oracle;
mod sets;
mod single;
mod thresholds;
