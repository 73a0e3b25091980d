//! Links between points in space keep the distance of the last tick: its rounding, its part in the state, and no blow
//! at a point that is placed elsewhere.

use crate::play::{mat, scene, within};
use ca_core::internal::op::Vectors;
use ca_core::{Scene, State, tick};

const FS: f64 = 48e3;
const VISCOSITY: f64 = 0.1;

/// Two points 10 cm apart, joined by a damper whose force is an output.
fn pair(v: &str) -> Scene {
    let text = format!(
        "[air]\ndim = 3\n[air.MAS]\na = {{ m = \"1 g\", x = [0.3, 0.1, 0.7], v = {v} }}\nb = {{ m = \"1 g\", x = [0.36, 0.18, \
         0.7], v = {v} }}\n[FRO]\nf = {{ between = [\"air.a\", \"air.b\"], z = {VISCOSITY} }}\n[SOF]\nout = {{ from = \"f\", \
         dc = 0 }}\n"
    );
    scene(&text).scene
}

fn played(scene: &Scene, ticks: usize) -> State {
    let mut s = scene.state();
    (0..ticks).for_each(|_| tick(scene, &mut s));
    s
}

#[test]
fn translation_feels_rounding_alone() {
    let scene = pair("[0.31, -0.17, 0.23]");
    let bound = VISCOSITY * FS * 10.0 * 0.5 * f64::EPSILON * 0.1;
    let mut s = scene.state();
    let mut most = 0.0f64;
    for _ in 0..4800 {
        tick(&scene, &mut s);
        most = most.max(s.output[0].abs());
    }
    within("force of a damper in translation, in parts of its bound", most / bound, 1.0);
}

#[test]
fn what_is_put_elsewhere_feels_no_blow() {
    let scene = pair("[0, 0, 0]");
    let b = mat(&scene, "air.b");
    // 1 mm along the link, without motion
    let put = |placed: bool| {
        let mut s = played(&scene, 100);
        (0..2).for_each(|k| s.x[b + k] += [6e-4, 8e-4][k]);
        if placed {
            s.placed();
        }
        tick(&scene, &mut s);
        s.output[0].abs()
    };
    let blow = VISCOSITY * FS * 1e-3;
    within("a force that would be there if nobody said so", (put(false) / blow - 1.0).abs(), 1e-9);
    assert!(put(true) < 1e-12 * blow);
}

#[test]
fn a_state_that_is_put_back_goes_on_to_the_bit() {
    let scene = pair("[0, \"0.2 m/s\", 0]");
    let mut s = played(&scene, 50);
    s.d[mat(&scene, "air.a")] += 1e-6;
    tick(&scene, &mut s);
    let kept = s.clone();
    let on = |mut s: State| {
        (0..20).for_each(|_| tick(&scene, &mut s));
        s.bits()
    };
    let first = on(kept.clone());
    assert_eq!(on(kept.clone()), first);
    let mut other = kept.clone();
    other.links.lengths[0] *= 1.0 + 1e-9;
    assert!(other.bits() != kept.bits() && on(other) != first);
}

/// Rows in both directions, diagonals and block remainders, with and without a softening length.
#[test]
fn all_vectors_play_the_same_bits() {
    for soften in ["0 m", "2 mm"] {
        let text = format!(
            "[air]\ndim = 3\n[air.MESH]\nsheet = {{ nx = 13, ny = 9, dx = \"1 cm\", m = \"1 g\", k = 500, z = 0.01, shear = 200 }}\n\
             [air.MAS]\nball = {{ m = \"5 g\", x = [0.02, 0.03, 0.01], v = [0.1, 0.2, -0.3] }}\n[REF]\ntie = {{ between = \
             [\"air.ball\", \"air.sheet[*]\"], k = 30, z = 0.01, l0 = 0.005, soften = \"{soften}\" }}\n[SOX]\nout = {{ from = \
             \"air.ball\", along = \"z\" }}\n"
        );
        let bits = |vectors: Vectors, rows: bool| {
            let mut scene = scene(&text).scene;
            assert!(scene.layout.links.rows.iter().any(|r| *r >= 8), "rows are found");
            scene.layout.vectors = vectors;
            if !rows {
                scene.layout.links.rows.fill(-1);
            }
            let mut s = scene.state();
            (0..500).for_each(|_| tick(&scene, &mut s));
            assert!(s.is_bounded(1.0));
            s.bits()
        };
        let first = bits(Vectors::PORTABLE, false);
        for vectors in Vectors::all() {
            assert_eq!(bits(vectors, true), first, "{vectors:?}, {soften}");
            assert_eq!(bits(vectors, false), first, "{vectors:?}, {soften}, every end looked up");
        }
    }
}
