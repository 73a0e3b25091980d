//! The commands, one file each; `border.rs` holds words that two of them share.

mod border;
pub mod check;
pub mod import;
pub mod list;
pub mod new;
pub mod render;
pub mod shm;
