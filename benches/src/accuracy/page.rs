//! Page `docs/measured/accuracy.md`, written and read: a test knows the machine of the page only from its tables.

use super::{CASES, Claim, ErrorRow, Found, STIFF};
use crate::atlas::page::wrap;
use crate::table::{head, line};
use std::fmt::Write as _;

const HEAD: &str = "# Error against run time

Made by `UPDATE=1 cargo bench -p ca-cli --bench accuracy`: do not edit.

Results of `ca accuracy` for twelve scenes: every method that they have, at multiples of 48 kHz. **Error** is the
relative difference of the outputs from the reference, before gains and filters; it cannot be less than the error of
the reference. **spectrum** is the same for the levels of the partials; **cents** and **decay dB** are the errors of
the strongest partial and of the loudness of the second half; **energy** is the energy that the scheme gives or takes,
relative to the maximum, if there is a ledger; **ns** is the time of one sample at 48 kHz, the fastest of at least
four runs, with all methods in turn, including the test for diverged states and the reading of outputs; `single` gets
its inputs computed beforehand. No other row is better than a row with a star in both error and time; these are full
dots in the pictures. The errors do not depend on the machine, the times do.
";

const COLUMNS: [&str; 9] =
    ["method", "error", "spectrum", "cents", "decay dB", "energy", "ns", "x real time", "stability"];

fn small(v: f64) -> String {
    if v.is_finite() { format!("{v:.1e}") } else { "-".into() }
}

fn cells(r: &ErrorRow, known: f64) -> Vec<String> {
    let star = if r.front { " *" } else { "" };
    vec![
        format!("{} ×{}{star}", r.method, r.times),
        if r.error < known { format!("< {}", small(known)) } else { small(r.error) },
        small(r.spectrum),
        r.cents.map_or("-".into(), |c| format!("{c:+.3}")),
        r.decay.map_or("-".into(), |d| format!("{d:+.3}")),
        r.made.map_or("-".into(), small),
        format!("{:.0}", r.ns),
        format!("{:.1}", 1e9 / (r.ns * 48e3)),
        r.stability.clone(),
    ]
}

fn table(found: &Found) -> String {
    found.rows.iter().fold(head(&COLUMNS), |t, r| t + &line(&cells(r, found.known)))
}

fn shown(v: f64) -> String {
    if v < 0.01 { format!("{v:.1e}") } else { format!("{v:.2}") }
}

/// Makes the page: the scenes in the order of [`CASES`], those with stiff links in the order of [`STIFF`], the claims,
/// and the machine.
pub fn page(found: &[Found], stiff: &[Found], claims: &[Claim], machine: &str) -> String {
    let mut t = format!("{HEAD}\nThe machine: {machine}.\n\n## What is expected\n\n");
    t += &head(&["what", "at most", "is", "holds"]);
    for c in claims {
        let holds = if c.holds() { "yes" } else { "**no**" };
        t += &line(&[c.what.clone(), shown(c.most), shown(c.is), holds.into()]);
    }
    for (case, f) in CASES.iter().zip(found) {
        let _ = write!(
            t,
            "\n## {}\n\n{}\n\n![{}](accuracy/{}.svg)\n\n",
            case.title,
            wrap(case.about),
            case.title,
            case.name
        );
        let _ = write!(t, "{}\n\n{}", wrap(&format!("{} s, against {}.", case.seconds, f.against)), table(f));
        for what in &f.reported {
            let _ = write!(t, "\n{}\n", wrap(what));
        }
    }
    t += "\n## Links beyond the limit\n\n";
    t += &wrap(
        "The plucked string with links spread over it that are 10⁶ times stiffer than the limit of two such masses, each \
          of them with `method = \"implicit\", theta = 0.25`, the others explicit. They stay in one row with the \
          explicit links, which then takes a little longer, and since no two of them share a mass each is solved \
          separately.",
    );
    t += "\n\n";
    t += &head(&["stiff links", "error", "energy", "ns", "over none", "stability"]);
    let none = stiff.first().and_then(|f| f.row("as written", 1)).map_or(f64::NAN, |r| r.ns);
    for (n, r) in STIFF.iter().zip(stiff).filter_map(|(n, f)| Some((n, f.row("as written", 1)?))) {
        let made = r.made.map_or("-".into(), small);
        let over = format!("{:.2}", r.ns / none);
        t += &line(&[n.to_string(), small(r.error), made, format!("{:.0}", r.ns), over, r.stability.clone()]);
    }
    t
}

/// Returns the rows of the table in a section of the page, cell by cell, without the header.
pub fn rows(page: &str, title: &str) -> Vec<Vec<String>> {
    let from = format!("\n## {title}\n");
    let Some((_, section)) = page.split_once(&from) else { return Vec::new() };
    let section = section.split("\n## ").next().unwrap_or(section);
    let lines = section.lines().filter(|l| l.starts_with('|')).skip(2);
    lines.map(|l| l.trim_matches('|').split(" | ").map(|c| c.trim().to_string()).collect()).collect()
}
