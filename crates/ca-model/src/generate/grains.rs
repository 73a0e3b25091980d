//! GRAINS: many loose masses around a place, such as the seeds of a maraca, gravel, hail.
//!
//! Masses are on a cubic lattice of spacing `gap`, nearest to the centre first, equally near ones in the order of x, y,
//! z. Random places would vary the sound and could overlap at the start, and a rattle mixes its grains anyway.

use super::pose::{Pose, V};
use super::string::{M, M_TOTAL, MASSES, mass};
use alloc::vec::Vec;
use ca_core::internal::kind::builder::{Args, Builder, Generator, Problem};
use ca_core::internal::mat::X;
use ca_core::{ABOVE_ZERO, Kind, Need, Param, Role, Type, Unit};

/// GRAINS in the catalog.
pub static KIND: Kind = Kind {
    code: "GRAINS",
    title: "loose masses",
    equation: "n MAS on a cubic lattice around x",
    doc: "Many loose masses on a lattice of spacing `gap` around `x`, in order of distance from `x`. A `BUT` with \
          `sense = \"inside\"` to a centre keeps them together; one between `[\"g[*]\", \"g[*]\"]` keeps them apart.",
    source: &["ICMC 2013"],
    params: &[
        Param::new("n", Type::Count { min: 1, max: 100_000 }, Need::Required, "number of masses"),
        M,
        M_TOTAL,
        Param::number("gap", Unit::METRE, ABOVE_ZERO, Need::Required, "distance between neighbours on the lattice")
            .for_good(),
        X,
        V,
    ],
    one_of: &[MASSES],
    example: r#"
[room]
dim = 3
gravity = "9.81 m/s^2"
[room.GRAINS]
hail = { n = 20, m = "0.1 g", gap = "8 mm", v = ["0.3 m/s", 0, 0] }
[room.SOL]
centre = {}
[BUT]
bowl = { between = ["room.centre", "room.hail[*]"], k = "2 kN/m", z = "20 mN s/m", d = "4 cm", sense = "inside" }
apart = { between = ["room.hail[*]", "room.hail[*]"], k = "2 kN/m", z = "20 mN s/m", d = "5 mm" }
[SOF]
out = { from = "room.centre", along = "z", gain = 0.1 }
"#,
    role: Role::Generator(&Generator { dims: &[2, 3], derive, build }),
};

/// Slots: m.
#[allow(clippy::unnecessary_wraps)] // the shape all generators have
fn derive(a: &Args<'_>, slots: &mut Vec<Option<f64>>) -> Result<(), Problem> {
    slots.extend([Some(mass(a, a.count("n")))]);
    Ok(())
}

/// Returns the first `n` points of a cubic lattice of `dim` axes, by distance from the origin.
fn lattice(n: usize, dim: u8) -> Vec<[i32; 3]> {
    let inside = |r: i32| {
        let flat = if dim == 3 { r } else { 0 };
        let all = (-r..=r).flat_map(move |x| (-r..=r).flat_map(move |y| (-flat..=flat).map(move |z| [x, y, z])));
        all.filter(move |p| p.iter().map(|v| v * v).sum::<i32>() <= r * r)
    };
    // the smallest ball with enough points; for 100 000 its radius is 29
    let r = (0..n as i32).find(|r| inside(*r).count() >= n).unwrap_or(0);
    let mut all: Vec<[i32; 3]> = inside(r).collect();
    all.sort_by_key(|p| (p.iter().map(|v| v * v).sum::<i32>(), *p));
    all.truncate(n);
    all
}

fn build(a: &Args<'_>, b: &mut Builder<'_>) -> Result<(), Problem> {
    let (pose, gap) = (Pose::new(a), a.or0("gap"));
    for (i, p) in lattice(a.count("n"), a.dim).into_iter().enumerate() {
        b.mass(i, 0, u32::MAX);
        b.places.push(p.map(|v| f64::from(v) * gap));
        b.speeds.push(pose.speed(b.places[i]));
    }
    Ok(())
}
