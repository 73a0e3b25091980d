//! MESH: masses on a rectangular grid, linked to their neighbours.
//!
//! Modes with a = kT²/m: closed, λ_pq = 4a (sin²(pπ/(2(nx−1))) + sin²(qπ/(2(ny−1)))), p, q ≥ 1; open,
//! λ_pq = 4a (sin²(pπ/(2nx)) + sin²(qπ/(2ny))), p + q ≥ 1. For a given `f` the lowest is inverted exactly. a < 1/2 is
//! stable for every size. Source: SMC 2019 (mesh, closedMesh, cornerMesh).
//!
//! In space the springs are radial and shorter at rest than the spacing: l0 = (1 − stretch) dx. Each pulls with
//! k (dx − l0), and a small transverse displacement meets tension/dx = stretch · k. So transverse modes are those above
//! with that stiffness, and `f` is the lowest of them. In the plane the stiffness of a spring is k; both together need
//! (1 + stretch) a ≤ 1. Shear springs lie along the diagonals, slack at rest, and do not change transverse modes. A
//! stretched mesh is in balance only if it is held all around.

use super::pose::{Pose, TURN};
use super::string::{DECAY, F, K, M, M_TOTAL, MASSES, T60, TUNING, Z, ZO, ground, mass, target, too_stiff};
use crate::quantity::Plain;
use alloc::format;
use alloc::vec::Vec;
use ca_core::internal::kind::builder::{Args, Builder, Generator, Problem};
use ca_core::internal::mat::X;
use ca_core::{ABOVE_ZERO, Kind, Need, POSITIVE, Param, Role, Type, Unit};

const SIDE: Type = Type::Count { min: 2, max: 4096 };

ca_core::choice! {
    /// Support of the border.
    enum Edges {
        Open = "open",
        /// Fixed points all around.
        Closed = "closed",
        /// Fixed points at its four corners.
        Corner = "corner",
    }
}

/// MESH in the catalog.
pub static KIND: Kind = Kind {
    code: "MESH",
    title: "rectangular mesh",
    equation: "nx × ny MAS, REF between neighbours; border open, closed or fixed at the corners",
    doc: "A membrane (`edges = \"closed\"`), a plate-like sheet with free edges (`open`) or a sheet fixed at its \
          corners (`corner`). `skin[3,4]` is a node, `skin@0.3,0.4` a point that can move. In a group with `dim = 3` \
          the mesh lies in the x–y plane: node [0,0] is at `x`, the nodes are `dx` apart, and `turn` rotates the mesh \
          about `x`. There `stretch` makes transverse vibration possible, and `f` is the lowest transverse mode.",
    source: &["SMC 2019"],
    params: &[
        Param::new("nx", SIDE, Need::Required, "nodes along the first direction"),
        Param::new("ny", SIDE, Need::Required, "nodes along the second direction"),
        M,
        M_TOTAL,
        K,
        F,
        Z,
        ZO,
        T60,
        Param::new("edges", Type::Choice(Edges::WORDS), Need::Default(0.0), "support of the border"),
        Param::new("fixed", Type::Nodes, Need::Optional, "additional fixed nodes, e.g. [[0, 0], [-1, -1]]"),
        X,
        Param::number("dx", Unit::METRE, ABOVE_ZERO, Need::Optional, "spacing of the nodes; needed in space")
            .for_good(),
        Param::number(
            "stretch",
            Unit::NONE,
            (0.0, 1.0),
            Need::Optional,
            "in space: how much shorter than `dx` the springs are at rest, e.g. \"10 %\"",
        )
        .for_good(),
        Param::number(
            "shear",
            Unit::STIFFNESS,
            POSITIVE,
            Need::Optional,
            "in space: stiffness of springs along diagonals",
        ),
        TURN,
    ],
    one_of: &[MASSES, TUNING, DECAY],
    example: r#"
[MESH]
skin = { nx = 10, ny = 8, f = "150 Hz", t60 = "1 s", m = "0.5 g", edges = "closed" }
[MAS]
stick = { m = "10 g", x = "-1 mm", v = "1 m/s" }
[BUT]
strike = { between = ["stick", "skin[4,3]"], k = "10 kN/m", z = "1 N s/m" }
[SOX]
out = { from = "skin[2,2]", gain = 200 }
"#,
    role: Role::Generator(&Generator { dims: &[1, 3], derive, build }),
};

/// Refuses parameters that do not fit the dimension of the mesh.
fn fits(a: &Args<'_>) -> Result<(), Problem> {
    let no = |title: &str, param, help: &str| Err(Problem { title: title.into(), param, help: help.into() });
    let closed = Edges::of(a.num("edges")) == Edges::Closed;
    if a.dim == 1 {
        return match ["dx", "stretch", "shear", "turn"].into_iter().find(|p| a.is_written(p)) {
            Some(p) => {
                no("a mesh on a line has no extent", p, "leave it out, or put the mesh into a group with `dim = 3`")
            }
            None => Ok(()),
        };
    }
    if a.num("dx").is_none() {
        return no("a mesh in space needs `dx`", "dx", "add e.g. `dx = \"1 cm\"` (spacing of the nodes)");
    }
    if a.or0("stretch") > 0.0 && !closed {
        return no("only a mesh with a closed border can be stretched", "stretch", "use `edges = \"closed\"`");
    }
    if a.num("f").is_some() && a.or0("stretch") == 0.0 {
        return no(
            "`f` of a mesh in space needs `stretch`",
            "f",
            "add e.g. `stretch = \"10 %\"` and `edges = \"closed\"`, or give `k`",
        );
    }
    Ok(())
}

/// Slots: m, k, z, zo, shear.
fn derive(a: &Args<'_>, slots: &mut Vec<Option<f64>>) -> Result<(), Problem> {
    fits(a)?;
    let (nx, ny) = (a.count("nx"), a.count("ny"));
    let m = mass(a, nx * ny);
    let zo = ground(a, m);
    let k = match a.num("f") {
        None => a.or0("k"),
        Some(_) if a.len("fixed").unwrap_or(0) > 0 => {
            return Err(Problem {
                title: "the pitch of a mesh with `fixed` nodes has no closed form".into(),
                param: "f",
                help: "give `k`, or leave out `fixed`".into(),
            });
        }
        Some(f) => {
            let sin2 = |n: usize| {
                let s = libm::sin(core::f64::consts::FRAC_PI_2 / n as f64);
                s * s
            };
            let shape = match Edges::of(a.num("edges")) {
                Edges::Open => sin2(nx.max(ny)),
                Edges::Closed if nx > 2 && ny > 2 => sin2(nx - 1) + sin2(ny - 1),
                Edges::Closed => {
                    return Err(Problem {
                        title: "a closed mesh of this size has only fixed nodes".into(),
                        param: "nx",
                        help: "use at least 3 nodes in each direction".into(),
                    });
                }
                Edges::Corner => {
                    return Err(Problem {
                        title: "the pitch of a mesh fixed at its corners has no closed form".into(),
                        param: "f",
                        help: "give `k`, or use `edges = \"open\"` or `\"closed\"`".into(),
                    });
                }
            };
            let stiffness = target(a, f, zo, m)? / (4.0 * shape);
            // stiffness across a spring and along it, and their limit together
            let share = if a.dim == 1 { 1.0 } else { a.or0("stretch") };
            let along = stiffness / share;
            if stiffness + along > a.scheme.stability_limit() {
                let limit = share / (1.0 + share);
                let mut p = too_stiff(f, nx * ny, 0, false);
                p.param = "nx";
                p.help = format!(
                    "use fewer nodes, choose a lower pitch, or raise `rate.sound` (a = {:.3}, limit {limit:.3})",
                    Plain(stiffness)
                );
                return Err(p);
            }
            along * m / (a.tick_dt * a.tick_dt)
        }
    };
    slots.extend([Some(m), Some(k), a.num("z"), Some(zo), a.num("shear")]);
    Ok(())
}

/// Returns the nodes of `fixed`, counted from the start.
fn held(a: &Args<'_>, nx: usize, ny: usize) -> Result<Vec<[usize; 2]>, Problem> {
    let n = a.len("fixed").unwrap_or(0);
    let flat = a.list("fixed", n);
    let wrap = |v: Option<f64>, n: usize| {
        let v = v.unwrap_or(0.0);
        let at = if v < 0.0 { v + n as f64 } else { v };
        (at >= 0.0 && at < n as f64).then_some(at as usize)
    };
    let node = |pair: &[Option<f64>]| match (wrap(pair[0], nx), wrap(pair[1], ny)) {
        (Some(i), Some(j)) => Ok([i, j]),
        _ => Err(Problem {
            title: format!("a node of `fixed` is outside the mesh of {nx} × {ny}"),
            param: "fixed",
            help: format!("nodes go from [0, 0] to [{}, {}]", nx - 1, ny - 1),
        }),
    };
    flat.chunks_exact(2).map(node).collect()
}

fn build(a: &Args<'_>, b: &mut Builder<'_>) -> Result<(), Problem> {
    let (nx, ny, edges) = (a.count("nx"), a.count("ny"), Edges::of(a.num("edges")));
    let (dx, pose) = (a.num("dx"), Pose::new(a));
    let mut grid = Vec::with_capacity(nx * ny);
    let fixed = held(a, nx, ny)?;
    for i in 0..nx {
        for j in 0..ny {
            let (rim_x, rim_y) = (i == 0 || i == nx - 1, j == 0 || j == ny - 1);
            let held = fixed.contains(&[i, j])
                || match edges {
                    Edges::Open => false,
                    Edges::Closed => rim_x || rim_y,
                    Edges::Corner => rim_x && rim_y,
                };
            let index = [i, j];
            grid.push(if held { b.fixed(index) } else { b.mass(index, 0, 3) });
            if let Some(dx) = dx {
                b.places.push(pose.place([i as f64 * dx, j as f64 * dx, 0.0]));
            }
        }
    }
    let at = |i: usize, j: usize| grid[i * ny + j];
    let mut join = |from: u32, to: u32| match dx {
        Some(dx) => b.stretched(from, to, 1, 2, dx * (1.0 - a.or0("stretch"))),
        None => b.link(from, to, 1, 2),
    };
    for i in 0..nx {
        for j in 1..ny {
            join(at(i, j - 1), at(i, j));
        }
    }
    for i in 1..nx {
        for j in 0..ny {
            join(at(i - 1, j), at(i, j));
        }
    }
    if a.num("shear").is_some() {
        for (i, j) in (1..nx).flat_map(|i| (1..ny).map(move |j| (i, j))) {
            b.link(at(i - 1, j - 1), at(i, j), 4, u32::MAX);
            b.link(at(i, j - 1), at(i - 1, j), 4, u32::MAX);
        }
    }
    b.set_path(grid, [nx as u32, ny as u32]);
    Ok(())
}
