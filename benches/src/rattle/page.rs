//! Page `docs/measured/rattle-energy.md`: the format of its cells, which a test compares with the page.

use super::EnergyFigures;
use std::fmt::Write as _;

const HEAD: &str = "# How stiff may a contact be?

Made by `UPDATE=1 cargo bench -p ca-benches --bench rattle`: do not edit.

Three pyramids of four corners (1 g each, edges of 20 mm with k T²/m = 0.1) fly about in a hollow sphere of 50 g and
R = 50 mm, which moves too; corners of different pyramids keep 4 mm apart. Nothing is damped, so the energy should
stay constant. Each is played for 10 s at 48 kHz from three random sets of velocities.

- **kT²/m** is the stiffness of the contacts against the mass of one corner;
- **explicit** (`method = \"ca\"`): energy at the end over energy at the start, per set, or the time at which it
  exceeded 10⁷ times the start;
- **stable** (`method = \"stable3d\"`): the largest |E/E₀ − 1| at any tick, per set. The remaining error comes from the
  explicit springs of the pyramids, which keep energy to O(T²) and without drift;
- **ns** per tick of the whole scene, 18 springs and 60 contacts, without the energy ledger. These times are for the
  machine that made this page: on other machines only their ratios apply. A tick of real time is 20 833 ns.

| kT²/m | explicit: E/E₀ after 10 s | ns | stable: largest deviation of E | ns |
|---|---|---|---|---|
";

/// Formats the energy of an explicit run.
pub fn ended(f: &EnergyFigures) -> String {
    if f.worst.is_finite() { format!("{:.4}", f.end) } else { format!("diverged after {:.2} s", f.seconds) }
}

/// Formats the energy of a stable run.
pub fn strayed(f: &EnergyFigures) -> String {
    format!("{:.1e}", f.worst)
}

/// Formats a row of the table; `None` stands for a time that was not measured.
pub fn row(a: f64, explicit: &[EnergyFigures], first: Option<f64>, stable: &[EnergyFigures], second: f64) -> String {
    let cells =
        |of: fn(&EnergyFigures) -> String, runs: &[EnergyFigures]| runs.iter().map(of).collect::<Vec<_>>().join(", ");
    let mut t = String::new();
    let first = first.map_or("–".into(), |ns| format!("{ns:.0}"));
    let (one, two) = (cells(ended, explicit), cells(strayed, stable));
    let _ = writeln!(t, "| {a} | {one} | {first} | {two} | {second:.0} |");
    t
}

/// Makes the page.
pub fn page(table: &str) -> String {
    format!("{HEAD}{table}")
}
