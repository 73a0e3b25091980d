//! What generators draw in space: where things are, how they start, what they weigh and how they vibrate.

use crate::play::{mats, off, reference, scene, with, within};
use ca_core::{Scene, sense};

/// A body in a room, every mass of it tied to the origin first, so that the reach of the ties is where it is at rest.
fn room(body: &str) -> String {
    format!(
        "[room]\ndim = 3\n[room.SOL]\no = {{}}\n[room.RES]\ntie = {{ between = [\"room.o\", \"room.p[*]\"], k = 1e-9 }}\n\
         {body}\n[SOX]\nout = {{ from = \"room.p[*]\", along = \"x\" }}\n"
    )
}

/// Rest places of `p[0] …`, from the origin.
fn places(body: &str, n: usize) -> Vec<[f64; 3]> {
    let scene = with(&room(body), &reference());
    assert_eq!(mats(&scene, "room.p").len(), n);
    (0..n).map(|i| [0, 1, 2].map(|k| scene.layout.reach[i][k])).collect()
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|v| v * v).sum::<f64>().sqrt()
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn tetra(args: &str) -> String {
    format!("[room.TETRA]\np = {{ edge = \"2 cm\", m = \"1 g\", {args} }}\n")
}

#[test]
fn a_tetrahedron_is_regular_and_centred() {
    for turn in ["", ", turn = [0.3, -0.1, 0.07]", ", turn = [0, \"25 %\", 0]"] {
        let p = places(&tetra(&format!("x = [0.5, -0.25, 0.125]{turn}")), 4);
        for (i, j) in (0..4).flat_map(|i| (0..i).map(move |j| (i, j))) {
            // from places of 0.5 m, which round at 1e-16
            within("an edge", off(norm(minus(p[i], p[j])), 0.02), 1e-14);
        }
        for (k, c) in [0.5, -0.25, 0.125].into_iter().enumerate() {
            within("the centre", (p.iter().map(|p| p[k]).sum::<f64>() / 4.0 - c).abs(), 1e-16);
        }
    }
    let s = 0.02 / 8f64.sqrt();
    let p = places(&tetra(""), 4);
    assert_eq!(p, [[s, s, s], [s, -s, -s], [-s, s, -s], [-s, -s, s]]);
    for (i, j) in (0..4).flat_map(|i| (0..i).map(move |j| (i, j))) {
        within("an edge around the origin", off(norm(minus(p[i], p[j])), 0.02), 1e-15);
    }
    // a quarter turn about z takes x to y, exactly; five do the same
    for turns in ["25 %", "125 %", "-75 %"] {
        let q = places(&tetra(&format!("turn = [0, 0, \"{turns}\"]")), 4);
        assert!(p.iter().zip(&q).all(|(p, q)| [-p[1], p[0], p[2]] == *q), "{turns}: {q:?}");
    }
    // and a third of a turn about the diagonal takes x to y to z
    let third = 1.0 / 3.0 / 3f64.sqrt();
    let q = places(&tetra(&format!("turn = [{third:?}, {third:?}, {third:?}]")), 4);
    for (p, q) in p.iter().zip(&q) {
        within("a third of a turn", norm(minus([p[2], p[0], p[1]], *q)), 1e-17);
    }
}

#[test]
fn a_tetrahedron_starts_as_a_rigid_body() {
    let text = room(&tetra("v = [1, 2, -3], spin = [\"3 Hz\", \"-1 Hz\", 2], turn = [0.1, 0.2, 0.3]"));
    let scene = with(&text, &reference());
    let (s, tau) = (scene.state(), std::f64::consts::TAU);
    let [wx, wy, wz] = [3.0 * tau, -tau, 2.0 * tau];
    for (i, at) in mats(&scene, "room.p").into_iter().enumerate() {
        let [x, y, z, _] = scene.layout.reach[i];
        let v = [1.0 + wy * z - wz * y, 2.0 + wz * x - wx * z, -3.0 + wx * y - wy * x];
        let d = [0, 1, 2].map(|k| s.d[at + k] / scene.te);
        within("v = v₀ + ω × r", norm(minus(d, v)), 1e-14);
    }
}

#[test]
fn a_tetrahedron_weighs_what_is_asked() {
    let mobility = |body: &str| {
        let scene = scene(&room(body));
        let places = mats(&scene, "room.p");
        places.iter().map(|p| scene.te * scene.te / scene.state().coef[2 * scene.n_mat + p]).collect::<Vec<f64>>()
    };
    let each = mobility(&tetra(""));
    let shared = mobility("[room.TETRA]\np = { edge = 0.1, m_total = \"2 g\" }\n");
    assert_eq!(each.len(), 4);
    for (a, b) in each.iter().zip(&shared) {
        within("1 g each", off(*a, 1e-3), 1e-15);
        within("2 g together", off(*b, 0.5e-3), 1e-15);
    }
}

/// Force on the masses of `p` for small displacements `u` of them, per metre.
fn stiffness(scene: &Scene, u: &[[f64; 3]], by: f64) -> Vec<[f64; 3]> {
    let at = mats(scene, "room.p");
    let force = |by: f64| {
        let mut s = scene.state();
        for (at, u) in at.iter().zip(u) {
            (0..3).for_each(|k| s.x[at + k] = by * u[k]);
        }
        sense(scene, &mut s);
        at.iter().map(|at| [0, 1, 2].map(|k| s.f[at + k])).collect::<Vec<_>>()
    };
    let (plus, minus) = (force(by), force(-by));
    plus.iter().zip(&minus).map(|(p, m)| [0, 1, 2].map(|k| (p[k] - m[k]) / (2.0 * by))).collect()
}

#[test]
fn d05_modes_of_a_tetrahedron() {
    let scene = with(
        "[room]\ndim = 3\n[room.TETRA]\np = { edge = 1, m = 1, k = 1 }\n[SOX]\nout = { from = \"room.p[*]\", along = \"x\" }\n",
        &reference(),
    );
    let s = 1.0 / 8f64.sqrt();
    let corners = [[s, s, s], [s, -s, -s], [-s, s, -s], [-s, -s, s]];
    // strains: breathing; shears of the cube's faces; stretchings of the cube at constant volume
    let strains: [fn([f64; 3]) -> [f64; 3]; 6] = [
        |[x, y, z]| [x, y, z],
        |[x, y, _]| [y, x, 0.0],
        |[x, _, z]| [z, 0.0, x],
        |[_, y, z]| [0.0, z, y],
        |[x, y, z]| [2.0 * x, -y, -z],
        |[_, y, z]| [0.0, y, -z],
    ];
    for (strain, lambda) in strains.into_iter().zip([4.0, 2.0, 2.0, 2.0, 1.0, 1.0]) {
        let u = corners.map(strain);
        for (f, u) in stiffness(&scene, &u, 3e-6).into_iter().zip(u) {
            within("D05 F = −λ u", norm(minus(f, u.map(|u| -lambda * u))), 1e-10);
        }
    }
    // moved and turned as a whole, it does not resist
    for rigid in [|_: [f64; 3]| [1.0, 2.0, -1.0], |[x, y, _]: [f64; 3]| [-y, x, 0.0]] {
        within(
            "D05 zero",
            stiffness(&scene, &corners.map(rigid), 3e-6).into_iter().map(norm).fold(0.0, f64::max),
            1e-10,
        );
    }
}
