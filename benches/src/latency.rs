//! Page `docs/measured/latency.md`: the runs of the bench, and their format, which a test compares with the page. The
//! bench itself is with the command that it measures.

use crate::table::{head, line};
use std::fmt::Write as _;

const HEAD: &str = "# Latency of the loop

Made by `UPDATE=1 cargo bench -p ca-cli --bench latency`: do not edit.

`ca serve hammer_piano`, twelve keys at 3 kHz, with `ca device sim --profile tgr12 --script strike` on the other side of
the shared memory: two processes, three threads of real time and the desk. The period is **333.3 µs**; all times are in
µs.

- **computing**: the engine, from the beginning of a gesture frame to its end;
- **lateness**: the time from the due time of the engine's frame to its beginning;
- **force**: from the moment the device sent a position to the moment it received the force that answers it, by the
  device's clock, found by `ack`;
- **loop**: from the moment the device sent a position to the first position it sent after using the force that
  answers it, by the device's clock, found by `seq` and `ack`. Both sides run freely at 3 kHz, so this is a whole
  number of periods, usually two.

**Load** is two processes that only compute, one for each core. **Priority** is SCHED_FIFO, 70 for the engine, 65 for
the gateway and 60 for the device; without it all three are ordinary processes. A period that is over before its frame
could begin is skipped, and counts in the second table, not in the first.

The machine of this page is a virtual one with two cores, which it shares with others: it stops for 5 to 20 ms now and
then, whatever runs on it. The largest times come from that. A load of \"none\" excludes only the load of the bench:
other programs that ran there meanwhile, compilers too, affect all rows. To judge a machine for playing, run the bench
on it.
";

/// Runs: with real-time priority or without, with load or without.
pub const RUNS: [(bool, bool); 4] = [(true, false), (true, true), (false, false), (false, true)];

/// Quantities timed in a run.
pub const TIMED: [&str; 4] = ["computing", "lateness", "force", "loop"];

const COLUMNS: [&str; 8] = ["priority", "load", "what", "n", "p50", "p99", "p99.9", "max"];
const COUNTS: [&str; 6] =
    ["priority", "load", "frames", "left out by the engine", "left out by the device", "positions missed"];

/// A distribution: number of values, and p50, p99, p99.9 and largest \[µs\].
#[derive(Clone, Copy, Debug, Default)]
pub struct Percentiles {
    /// Number of values.
    pub n: u64,
    /// p50, p99, p99.9 and largest \[µs\].
    pub us: [f64; 4],
}

/// Results of a run.
#[derive(Clone, Debug, Default)]
pub struct Run {
    /// Distributions, in the order of [`TIMED`].
    pub reported: [Percentiles; 4],
    /// Gesture frames; periods skipped by the engine and by the device; positions that the gateway did not see.
    pub counts: [u64; 4],
    /// Priority that the system granted the engine.
    pub granted: String,
}

fn names((priority, load): (bool, bool)) -> [String; 2] {
    let word = |is: bool, what: &str| if is { what.to_string() } else { "none".to_string() };
    [word(priority, "real time"), word(load, "both cores")]
}

/// Makes the page from the runs, in order.
pub fn page(runs: &[Run]) -> String {
    let mut t = format!("{HEAD}\n{}", head(&COLUMNS));
    for (run, which) in runs.iter().zip(RUNS) {
        for (what, reported) in TIMED.iter().zip(run.reported) {
            let times = reported.us.map(|us| format!("{us:.1}"));
            t += &line(&[&names(which)[..], &[(*what).into(), reported.n.to_string()], &times].concat());
        }
    }
    let _ = write!(t, "\n{}", head(&COUNTS));
    for (run, which) in runs.iter().zip(RUNS) {
        t += &line(&[&names(which)[..], &run.counts.map(|n| n.to_string())].concat());
    }
    let granted = |priority: bool| {
        let run = runs.iter().zip(RUNS).find(|(_, which)| which.0 == priority);
        run.map_or("not run", |(r, _)| r.granted.as_str())
    };
    // a debug build slows down only the computing
    let build = if cfg!(debug_assertions) { "for development, little optimised" } else { "for release" };
    let _ = write!(t, "\nThe command was built: {build}.\n\nThe engine's thread with priority: {}.\n\n", granted(true));
    let _ = writeln!(t, "Without: {}.", granted(false));
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns everything but measured numbers: the text, and the cells that name rows and columns.
    fn frame(page: &str) -> Vec<String> {
        let without_numbers = |l: &str| match l.split_once(": policy ").or_else(|| l.split_once(": for ")) {
            Some((what, _)) => what.to_string(),
            None if l.starts_with('|') => {
                let measured = |c: &&str| c.trim().parse::<f64>().is_err();
                l.split('|').filter(measured).collect::<Vec<_>>().join("|") + &l.matches('|').count().to_string()
            }
            None => l.to_string(),
        };
        page.lines().map(without_numbers).collect()
    }

    #[test]
    fn the_page_has_the_rows_and_columns_the_bench_makes() {
        let run = Run { granted: "policy none".into(), ..Run::default() };
        let made = page(&vec![run; RUNS.len()]);
        let there = include_str!("../../docs/measured/latency.md");
        assert_eq!(frame(there), frame(&made), "`UPDATE=1 cargo bench -p ca-cli --bench latency` makes it anew");
        // made by a whole run, with tens of thousands of frames in each row
        let timed = there.lines().filter(|l| TIMED.iter().any(|t| l.contains(&format!("| {t} |"))));
        let n: Vec<u64> = timed.map(|l| l.split('|').nth(4).and_then(|c| c.trim().parse().ok()).unwrap_or(0)).collect();
        assert!(n.len() == 16 && n.iter().all(|n| *n > 10_000), "{n:?}");
    }
}
