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

The same networks played by the engine and by programs written for this comparison: Faust (`-double`, modules of
mi.lib, one program per network), flat C, C++ with an object per module, loops compiled by numba, and stencils written
by hand. All compiled programs use `-O3 -march=native -ffast-math`. Parameters differ from module to module, except in
the stencils, which have one set and fixed ends or edges. The engine loads a model and plays it in blocks of 64 ticks,
like any program that uses it as a library.

Before the timing, the output of each peer is compared with the engine, and the bench fails if they differ: over 4096
ticks to 1e-9 of the largest output, or 1e-7 in the mixture, whose bow is a table in the engine; in space, where
motion is chaotic, over 1024 ticks to 1e-6. Stencils are compared in a network that is as uniform as they are.

Times are processor time of one thread. All players of a network take turns, each as a process that plays 1024 ticks
from the start and then times those that follow; the fastest of all rounds counts. All are started six times, since
the location of a process in memory changes its time by up to a fifth. Ratios are between numbers of one run and stay
valid; ns are for one machine. A module is a MAT or a LIA; for grains each pair that may touch is one, though the
engine computes only the pairs that are near.
";

/// Text below the tables, about networks below expectation.
pub const SHORT: &str = "
Reasons for values beyond the limits, from passes (`ca check --schedule`), counted instructions (`benches/counts/run`)
and experiments:

- *Strings, in ns.* For eight masses the fused pass reads six vectors (place, motion, force, and three of parameters)
  and writes three: its speed is limited by the first-level cache at the present clock. Narrower vectors take longer
  (`CA_VECTORS=avx2 ca check --schedule`). Storing parameters once for a run of equal modules would fix it, as below.
- *64 CEL with 64 outputs.* Most of the tick is the outputs: they are added to one channel in the order of the
  document, and each addition waits for the one before. Partial sums would be faster, but have other bits.
- *Mesh beside the stencil.* The stencil has one set of parameters, the engine reads the parameters of each link and
  mass: more numbers per tick than there are positions. Storing parameters once for a run of equal modules would fix
  it, but needs another kernel for each form.
- *Random.* A link adds its force at two places that are looked up, and the next may need what has just been written:
  the tick waits for its own stores. A quarter fewer instructions did not save time, and neither did a first pass of
  forces with sums by mass after it. Sets of links that do not share a mass (a colouring) could run in vectors; their
  sums have another order, so other bits.
- *Mixture.* Short passes, each with a fixed cost besides its modules, and a bow, whose table is looked up for one
  link at a time.
- *Cloth and random in space.* Four points at a time are loaded into lanes number by number, and forces are added back
  in the same way; roots and divisions take less time. Points of four numbers, one per vector, would fix it, but need
  another layout of the state for all passes.
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
    t += "\nA cell `> 120 s` is a compiler run, of Faust or of what it made, that was stopped after this time; `not here` is a\n\
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
