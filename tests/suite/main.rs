//! The whole suite in one binary, one file per theme.

mod mims;
mod files;
