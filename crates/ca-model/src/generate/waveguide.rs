//! WAVEGUIDE: a string of travelling waves with junctions, where links act on it.
//!
//! At a junction between two sides of impedance Z, with v = (x' − x1)/2T,
//! m (x' − 2x + x1)/T² = f + 2Z (v₁ + v₂) − 2Z v, and v − vᵢ leaves on side i (docs/numerics.md §7.2). With f alone on
//! the right this is a mass of m + ZT with a damper of 2Z. So a junction *is* a CEL without spring, with three
//! coefficients like any MAT, and S = M − ¼T²K − ½TC of a network counts it with m: all rules for masses apply to it.
//!
//! Delays, loss and tuning are in [`ca_core::internal::tuning::wave`]. A waveguide is passive with any links that are
//! stable with masses of m. Source: HSP v2 (`DWG-end~`, `ex-junct~`); the mass makes passive what `ex-junct~` is not.
//! Test: G01 to G03.

use crate::quantity::Plain;
use alloc::format;
use alloc::vec::Vec;
use ca_core::internal::kind::builder::{Args, Builder, Generator, Problem};
use ca_core::internal::mat::X;
use ca_core::internal::tuning::wave::{HighDecay, WaveguideSpec, tune};
use ca_core::{ABOVE_ZERO, Kind, Need, OneOf, Param, Role, Type, Unit};

const fn number(name: &'static str, unit: Unit, need: Need, doc: &'static str) -> Param {
    Param::number(name, unit, ABOVE_ZERO, need, doc).for_good()
}

/// WAVEGUIDE in the catalog.
pub static KIND: Kind = Kind {
    code: "WAVEGUIDE",
    title: "digital waveguide",
    equation: "m (x' - 2x + x1)/T² = f + 2z (v1 + v2) - z (x' - x1)/T;  v1, v2 the incoming waves",
    doc: "A string of travelling waves, harmonic up to the highest partial; its cost does not depend on its length. \
          Its junctions are masses at the places `at`: `low[0]` is the first, `low[1]` the next. Any link, force or \
          output can use them like other masses. Pitch and decay of the fundamental are exact, including the masses of the \
          junctions. The places are exact to half a sample of a round trip.",
    source: &["HSP v2", "Bilbao 2009"],
    params: &[
        number("f", Unit::HERTZ, Need::Required, "fundamental frequency, exact at every sound rate"),
        number("t60", Unit::SECOND, Need::Optional, "time to decay by 60 dB at `f`; no decay if omitted"),
        number("t60_high", Unit::SECOND, Need::Optional, "time to decay by 60 dB at `f_high`; as at `f` if omitted"),
        number("f_high", Unit::HERTZ, Need::Default(5000.0), "second frequency at which the decay is given"),
        number("z", Unit::VISCOSITY, Need::Optional, "wave impedance, sqrt(tension · mu)"),
        number("tension", Unit::NEWTON, Need::Optional, "tension, given with `mu`"),
        number("mu", Unit::LINEAR_DENSITY, Need::Optional, "mass per length, given with `tension`"),
        Param::new(
            "at",
            Type::Numbers { unit: Unit::NONE, min: 0.0, max: 1.0 },
            Need::Required,
            "places of the junctions, increasing, from 0 (near end) to 1 (far end)",
        ),
        number("m", Unit::KILOGRAM, Need::Optional, "mass of each junction; if omitted, the mass that its links need"),
        X,
    ],
    one_of: &[OneOf { sets: &[&["z"], &["tension", "mu"]], required: true }],
    example: r#"
[WAVEGUIDE]
low = { f = "110 Hz", t60 = "5 s", t60_high = "0.8 s", z = "0.8 N s/m", at = [0.12, 0.7], m = "18 mg" }
[MAS]
hammer = { m = "4 g", x = "-1 mm", v = "1 m/s" }
[BUT]
strike = { between = ["hammer", "low[0]"], k = "20 kN/m", z = "0.2 N s/m" }
[SOX]
out = { from = "low[1]", gain = 200 }
"#,
    role: Role::Generator(&Generator { dims: &[1], derive, build }),
};

/// Returns the requested string in SI units.
fn spec(a: &Args<'_>) -> Result<WaveguideSpec, Problem> {
    let problem = |param, title, help: &str| Err(Problem { title, param, help: help.into() });
    let (f, t60, high) = (a.or0("f"), a.num("t60"), a.num("t60_high"));
    let z = match (a.num("z"), a.num("tension"), a.num("mu")) {
        (Some(z), ..) => z,
        (_, Some(tension), Some(mu)) => libm::sqrt(tension * mu),
        _ => return problem("tension", "`tension` needs `mu`".into(), "add e.g. `mu = \"1 g/m\"`, or give `z`"),
    };
    let top = a.or0("f_high");
    match (t60, high) {
        (None, Some(_)) => return problem("t60_high", "`t60_high` needs `t60`".into(), "add e.g. `t60 = \"4 s\"`"),
        (Some(low), Some(high)) if high > low => {
            return problem(
                "t60_high",
                format!("{} s is longer than the {} s of `t60`", Plain(high), Plain(low)),
                "choose at most `t60`: high partials cannot decay more slowly than low ones",
            );
        }
        (_, Some(_)) if !(f < top && top * a.tick_dt < 0.5) => {
            let title = format!("`f_high`, {} Hz, is not between `f` and half the sound rate", Plain(top));
            return problem(
                "f_high",
                title,
                &format!("choose one between {} and {} Hz", Plain(f), Plain(0.5 / a.tick_dt)),
            );
        }
        _ => {}
    }
    let at: Vec<f64> = a.list("at", a.len("at").unwrap_or(1)).into_iter().flatten().collect();
    let t60 = t60.unwrap_or(f64::INFINITY);
    Ok(WaveguideSpec { f, t60, high: high.map(|t60| [top, t60]), z, at, m: a.num("m") })
}

/// Slots: the damper that both sides form at a junction, then each junction as a CEL.
fn derive(a: &Args<'_>, slots: &mut Vec<Option<f64>>) -> Result<(), Problem> {
    let asked = spec(a)?;
    let masses = alloc::vec![asked.mass(0.0, a.tick_dt); asked.at.len()];
    tune(&asked, &masses, a.tick_dt, HighDecay::Pole)?;
    slots.push(Some(2.0 * asked.z));
    slots.extend(masses.iter().map(|m| Some(asked.cell(*m, a.tick_dt))));
    Ok(())
}

fn build(a: &Args<'_>, b: &mut Builder<'_>) -> Result<(), Problem> {
    let asked = spec(a)?;
    for i in 0..asked.at.len() {
        b.mass(i, 1 + i as u32, 0);
    }
    b.line = Some(asked);
    Ok(())
}
