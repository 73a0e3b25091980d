//! Tests drawings of all bundled models, of large scenes and of random links.

mod check;
mod film;
mod random;

use ca_view::Drawing;
use check::{Page, apart, check, compiled, models, page, views};
use cordis_anima::ca_core::Scene;
use cordis_anima::ca_core::internal::kind::name::{Index, Part};
use cordis_anima::ca_core::internal::op::MeasureKind;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

#[test]
fn every_bundled_model_is_drawn() {
    for (name, scene) in models() {
        let d = Drawing::new(&scene);
        check(&name, &scene, &d);
        views(&name, &scene, &d, 500);
        let p = page(&d);
        assert_eq!(d.json()["decimated"], Value::Null);
        // all MATs, and all links except sets and masses that are left out
        assert!((0..scene.mats()).all(|m| d.drawn_mass(m) == Some(m)), "{name}");
        let sets = scene.passes.forces.iter().filter(|op| op.ports.pair_set.is_some()).count();
        let waves = p.links.iter().filter(|l| l.0 == "WAVE").count();
        assert_eq!(p.links.len() - waves, scene.lias() - sets, "{name}");
        in_order(&name, &scene, &d, &p);
    }
}

/// Checks that strings are in the order of their masses and even, and that neighbours in a mesh are equally far apart.
fn in_order(name: &str, scene: &Scene, d: &Drawing, p: &Page) {
    let mut rows: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    let mut grid: BTreeMap<(String, u32, u32), usize> = BTreeMap::new();
    for m in 0..scene.mats() {
        let s = scene.symbols.get(m).unwrap();
        let Some(i) = d.drawn_mass(m).filter(|i| !p.space[*i]) else { continue };
        match (s.name.part, s.name.index) {
            (Part::Own, Index::One(_)) => rows.entry(s.name.of.to_string()).or_default().push(i),
            (Part::Own, Index::Two(a, b)) => _ = grid.insert((s.name.of.to_string(), a, b), i),
            _ => {}
        }
    }
    for (row, masses) in &rows {
        let ring = ["hoop", "gong"].iter().any(|r| name.starts_with(r));
        let wave = name.starts_with("wave_guitar");
        let steps: Vec<f64> = masses.windows(2).map(|w| apart(p.rest[w[0]], p.rest[w[1]])).collect();
        let even = steps.iter().all(|s| (s - steps[0]).abs() < 1e-4 * steps[0]);
        assert!(wave || even, "{name}: {row} {steps:?}");
        // banks side by side extend into the depth
        let along = masses.windows(2).all(|w| p.rest[w[0]][0] < p.rest[w[1]][0]);
        let deep = masses.windows(2).all(|w| p.rest[w[0]][0] == p.rest[w[1]][0] && p.rest[w[0]][2] > p.rest[w[1]][2]);
        let banks = name.starts_with("marimba");
        assert!(ring || if banks { deep } else { along }, "{name}: {row} not in order");
    }
    let lengths: Vec<f64> = grid
        .iter()
        .flat_map(|((of, a, b), i)| [(a + 1, *b), (*a, b + 1)].map(|(a, b)| (grid.get(&(of.clone(), a, b)), *i)))
        .filter_map(|(other, i)| Some(apart(p.rest[*other?], p.rest[i])))
        .collect();
    assert!(lengths.iter().all(|l| (l - lengths[0]).abs() < 1e-4 * lengths[0]), "{name}: {lengths:?}");
    // links of a string or mesh join neighbours, in any order of passes
    let of = |i: usize| d.scene_mass(i).and_then(|m| scene.symbols.get(m)).map(|s| s.name);
    for (kind, contact, [a, b]) in p.links.iter().filter(|l| !p.space[l.2[0]]) {
        let (Some(a), Some(b)) = (of(*a), of(*b)) else { continue };
        if a.of != b.of || *contact || name.starts_with("gong") {
            continue;
        }
        let near = match (a.index, b.index) {
            (Index::Two(i, j), Index::Two(k, l)) => i.abs_diff(k) + j.abs_diff(l) == 1,
            (Index::One(_), Index::One(_)) if a.part != b.part => true,
            (Index::One(i), Index::One(j)) => i.abs_diff(j) <= 2 || name.starts_with("hoop"),
            _ => true,
        };
        assert!(near, "{name}: {kind} between {a} and {b}");
    }
}

/// Strings long enough to be folded, a mesh and a row of cells: each mass is at the place of its name.
#[test]
fn folded_masses_are_seen_by_their_names() {
    let text = r#"
[STRING]
a = { n = 200, m = "1 g", k = "90 kN/m", z = 0.1 }
b = { n = 77, m = "1 g", k = "80 kN/m" }
[MESH]
m = { nx = 24, ny = 20, m = "1 g", k = "50 kN/m", z = 0.05, edges = "closed" }
[MAS]
h = { m = "5 g", x = "-0.1 mm", v = 1 }
g = { m = "5 g", x = "-0.1 mm", v = 1 }
[BUT]
strike = { between = [["h", "g"], ["a[9]", "m[7,5]"]], k = "9 kN/m" }
[RES]
tie = { between = ["a[50]", "b[40]"], k = 100 }
[SOX]
oa = { from = "a[7]", channel = 0 }
ob = { from = "b[7]", channel = 0 }
om = { from = "m[2,3]", channel = 0 }
"#;
    let scene = compiled(text, "folded.ca.toml");
    assert!(scene.passes.moves.iter().chain(&scene.passes.forces).any(|op| op.form.folded), "nothing is folded");
    let d = Drawing::new(&scene);
    check("folded", &scene, &d);
    views("folded", &scene, &d, 300);
    let p = page(&d);
    in_order("folded", &scene, &d, &p);
    assert_eq!(p.links.len(), scene.lias());
    let place = |name: &str| {
        let m = (0..scene.mats()).find(|m| scene.symbols.get(*m).unwrap().name == name).unwrap();
        p.rest[d.drawn_mass(m).unwrap()]
    };
    for (hammer, struck) in [("h", "a[9]"), ("g", "m[7,5]")] {
        let [h, s] = [place(hammer), place(struck)];
        assert_eq!([h[0], h[2]], [s[0], s[2]], "{hammer}");
        assert!((s[1] - h[1] - 1e-4).abs() < 1e-9, "{hammer} {h:?} {s:?}");
    }
    let hold = scene.passes.forces.iter().all(|op| op.form.measure == MeasureKind::Line);
    assert!(hold && d.json()["spheres"].as_array().unwrap().is_empty());
}

/// A modal string draws its modes, and the masses with links or outputs, which are not MATs.
#[test]
fn modes_are_cells_and_the_masses_they_move_stand_beside() {
    let text = r#"
[low]
method = "modal"
[low.STRING]
s = { n = 40, f = "110 Hz", t60 = "4 s", m = "1 g", ends = "fixed" }
[MAS]
head = { m = "10 g", x = "-6 mm", v = "1 m/s" }
[BUT]
strike = { between = ["head", "low.s[8]"], k = "8 kN/m", z = "0.2 N s/m" }
[SOX]
out = { from = "low.s[3]", gain = 20 }
"#;
    let scene = compiled(text, "modes.ca.toml");
    assert!(!scene.places.modal.is_empty() && scene.symbols.iter().any(|s| s.name.part == Part::Mode));
    let d = Drawing::new(&scene);
    check("modes", &scene, &d);
    views("modes", &scene, &d, 900);
    let p = page(&d);
    assert_eq!(p.n, scene.mats() + scene.places.modal.len());
    let blows: Vec<_> = p.links.iter().filter(|l| l.1).collect();
    let [(_, _, [_, struck])] = blows[..] else { panic!("{blows:?}") };
    assert!(d.scene_mass(*struck).is_none() && !p.fixed[*struck]);
}

/// An enclosing contact is drawn as a sphere around its mass.
#[test]
fn what_contains_is_a_sphere() {
    for (name, scene) in models() {
        let spheres = &Drawing::new(&scene).json()["spheres"];
        let expected: &[f64] = match name.trim_end_matches(".ca.toml") {
            "maracas" => &[0.032],
            "rattle" | "rattle_stick" => &[0.045],
            _ => &[],
        };
        let radii: Vec<f64> = spheres.as_array().unwrap().iter().map(|s| s["radius"].as_f64().unwrap()).collect();
        assert_eq!(radii, expected, "{name}");
        assert!(spheres.as_array().unwrap().iter().all(|s| s["mass"].as_i64().unwrap() >= 0), "{name}");
    }
}

/// In a long string, a large mesh and a large cloud every k-th mass is drawn, with links between these.
#[test]
fn too_much_is_thinned() {
    let string = "[STRING]\ns = { n = 99998, m = \"1 g\", k = \"50 kN/m\" }\n[SOX]\nout = { from = \"s[7]\" }\n";
    let mesh = "[MESH]\nm = { nx = 300, ny = 200, m = \"1 g\", k = \"50 kN/m\" }\n[SOX]\nout = { from = \"m[7,3]\" }\n";
    let grains = "[r]\ndim = 3\n[r.GRAINS]\ng = { n = 50000, m = \"1 g\", gap = \"1 cm\" }\n[SOX]\nout = { from = \"r.g[*]\", along = \"x\", channel = 0 }\n";
    for (name, text, linked) in [("string", string, true), ("mesh", mesh, true), ("grains", grains, false)] {
        let scene = compiled(text, name);
        let d = Drawing::new(&scene);
        check(name, &scene, &d);
        views(name, &scene, &d, 3);
        let (v, p) = (d.json(), page(&d));
        assert_eq!(v["decimated"]["of"], scene.mats(), "{name}");
        assert_eq!(v["decimated"]["shown"], p.n, "{name}");
        assert!((8_000..20_100).contains(&p.n), "{name}: {}", p.n);
        let shown = (0..scene.mats()).filter(|m| d.drawn_mass(*m).is_some()).count();
        assert_eq!(shown, p.n, "{name}");
        // the drawn masses are still connected
        if linked {
            let mut part: Vec<usize> = (0..p.n).collect();
            for (_, _, [a, b]) in &p.links {
                let [a, b] = [root(&mut part, *a), root(&mut part, *b)];
                part[a] = b;
            }
            let roots: BTreeSet<usize> = (0..p.n).map(|i| root(&mut part, i)).collect();
            assert_eq!(roots.len(), 1, "{name}");
        }
        let mut out = Vec::new();
        d.view(&scene.initial.x, &mut out);
        let (capacity, at) = (out.capacity(), out.as_ptr());
        out.clear();
        d.view(&scene.initial.x, &mut out);
        assert_eq!((out.capacity(), out.as_ptr()), (capacity, at), "{name}: it allocates");
    }
}

fn root(part: &mut [usize], mut i: usize) -> usize {
    while part[i] != i {
        part[i] = part[part[i]];
        i = part[i];
    }
    i
}

/// A hundred thousand masses are laid out, and thinned to what a page can show.
#[test]
fn much_is_laid_out_and_thinned() {
    let net = |n: usize| {
        let mut t = String::from("[SOX]\nout = { from = \"m0\" }\n[MAS]\n");
        (0..n).for_each(|i| _ = writeln!(t, "m{i} = {{ m = 1 }}"));
        t += "[REF]\n";
        (1..n).for_each(|i| {
            _ = writeln!(t, "l{i} = {{ between = [\"m{}\", \"m{i}\"], k = 1, z = 0 }}", i * 7 % i.min(300));
        });
        t
    };
    let string = "[STRING]\ns = { n = 99998, m = \"1 g\", k = \"50 kN/m\" }\n[SOX]\nout = { from = \"s[7]\" }\n";
    for (name, text) in [("string", string.to_string()), ("net", net(100_000))] {
        let scene = compiled(&text, name);
        let d = Drawing::new(&scene);
        assert!((1000..=20_100).contains(&d.masses()), "{name}: {} of {} masses", d.masses(), scene.mats());
        let p = page(&d);
        assert!(p.links.iter().all(|(_, _, [a, b])| *a < p.n && *b < p.n && a != b), "{name}");
    }
}
