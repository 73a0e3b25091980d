//! Page `docs/measured/peers.md`, or `peers-avx2.md` without AVX-512: the table of times, the table of ratios with
//! their expectations, and the format of rows.

use super::build::Without;
use super::{Case, Target};
use std::fmt::Write as _;

/// Players, in the order of the columns.
pub const PEERS: [&str; 9] = [
    "Faust, clang",
    "Faust, g++",
    "flat C, clang",
    "flat C, gcc",
    "boxed C++, clang",
    "boxed C++, g++",
    "numba",
    "stencil, damped",
    "stencil, undamped",
];

/// Columns of Faust, of flat C, and of the damped stencil.
const FAUST: [usize; 2] = [0, 1];
const FLAT: [usize; 2] = [2, 3];
const STENCIL: usize = 7;

/// Time of a tick \[ns\], or the reason why there is none.
pub type Time = Result<f64, Without>;

/// Measurements of a network.
pub struct Row {
    /// Name of the network.
    pub name: String,
    /// Number of MATs and LIAs; for grains with each pair that may touch.
    pub modules: usize,
    /// Time of a tick of the engine \[ns\].
    pub engine: f64,
    /// Times of [`PEERS`], `None` for a peer that cannot play the network.
    pub peers: [Option<Time>; PEERS.len()],
    /// Expectation.
    pub target: Target,
}

/// A figure with its expectation.
pub struct Claim {
    /// Name of the figure.
    pub what: &'static str,
    /// Measured value.
    pub is: f64,
    /// Expected value, with `true` for at least.
    pub target: Option<(f64, bool)>,
}

impl Claim {
    /// Returns true if it is as expected; `None` if nothing is expected.
    pub fn holds(&self) -> Option<bool> {
        self.target.map(|(target, least)| if least { self.is >= target } else { self.is <= target })
    }
}

impl Row {
    /// Makes a row without times.
    pub fn new(case: &Case) -> Row {
        let (name, modules, target) = (case.net.name.clone(), case.net.modules(), case.target);
        Row { name, modules, engine: f64::INFINITY, peers: [const { None }; PEERS.len()], target }
    }

    fn best(&self, of: &[usize]) -> Option<f64> {
        let times = of.iter().filter_map(|i| self.peers[*i].as_ref()?.as_ref().ok());
        times.copied().min_by(f64::total_cmp)
    }

    /// Returns the figures of the second table, in order; `None` without a peer to compare with.
    pub fn claims(&self, wide: bool) -> [Option<Claim>; 4] {
        let t = &self.target;
        let faust = t.faust_avx2.filter(|_| !wide).or(t.faust);
        let least = |v: Option<f64>| v.map(|v| (v, true));
        let most = |v: Option<f64>| v.map(|v| (v, false));
        let times = |what, of: &[usize], target| self.best(of).map(|b| Claim { what, is: b / self.engine, target });
        [
            // times are expected only with AVX-512, ratios on any machine
            Some(Claim {
                what: "ns a module",
                is: self.engine / self.modules as f64,
                target: most(t.module.filter(|_| wide)),
            }),
            times("times as fast as Faust", &FAUST, least(faust)),
            times("times as fast as flat C", &FLAT, least(t.flat)),
            self.best(&[STENCIL]).map(|b| Claim {
                what: "time over that of the damped stencil",
                is: self.engine / b,
                target: most(t.stencil),
            }),
        ]
    }
}

/// Text above the tables.
pub const HEAD: &str = "# Beside other ways to play the same

Made by `UPDATE=1 cargo bench -p ca-benches --bench peers`: do not edit.

The same networks by the engine and by programs of ours: Faust (`-double`, modules of mi.lib, one program a network), flat
C, C++ with an object a module, loops compiled by numba, and stencils by hand. All that is compiled has `-O3
-march=native -ffast-math`. Parameters differ from module to module, but in the stencils, which have one set and fixed
ends or edges. The engine loads a model and plays it, blocks of 64 ticks, as any program that has it as a library.

Before anything is timed, what each peer plays is compared with the engine, and the bench fails where they differ: over 4096
ticks to 1e-9 of the largest value heard, or 1e-7 in the mixture, whose bow is a table in the engine; in space, where
motion is chaotic, over 1024 ticks to 1e-6. Stencils are compared in a network that is as uniform as they are.

Times are processor time of one thread. All players of a network take turns, each as a process that plays 1024 ticks
from the start and then times those that follow; the quickest of all rounds counts. All are started six times, since where a
process has its memory makes up to a fifth of its time. Ratios are between numbers of one run
and last; ns are of one machine. A module is a MAT or a LIA; of
grains each pair that may touch is one, though only those that are near are computed by the engine.
";

/// Text below the tables, about networks below expectation.
pub const SHORT: &str = "
What is short of what is expected, by passes (`ca check --schedule`), counted instructions (`benches/counts/run`) and what was
tried:

- *Strings, in ns.* For eight masses the fused pass reads six vectors (place, motion, force, and three of parameters) and writes
  three: it is as fast as the first cache gives them, at the clock there is. Narrower vectors take
  longer (`CA_VECTORS=avx2 ca check --schedule`). Parameters kept once for a stretch of equal modules would mend it, as below.
- *64 CEL with 64 outputs.* Most of the tick is the outputs: they are added to one channel in the order of the document, and
  each addition waits for the one before. Sums in parts would be quicker, and have other bits.
- *Mesh beside the stencil.* The stencil has one set of parameters, the engine reads those of each link and mass: more numbers a
  tick than the positions are. Parameters kept once for a stretch of equal modules would mend it, at the price of another kernel for
  each form.
- *Random.* A link adds its force at two places that are looked up, and the next may need what has just been written: the tick waits
  for its own stores. A quarter fewer instructions brought no time, nor did forces first and sums by mass behind them. Links in
  colours, none of which share a mass, would run in vectors; their sums have another order, so other bits.
- *Mixture.* Short passes, each with what it costs around its modules, and a bow, whose table is looked up for one link at a time.
- *Cloth and random in space.* Four points at a time are brought into lanes number by number, and forces added back so; roots and
  divisions are the smaller part. Points of four numbers, one a vector, would mend it: another layout of the state for all passes.
";

fn number(v: f64) -> String {
    match v {
        ..1.0 => format!("{v:.3}"),
        ..10.0 => format!("{v:.2}"),
        _ => format!("{v:.0}"),
    }
}

fn cell(time: Option<&Time>) -> String {
    match time {
        None => "–".into(),
        Some(Ok(ns)) => number(*ns),
        Some(Err(Without::Missing(_))) => "not here".into(),
        Some(Err(Without::Late(s))) => format!("> {s} s"),
        Some(Err(Without::Failed(_))) => "fails".into(),
    }
}

fn claim(claim: Option<&Claim>) -> String {
    let Some(c) = claim else { return "–".into() };
    let is = number(c.is);
    match (c.target, c.holds()) {
        (Some((target, least)), Some(holds)) => {
            let (sign, holds) = (if least { "≥" } else { "≤" }, if holds { "holds" } else { "**not so**" });
            format!("{is} ({sign} {target}: {holds})")
        }
        _ => is,
    }
}

/// Makes the page; `machine` describes the machine and the compilers, `wide` is true with AVX-512.
pub fn page(rows: &[Row], machine: &str, wide: bool) -> String {
    let mut t = format!("{HEAD}\n{machine}\n\n## Time of a tick [ns]\n\n| network | modules | ca |");
    for peer in PEERS {
        let _ = write!(t, " {peer} |");
    }
    let _ = write!(t, "\n|{}\n", "---|".repeat(3 + PEERS.len()));
    for row in rows {
        let _ = write!(t, "| {} | {} | {} |", row.name, row.modules, number(row.engine));
        for time in &row.peers {
            let _ = write!(t, " {} |", cell(time.as_ref()));
        }
        t += "\n";
    }
    t += "\nA cell `> 120 s` is a compiler run, of Faust or of what it made, that was ended after so long; `not here` is a\n\
          compiler that this machine does not have; – is a network that a peer does not play.\n\
          \n## Beside what is expected\n\n\
          Against the better of the two compilers. In brackets what is expected, and whether it holds.\n\n\
          | network | ns a module | times as fast as Faust | times as fast as flat C | time over that of the damped stencil |\n\
          |---|---|---|---|---|\n";
    for row in rows {
        let _ = write!(t, "| {} |", row.name);
        for c in &row.claims(wide) {
            let _ = write!(t, " {} |", claim(c.as_ref()));
        }
        t += "\n";
    }
    t + SHORT
}
