//! CLOUD: a body given by points, from a file of a common 3-D format or written out.
//!
//! Every point is a mass, in the order of the file, so `bell[17]` is point 17 of the drawing. The springs are the edges
//! of the drawing, each once, or with `reach` join all near points. Their stiffness is equal: a drawing has no
//! thickness.

use super::pose::{Pose, SPIN, TURN, V};
use super::string::{K, M, M_TOTAL, MANY, MASSES, mass};
use super::tetra::Z;
use alloc::borrow::Cow;
use alloc::vec::Vec;
use ca_core::internal::kind::builder::{Args, Builder, Generator, Problem};
use ca_core::internal::kind::cloud::Cloud;
use ca_core::internal::mat::X;
use ca_core::{ABOVE_ZERO, Kind, Need, OneOf, Param, Role, Type, Unit};

/// CLOUD in the catalog.
pub static KIND: Kind = Kind {
    code: "CLOUD",
    title: "cloud of points",
    equation: "a MAS per point; with `k`, a REF per edge",
    doc: "A body with a mass at every point of a file (PLY, OBJ, or CSV with a point in each row) or of a list. \
          Springs follow the edges of the faces and lines of the file, or with `reach` join all near points. They are \
          slack at rest. Points at the same position are merged; faces without area are left out. `bell[17]` is point \
          17 of the file. `x` is the position of its origin, about which the body turns and spins.",
    source: &["CMJ 1993"],
    params: &[
        Param::new(
            "file",
            Type::File,
            Need::Optional,
            "a .ply, .obj or .csv file, relative to the folder of the model",
        ),
        Param::new("points", Type::Positions { unit: Unit::METRE }, Need::Optional, "list of the points"),
        Param::number("scale", Unit::NONE, ABOVE_ZERO, Need::Default(1.0), "metres per unit of the file or list")
            .for_good(),
        M,
        M_TOTAL,
        K,
        Z,
        Param::number(
            "reach",
            Unit::METRE,
            ABOVE_ZERO,
            Need::Optional,
            "largest distance of joined points, instead of the edges of the file; a little more than the spacing",
        )
        .for_good(),
        X,
        V,
        TURN,
        SPIN,
    ],
    one_of: &[OneOf { sets: &[&["file"], &["points"]], required: true }, MASSES],
    example: r#"
[room]
dim = 3
[room.CLOUD]
star = { points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], scale = 0.02, reach = "4 cm", m = "1 g", k = "8 kN/m", z = "2 mN s/m" }
[room.MAS]
stick = { m = "5 g", x = ["1 cm", "1 cm", "4 cm"], v = [0, 0, "-2 m/s"] }
[room.BUT]
strike = { between = ["room.stick", "room.star[*]"], k = "30 kN/m", z = "0.5 N s/m", d = "1.8 cm" }
[SOF]
out = { from = "room.star.link[0]", gain = 0.02 }
"#,
    role: Role::Generator(&Generator { dims: &[3], derive, build }),
};

/// Returns the points in units of their file.
fn cloud<'a>(a: &'a Args<'_>) -> Cow<'a, Cloud> {
    if let Some(c) = a.cloud("file") {
        return Cow::Borrowed(c);
    }
    let n = a.len("points").unwrap_or(0);
    let flat: Vec<f64> = a.list("points", n).into_iter().flatten().collect();
    Cow::Owned(Cloud { points: flat.as_chunks().0.to_vec(), ..Cloud::default() })
}

fn joined(a: &Args<'_>, cloud: &Cloud) -> Result<Vec<[u32; 2]>, Problem> {
    if a.num("k").is_none() {
        return Ok(Vec::new());
    }
    let wrong = |title: &str, param, help: &str| Err(Problem { title: title.into(), param, help: help.into() });
    let pairs = match a.num("reach") {
        Some(reach) => cloud.pairs_within(reach / a.or0("scale"), (MANY as usize).saturating_sub(cloud.points.len())),
        None => Some(cloud.edges.clone()),
    };
    match pairs {
        None => wrong("more pairs of points are within `reach` than a model can hold", "reach", "reduce `reach`"),
        Some(p) if p.is_empty() && a.num("reach").is_some() => {
            wrong("no two points are within `reach`", "reach", "increase `reach` to a little more than the spacing")
        }
        Some(p) if p.is_empty() => {
            wrong("the points are not joined by any edge", "k", "add `reach` to join near points, or leave out `k`")
        }
        Some(p) => Ok(p),
    }
}

/// Slots: m, k, z.
fn derive(a: &Args<'_>, slots: &mut Vec<Option<f64>>) -> Result<(), Problem> {
    super::tetra::springs(a)?;
    let points = a.cloud("file").map_or(a.len("points").unwrap_or(0) / 3, |c| c.points.len());
    slots.extend([Some(mass(a, points)), a.num("k"), a.num("z")]);
    Ok(())
}

fn build(a: &Args<'_>, b: &mut Builder<'_>) -> Result<(), Problem> {
    let (cloud, pose, scale) = (cloud(a), Pose::new(a), a.or0("scale"));
    for (i, p) in cloud.points.iter().enumerate() {
        b.mass(i, 0, u32::MAX);
        b.places.push(pose.place(p.map(|p| p * scale)));
        b.speeds.push(pose.speed(b.places[i]));
    }
    for [i, j] in joined(a, &cloud)? {
        b.link(i, j, 1, 2);
    }
    Ok(())
}
