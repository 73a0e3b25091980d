//! Meshes whose links are written in any order get the same passes and the same bits.

use crate::play::{reference, scene, with};
use ca_core::internal::op::{Band, Vectors};
use ca_core::internal::scene::same_since;
use ca_core::{Scene, tick};
use proptest::prelude::*;
use std::fmt::Write as _;

/// Links of a grid of `nx` × `ny` nodes, those along its rows first.
fn along_first(nx: usize, ny: usize) -> Vec<[usize; 2]> {
    let along = (0..nx * ny).filter(|i| (i + 1) % nx > 0).map(|i| [i, i + 1]);
    along.chain((0..nx * (ny - 1)).map(|i| [i, i + nx])).collect()
}

/// The same links in four other orders: node by node, row by row, column by column, across first.
fn written(nx: usize, ny: usize) -> Vec<Vec<[usize; 2]>> {
    let mut orders = vec![along_first(nx, ny); 4];
    orders[0].sort_by_key(|[a, b]| (*a, b - a));
    orders[1].sort_by_key(|[a, b]| (a / nx, b - a, *a));
    orders[2].sort_by_key(|[a, b]| (a % nx, a / nx, b - a));
    orders[3].sort_by_key(|[a, b]| (std::cmp::Reverse(b - a), *a));
    orders
}

/// A mesh on a line, or an almost flat cloth in space. One of its masses moves at load.
fn text(nx: usize, ny: usize, links: &[[usize; 2]], space: bool) -> String {
    let (group, of) = if space { ("[g]\ndim = 3\n[g.MAS]\n", "g.") } else { ("[MAS]\n", "") };
    let mut text = String::from(group);
    for i in 0..nx * ny {
        let v = if i == (nx + 3).min(nx * ny - 3) { 0.1 } else { 0.0 };
        let (x, y, z) = ((i % nx) as f64 * 0.01, (i / nx) as f64 * 0.01, (i % 5) as f64 * 1e-3);
        let of = if space { format!("x = [{x}, {y}, {z}], v = [0, 0, {v}]") } else { format!("v = {v}") };
        let _ = writeln!(text, "m{i} = {{ m = \"2 g\", {of} }}");
    }
    text += if space { "[g.REF]\n" } else { "[REF]\n" };
    for [a, b] in links {
        let k = 1000 + 7 * a + b;
        let _ = writeln!(text, "r{a}_{b} = {{ between = [\"{of}m{a}\", \"{of}m{b}\"], k = {k}, z = 0.01 }}");
    }
    let along = if space { ", along = \"z\"" } else { "" };
    let _ = writeln!(text, "[SOX]\no = {{ from = \"{of}m{}\"{along} }}", (nx + 5).min(nx * ny - 1));
    text
}

fn played(scene: &Scene, ticks: usize) -> (Vec<u64>, Vec<(&'static str, usize, Band)>) {
    let mut s = scene.state();
    let sound = (0..ticks).map(|_| {
        tick(scene, &mut s);
        s.output[0].to_bits()
    });
    let sound = sound.collect();
    (sound, scene.passes.summed().iter().chain(&scene.passes.moves).map(|op| (op.name(), op.n, op.form.band)).collect())
}

#[test]
fn a_mesh_is_found_in_any_order_of_its_links() {
    let (nx, ny) = (13, 14);
    let usual = scene(&text(nx, ny, &along_first(nx, ny), false));
    let (sound, passes) = played(&usual, 500);
    assert!(passes.iter().any(|p| p.2 != Band::None), "{passes:?}");
    let peak = sound.iter().fold(0.0_f64, |peak, v| peak.max(f64::from_bits(*v).abs()));
    assert!(peak > 1e-7, "it is silent");
    let string = scene(&text(40, 1, &along_first(40, 1), false));
    assert!(!string.passes.sorted && same_since(&string) == 0, "its takes keep their bits");
    let made =
        scene("[MESH]\nm = { nx = 14, ny = 13, m = \"2 g\", k = 1000, z = 0.01 }\n[SOX]\no = { from = \"m[5,1]\" }\n");
    assert_eq!(played(&made, 1).1, passes, "by hand and made");
    let masses = |p: &&(&str, usize, Band)| p.2 != Band::None && p.1 >= nx * ny;
    assert!(passes.iter().any(|p| masses(&p)), "no corner is left out: {passes:?}");
    for links in written(nx, ny) {
        let text = text(nx, ny, &links, false);
        let mesh = scene(&text);
        assert!(mesh.passes.sorted && same_since(&mesh) == 3, "takes of it from before are compared to rounding");
        assert_eq!(played(&mesh, 500), (sound.clone(), passes.clone()), "{text}");
        let plain = with(&text, &reference());
        let (plain, _) = played(&plain, 500);
        for (a, b) in sound.iter().zip(plain).map(|(a, b)| (f64::from_bits(*a), f64::from_bits(b))) {
            assert!((a - b).abs() < 1e-12 * peak, "{a} {b}");
        }
    }
}

#[test]
fn a_cloth_is_found_in_any_order_of_its_links() {
    let (nx, ny) = (9, 8);
    let usual = scene(&text(nx, ny, &along_first(nx, ny), true));
    let (sound, _) = played(&usual, 500);
    assert!(usual.layout.links.rows.iter().all(|r| *r > 0), "all stand in rows");
    for links in written(nx, ny) {
        let cloth = scene(&text(nx, ny, &links, true));
        assert_eq!(cloth.layout.links.rows, usual.layout.links.rows);
        assert_eq!(played(&cloth, 500).0, sound);
    }
}

/// Meshes that are too narrow to be fused, fixed at their corners, or behind a hammer in the document.
#[test]
fn what_stands_around_a_mesh_changes_no_order() {
    for (nx, ny) in [(4, 30), (9, 12), (16, 14)] {
        let all = |links: &[[usize; 2]], corners: bool| {
            let text = text(nx, ny, links, false);
            if !corners {
                return text;
            }
            let corner = |i: usize| [0, nx - 1, nx * (ny - 1), nx * ny - 1].contains(&i);
            let sol = (0..nx * ny).filter(|i| corner(*i)).fold(String::new(), |all, i| all + &format!("m{i} = {{}}\n"));
            let mass = |line: &&str| !(0..nx * ny).any(|i| corner(i) && line.starts_with(&format!("m{i} = ")));
            text.lines().filter(mass).collect::<Vec<_>>().join("\n") + "\n[SOL]\n" + &sol
        };
        for corners in [false, true] {
            let usual = played(&scene(&all(&along_first(nx, ny), corners)), 300);
            for links in written(nx, ny) {
                assert_eq!(played(&scene(&all(&links, corners)), 300), usual, "{nx} x {ny}");
            }
        }
    }
    let hammer = "[BUT]\nb = { between = [\"h\", \"m30\"], k = \"20 kN/m\", z = 0.2 }\n";
    let mesh = text(16, 14, &along_first(16, 14), false).replacen(
        "[MAS]\n",
        "[MAS]\nh = { m = \"5 g\", x = \"-0.1 mm\", v = 1 }\n",
        1,
    );
    let [behind, before] = [format!("{mesh}{hammer}"), format!("{hammer}{mesh}")];
    assert_eq!(played(&scene(&before), 300), played(&scene(&behind), 300));
    assert!(scene(&before).passes.moves.iter().any(|op| op.form.band != Band::None));
}

proptest! {
    /// Links in random order, in meshes of any size, with all vector widths.
    #[test]
    fn no_order_of_links_tells(
        (nx, ny, links) in (12usize..24, 11usize..20)
            .prop_flat_map(|(nx, ny)| (Just(nx), Just(ny), Just(along_first(nx, ny)).prop_shuffle()))
    ) {
        let sound = played(&scene(&text(nx, ny, &along_first(nx, ny), false)), 200);
        let mut other = scene(&text(nx, ny, &links, false)).scene;
        for vectors in Vectors::all() {
            other.layout.vectors = vectors;
            prop_assert_eq!(&played(&other, 200), &sound);
        }
    }
}
