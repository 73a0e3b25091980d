//! Every kind of the catalog keeps the promises of its record; nothing here is written for one kind by name, so a new
//! law is tested the day it is listed. [`felt`] is one that nobody has listed, so that this is tried.

mod axes;
pub mod drawn;
mod felt;
mod forces;
mod forms;
mod records;
mod time;
