//! The commands, one file each.

pub mod check;
pub mod import;
pub mod list;
pub mod new;
pub mod render;
