//! A test that cannot do its work where it is run, for want of something that is no part of the project, says so here
//! and returns.
//!
//! Decides that this is never silent: what is missing is a line of the file that `CA_SKIPPED` names, from which
//! `tests/run` makes the list at its end, and a line on stderr past what cargo captures. Where `CI=true`, it fails
//! the test if it is something that `tests/setup` installs; all else, such as models of others that lie beside the project,
//! may be missing anywhere. Other packages include this file by its path, since there is no other that all of them need.

use std::io::Write as _;
use std::panic::Location;

/// What `tests/setup` installs, by its names there.
pub const INSTALLED: [&str; 6] = ["jackd", "pulseaudio", "faust", "c++", "chromium", "valgrind"];

/// Notes that the calling test is skipped, since there is no `needs`; `why` says it in a few words.
///
/// # Panics
///
/// Where `CI=true` and `tests/setup` installs what is missing.
#[track_caller]
pub fn skipped(needs: &str, why: &str) {
    let thread = std::thread::current();
    // with one thread for all tests theirs has no name of its own
    let test = thread.name().filter(|name| *name != "main").unwrap_or("a test");
    let why: Vec<&str> = why.split_whitespace().collect();
    let (file, why) = (Location::caller().file(), why.join(" "));
    let why = if why.is_empty() { format!("no {needs}") } else { why };
    // not by `eprintln!`, which is captured; a stderr that is closed is no failure of a test
    let _ = writeln!(std::io::stderr(), "skipped: {file} {test}: {why}");
    if let Some(path) = std::env::var_os("CA_SKIPPED") {
        let line = format!("{file} {test}\t{why}\n");
        // one write to the end, because tests run side by side
        let done = std::fs::OpenOptions::new().create(true).append(true).open(&path);
        let done = done.and_then(|mut f| f.write_all(line.as_bytes()));
        assert!(done.is_ok(), "CA_SKIPPED: `{}` cannot be written: {done:?}", path.display());
    }
    let may_not = std::env::var_os("CI").is_some_and(|v| v == "true") && INSTALLED.contains(&needs);
    assert!(!may_not, "skipped for want of {needs}, which tests/setup installs, and CI=true: {why}");
}
