//! BANK: cells side by side, one for each partial, e.g. the modes of a bell, a bar or a gong.
//!
//! Every cell is a CEL by f and t60 (docs/numerics.md §1.5), so pitch and decay are exact at any sound rate.

use alloc::format;
use alloc::vec::Vec;
use ca_core::internal::kind::builder::{Args, Builder, Generator, Problem};
use ca_core::internal::mat::X;
use ca_core::{ABOVE_ZERO, Kind, Need, Param, Role, Type, Unit};

const fn numbers(unit: Unit) -> Type {
    Type::Numbers { unit, min: ABOVE_ZERO.0, max: ABOVE_ZERO.1 }
}

/// BANK in the catalog.
pub static KIND: Kind = Kind {
    code: "BANK",
    title: "bank of cells",
    equation: "one CEL per frequency",
    doc: "Parallel cells, each with its frequency, decay time and mass. Give lists of equal length, or one value for \
          all. Links can couple the cells, or strike several at once.",
    source: &["HSP v2"],
    params: &[
        Param::new("f", numbers(Unit::HERTZ), Need::Required, "frequencies, exact at every sound rate"),
        Param::new("t60", numbers(Unit::SECOND), Need::Optional, "times to decay by 60 dB"),
        Param::new("m", numbers(Unit::KILOGRAM), Need::Required, "inertias"),
        X,
    ],
    one_of: &[],
    example: r#"
[BANK]
bell = { f = ["440 Hz", "881 Hz", "1217 Hz"], t60 = ["3 s", "2 s", "1 s"], m = "5 g" }
[MAS]
hammer = { m = "5 g", x = "-1 mm", v = "1 m/s" }
[BUT]
strike = { between = ["hammer", "bell[*]"], k = "30 kN/m", z = "0.5 N s/m" }
[SOX]
out = { from = "bell[0]", gain = 300 }
"#,
    role: Role::Generator(&Generator { dims: &[1], derive, build }),
};

/// Slots: m, f, t60 of cell 0, of cell 1, …
fn derive(a: &Args<'_>, slots: &mut Vec<Option<f64>>) -> Result<(), Problem> {
    let n = a.len("f").unwrap_or(1);
    for other in ["t60", "m"] {
        if let Some(len) = a.len(other).filter(|len| *len != n) {
            return Err(Problem {
                title: format!("`{other}` has {len} number{}, but `f` has {n}", if len == 1 { "" } else { "s" }),
                param: if other == "m" { "m" } else { "t60" },
                help: "give one number for each frequency, or one for all".into(),
            });
        }
    }
    if let Some(high) = (0..n).filter_map(|i| a.nth("f", i)).find(|f| f * a.tick_dt >= 0.5) {
        return Err(Problem {
            title: format!("{high} Hz is not below half the sound rate"),
            param: "f",
            help: format!("stay below {} Hz, or raise `rate.sound`", 0.5 / a.tick_dt),
        });
    }
    slots.extend((0..n).flat_map(|i| ["m", "f", "t60"].map(|name| a.nth(name, i))));
    Ok(())
}

fn build(a: &Args<'_>, b: &mut Builder<'_>) -> Result<(), Problem> {
    for i in 0..a.len("f").unwrap_or(1) {
        let s = 3 * i as u32;
        b.cell(i, s, s + 1, s + 2);
    }
    Ok(())
}
