//! What a state is: whose it is, taken and given back, changed while it plays, and played for long.

mod identity;
mod snapshot;
mod soak;
mod swap;
