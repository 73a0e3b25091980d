//! (quantity)
