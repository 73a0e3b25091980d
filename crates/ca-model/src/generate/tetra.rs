//! TETRA: four masses at the corners of a regular tetrahedron, the smallest body that can tumble in space.
//!
//! Its corners are every other corner of a cube, so the centre is exact: with s = edge/√8,
//! 0 (s, s, s), 1 (s, −s, −s), 2 (−s, s, −s), 3 (−s, −s, s). Six springs, slack at rest, are in the order
//! 01 02 03 12 13 23. Stretching modes are λ = kT²/m · (4; 2, 2, 2; 1, 1), so a body alone is stable for kT²/m < 1
//! (docs/numerics.md §4.2). Without springs an author links the corners freely, e.g. by LPR between `["p[*]", "p[*]"]`,
//! which makes the six pairs in that order.

use super::pose::{Pose, SPIN, TURN, V};
use super::string::{K, M, M_TOTAL, MASSES, mass};
use alloc::vec::Vec;
use ca_core::internal::kind::builder::{Args, Builder, Generator, Problem};
use ca_core::internal::mat::X;
use ca_core::{ABOVE_ZERO, Kind, Need, POSITIVE, Param, Role, Unit};

pub(super) const Z: Param = Param::number("z", Unit::VISCOSITY, POSITIVE, Need::Optional, "viscosity of each link");

/// TETRA in the catalog.
pub static KIND: Kind = Kind {
    code: "TETRA",
    title: "tetrahedron",
    equation: "4 MAS; with `k`, 6 REF between all of them",
    doc: "Four masses at the corners of a regular tetrahedron around `x`. With `k`, six springs `p.link[0]` to \
          `p.link[5]` join the corners 01 02 03 12 13 23. Without `turn`, and with s = edge/√8 from the centre, \
          corner 0 is at (s, s, s), 1 at (s, −s, −s), 2 at (−s, s, −s), 3 at (−s, −s, s).",
    source: &["Rattle"],
    params: &[
        Param::number("edge", Unit::METRE, ABOVE_ZERO, Need::Required, "length of each edge").for_good(),
        M,
        M_TOTAL,
        K,
        Z,
        X,
        V,
        TURN,
        SPIN,
    ],
    one_of: &[MASSES],
    example: r#"
[room]
dim = 3
gravity = [0, 0, "-9.81 m/s^2"]
[room.TETRA]
p = { edge = "2 cm", m = "1 g", k = "8 kN/m", z = "5 mN s/m", x = [0, 0, "5 cm"], spin = ["3 Hz", 0, 0] }
[room.SOL]
floor = {}
[room.BUT]
fall = { between = ["room.floor", "room.p[*]"], k = "20 kN/m", z = "0.5 N s/m", along = "z" }
[SOF]
out = { from = "room.p.link[0]", gain = 0.1 }
"#,
    role: Role::Generator(&Generator { dims: &[3], derive, build }),
};

/// Refuses viscosity without springs.
pub(super) fn springs(a: &Args<'_>) -> Result<(), Problem> {
    if a.num("k").is_some() || a.num("z").is_none() {
        return Ok(());
    }
    let title = "`z` without `k`: there are no springs to damp".into();
    Err(Problem { title, param: "z", help: "add `k`, or leave out `z`".into() })
}

/// Slots: m, k, z.
fn derive(a: &Args<'_>, slots: &mut Vec<Option<f64>>) -> Result<(), Problem> {
    springs(a)?;
    slots.extend([Some(mass(a, 4)), a.num("k"), a.num("z")]);
    Ok(())
}

fn build(a: &Args<'_>, b: &mut Builder<'_>) -> Result<(), Problem> {
    let (pose, s) = (Pose::new(a), a.or0("edge") / libm::sqrt(8.0));
    for (i, corner) in [[s, s, s], [s, -s, -s], [-s, s, -s], [-s, -s, s]].into_iter().enumerate() {
        b.mass(i, 0, NONE);
        b.places.push(pose.place(corner));
        b.speeds.push(pose.speed(b.places[i]));
    }
    if a.num("k").is_some() {
        for [i, j] in [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]] {
            b.link(i, j, 1, 2);
        }
    }
    Ok(())
}

/// Marks a missing slot: no viscosity to ground.
const NONE: u32 = u32::MAX;
