//! The command `ca`.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(ca_cli::run(std::env::args_os()))
}
