//! What others wrote: their models, their programs, their files.

mod files;
mod imports;
mod mims;
mod peers;
mod published;
