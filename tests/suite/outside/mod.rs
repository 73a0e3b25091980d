//! Against others: MIMS models, mi.lib by Faust, independent readers of our files.

mod files;
mod imports;
mod mims;
mod peers;
mod published;
