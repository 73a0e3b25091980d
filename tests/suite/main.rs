//! The whole suite in one binary, one file per theme.

mod files;
