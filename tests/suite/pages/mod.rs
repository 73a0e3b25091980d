//! Measured pages agree with their benches.

mod accuracy;
mod atlas;
mod costs;
mod instruments;
mod moving_picture;
mod peers;
mod start_orders;
