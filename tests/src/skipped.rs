//! Reports a test that is skipped because something outside the project is missing.
//!
//! A skip is never silent. It is a line in the file named by `CA_SKIPPED`, from which `tests/run` prints a list at its
//! end, and a line on stderr that cargo does not capture. With `CI=true` the test fails if `tests/setup` installs the
//! missing program; anything else, such as foreign models beside the project, may be missing anywhere. Other packages
//! include this file by its path, because the workspace has no package that all of them depend on.

use std::io::Write as _;
use std::panic::Location;

/// Programs that `tests/setup` installs, by their names there.
pub const INSTALLED: [&str; 6] = ["jackd", "pulseaudio", "faust", "c++", "chromium", "valgrind"];

/// Notes that the calling test is skipped because `needs` is missing. `why` gives the reason in a few words.
///
/// # Panics
///
/// With `CI=true`, if `tests/setup` installs what is missing.
#[track_caller]
pub fn skipped(needs: &str, why: &str) {
    let thread = std::thread::current();
    // with one test thread, tests run on the thread "main"
    let test = thread.name().filter(|name| *name != "main").unwrap_or("a test");
    let why: Vec<&str> = why.split_whitespace().collect();
    let (file, why) = (Location::caller().file(), why.join(" "));
    let why = if why.is_empty() { format!("no {needs}") } else { why };
    // `eprintln!` would be captured; a closed stderr does not fail the test
    let _ = writeln!(std::io::stderr(), "skipped: {file} {test}: {why}");
    if let Some(path) = std::env::var_os("CA_SKIPPED") {
        let line = format!("{file} {test}\t{why}\n");
        // one appending write, because tests run in parallel
        let done = std::fs::OpenOptions::new().create(true).append(true).open(&path);
        let done = done.and_then(|mut f| f.write_all(line.as_bytes()));
        assert!(done.is_ok(), "CA_SKIPPED: `{}` cannot be written: {done:?}", path.display());
    }
    let may_not = std::env::var_os("CI").is_some_and(|v| v == "true") && INSTALLED.contains(&needs);
    assert!(!may_not, "skipped for want of {needs}, which tests/setup installs, and CI=true: {why}");
}
