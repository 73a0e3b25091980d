//! The commands, a file or folder each with `run`; `control.rs` has the six that speak to a running server. `border.rs` holds
//! lines that several of them print.

pub mod accuracy;
pub mod bench;
mod border;
pub mod check;
pub mod completions;
pub mod control;
pub mod device;
pub mod equiv;
pub mod explain;
pub mod fit;
pub mod import;
pub mod list;
pub mod modes;
pub mod new;
pub mod play;
pub mod render;
pub mod report;
pub mod serve;
pub mod shm;
pub mod sweep;
pub mod take;
pub mod tune;
