//! Against foreign programs: MIMS models, mi.lib by Faust, independent readers of our files.

mod files;
mod imports;
mod inputs;
mod mims;
mod peers;
mod published;
mod takes;
