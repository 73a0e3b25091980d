//! Page `docs/measured/costs.md`: the format of its rows, which a test compares with the page.

use super::{CostRow, Without};
use std::fmt::Write as _;

/// Text above the tables.
pub const HEAD: &str = "# What it costs

Made by `UPDATE=1 cargo bench -p ca-benches --bench costs`: do not edit.

The cost of each guard, check and method, and the proof that a scene without it has no extra cost. A cost is a
difference: a scene with the feature minus the same scene without it, divided by the number of modules that have it.
It includes every effect on the compiled scene; a negative cost means faster. Methods are beside `ca`, the explicit
scheme of the same modules.

**Instructions** are counted by valgrind (callgrind) in runs of two lengths, whose difference excludes start and end:
they do not depend on the load of the machine. **ns** are the best of many short runs in one process, with and without
the feature in turn; the rows of 0 instructions show the error of these times.

**A scene without it** has no extra cost, by one of these proofs, and the bench fails if a proof does not apply:

- *counted*: the same scene with the feature in the file, but without an output or with a value of no effect, has the
  same count of instructions in each tick, to 0.05, and the same passes and the same state;
- *no pass*: it cannot be in a file without being used; a scene without it lacks its passes and its numbers in the
  state;
- *outside*: the program that plays the scene requests it, outside of the passes of the scene;
- *no device*: it belongs to a device, or to a device whose profile requests it; other engines do not have its stage.
";

const COLUMNS: &str =
    "| thing | with what | instructions per module and tick | ns per module and tick | a scene without it pays |";
const FRAMES: &str = "
## At the hand

The cost of a gesture frame in normal operation, for a device of twelve keys with every stage of the guard, forces on
and slow motion within all limits, at 3000 frames a second and 16 ticks each. Each stage is measured alone. H7 and H14
are fields of the force frame, included in the cost of a device; H17 applies only at the start, and H18 is the absence
of operations. Ring buffers pass the records of an engine's loop to another thread, which writes the take; frames do
not wait for it.
";
const ALWAYS: &str = "
## What every scene pays

One check is in every scene: every 1024 ticks, negligibly small numbers are set to 0 before they become denormal and
slow.
";

/// Measurements of a row.
#[derive(Clone, Copy, Debug, Default)]
pub struct Price {
    /// Instructions per module and tick or frame.
    pub instructions: f64,
    /// Time \[ns\] per module and tick or frame.
    pub ns: f64,
    /// Instructions per tick or frame of a scene that has the thing where it reaches no output, if they were counted.
    pub unheard: Option<f64>,
}

impl Price {
    /// Largest count per tick that may be due to rounding.
    pub const NOTHING: f64 = 0.05;

    /// Returns true if a scene without the thing pays for it.
    pub fn is_paid_by_others(&self) -> bool {
        self.unheard.is_some_and(|n| n.abs() > Price::NOTHING)
    }
}

/// Returns the name of the proof on the page.
pub fn proof(without: &Without) -> &'static str {
    match without {
        Without::Unheard(_) => "0, counted",
        Without::Absent(..) => "0, no pass",
        Without::Outside => "0, outside",
        Without::Device(..) => "0, no device",
        Without::Always => "",
    }
}

fn number(v: f64) -> String {
    let text = if v.abs() < 10.0 { format!("{v:.2}") } else { format!("{v:.0}") };
    text.replace("-0.00", "0.00").replace('-', "−")
}

/// Formats a row of a table.
pub fn line(row: &CostRow, price: &Price) -> String {
    let CostRow { thing, with, without, .. } = row;
    let mut cells = format!("| {thing} | {with} | {} | {} |", number(price.instructions), number(price.ns));
    if price.is_paid_by_others() {
        let _ = write!(cells, " {} |", number(price.unheard.unwrap_or(0.0)));
    } else if !matches!(without, Without::Always) {
        let _ = write!(cells, " {} |", proof(without));
    }
    cells
}

/// Makes the page; `machine` describes the machine of the times.
pub fn page(rows: &[CostRow], prices: &[Price], machine: &str) -> String {
    let mut t = format!("{HEAD}\nThe machine of this page is {machine}.\n\n## In the tick\n");
    let priced = |t: &mut String, head: &str, which: fn(&CostRow) -> bool| {
        let n = head.matches('|').count() - 1;
        let _ = write!(t, "\n{head}\n|{}\n", "---|".repeat(n));
        for (row, price) in rows.iter().zip(prices).filter(|(row, _)| which(row)) {
            let _ = writeln!(t, "{}", line(row, price));
        }
    };
    let always = |row: &CostRow| matches!(row.without, Without::Always);
    priced(&mut t, COLUMNS, |row| !row.used.is_hand() && !matches!(row.without, Without::Always));
    t += FRAMES;
    priced(&mut t, &COLUMNS.replace("module and tick", "device and frame"), |row| row.used.is_hand());
    t += ALWAYS;
    let short = COLUMNS.trim_end_matches(" a scene without it pays |");
    priced(&mut t, short, always);
    t
}
