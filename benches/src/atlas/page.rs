//! Page `docs/measured/atlas.md`: the format of maps and tables, which a test compares with the page.

use super::non_finite::{self, EntryPoint};
use super::orders;
use super::survival::{CASES, Case, METHODS};
use super::{Field, Map};
use crate::table::head;
use std::fmt::Write as _;

const HEAD: &str = "# The stability atlas

Made by `UPDATE=1 cargo bench -p ca-benches --bench atlas`: do not edit.

Measurements of the engine beside the predictions of theory. Every cell of a map is a model in text, compiled and
played; `ca check` is not used here. Throughout, T is a tick, a = k T²/m and b = z T/m. Blue cells are bounded, orange
cells grow, the black line is the boundary of theory, thin dashed lines are rules and special values; **red is a cell
that contradicts theory**. Within a band beside the line a run of finite length cannot distinguish the two, so cells
there are not judged; neither are cells without a prediction. The test suite plays coarse maps by the same functions
and allows no contradiction. The numbers of this page do not depend on the machine.
";

/// Formats the line below a map.
pub fn figure(map: &Map, field: &Field) -> String {
    let up = field.cells.len() / field.across;
    let band = if map.band > 0.0 { format!("; band: {} % of each axis", 100.0 * map.band) } else { String::new() };
    format!(
        "{} × {up} cells, {} judged, **{} contradict theory**{band}.",
        field.across,
        field.judged(),
        field.contradictions()
    )
}

/// Formats the heading, text and picture of a map.
pub fn section(map: &Map, field: &Field) -> String {
    format!(
        "\n### {}\n\n{}\n\n![{}](atlas/{}.svg)\n\n{}\n",
        map.title,
        wrap(map.text),
        map.title,
        map.name,
        figure(map, field)
    )
}

/// Formats a row of the survival table; `length` is 0 for the page and 1 for the core suite.
pub fn row(case: &Case, length: usize) -> String {
    let ticks = case.ticks()[length];
    let cell = |text: Option<String>| text.map_or("–".into(), |t| case.outcome(&t, ticks).words());
    let cells: Vec<String> = METHODS.iter().map(|m| cell((m.text)(case))).collect();
    format!("| {} | {} | {} |", case.name(), spaced(ticks), cells.join(" | "))
}

/// Formats a row of the table of entry points.
pub fn entry_point(name: &str, what: &str, entry_point: &EntryPoint) -> String {
    format!("| {name} | {what} | {} | {} |", entry_point.tried, entry_point.through.len())
}

/// Test of an entry point.
pub type Trial = fn() -> EntryPoint;

/// All entry points: name, expected behaviour, and test.
pub const DOORS: [(&str, &str, Trial); 4] = [
    (
        "parameters of a model, each number of each kind",
        "an error that names the value; no scene",
        non_finite::parameters,
    ),
    ("ports, each input of each example", "held (positions) or taken as 0 (forces), and counted", non_finite::ports),
    ("live parameters, by name and as a patch", "refused, nothing changed", non_finite::changes),
    (
        "frames of a device, with forces on",
        "no force and no sound that is not finite; where positions stay bad, no force",
        non_finite::frames,
    ),
];

/// Makes the page.
pub fn page(maps: &str) -> String {
    let mut t = format!("{HEAD}\n## Maps\n{maps}\n## Extremes\n\n");
    t += &wrap(
        "Each case is played by each method that affects it. An oscillator is released from 1. A contact is a wall at \
         the rest position of a cell of k T²/m = 0.01, hit once per period, so an explicit contact may also settle at \
         a phase of the tick in which it takes as much energy as it made. Energy is the largest deviation of the \
         energy ledger, heat included, at any tick; momentum is the sum for both masses, where the light one moves by \
         about 1 per tick. Decaying resonators have denormal numbers, if at all, for less than the 1024 ticks between \
         two checks of the engine for negligibly small numbers, and then are 0.",
    );
    let names: Vec<&str> = METHODS.iter().map(|m| m.name).collect();
    t += "\n\n";
    t += &head(&[&["case", "ticks"], &names[..]].concat());
    for case in CASES {
        let _ = writeln!(t, "{}", row(case, 0));
    }
    t += "\n## Orders\n\n";
    t += &wrap(
        "The order of each method, measured: the fall of the error of a second from 1 to 4 kHz, for an oscillator of \
         20 Hz released from a position, with a speed, and with both; and, with a hand that moves at a constant speed \
         from the first tick on, the convergence of runs at 2, 4 and 8 kHz. With `ca` a port is at rest in the first \
         tick; with the others it has the speed of the gesture.",
    );
    t += "\n\n";
    t += &head(&["method", "order", "from a place", "with a speed", "with both", "under a hand"]);
    for case in &orders::CASES {
        let _ = writeln!(t, "{}", case.row());
    }
    t += "\n## What is not finite\n\nNaN, +∞ and −∞ at every door of the engine.\n\n";
    t += &head(&["where", "what happens", "tried", "came through"]);
    for (name, what, try_it) in DOORS {
        let _ = writeln!(t, "{}", entry_point(name, what, &try_it()));
    }
    t
}

fn spaced(n: u64) -> String {
    let text = n.to_string();
    let groups: Vec<&str> = text.as_bytes().rchunks(3).rev().map(|c| std::str::from_utf8(c).unwrap_or("")).collect();
    groups.join(" ")
}

/// Wraps a text in lines of at most 118 characters.
pub(crate) fn wrap(text: &str) -> String {
    let (mut out, mut width) = (String::new(), 0);
    for word in text.split_whitespace() {
        let n = word.chars().count();
        if width > 0 && width + 1 + n > 118 {
            out.push('\n');
            width = 0;
        } else if width > 0 {
            out.push(' ');
            width += 1;
        }
        out += word;
        width += n;
    }
    out
}
