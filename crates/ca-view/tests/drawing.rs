//! Drawings of all bundled models, of what is large and of what is linked at random.

use ca_view::Drawing;
use cordis_anima::ca_core::Scene;
use cordis_anima::ca_core::kind::name::{Index, Part};
use cordis_anima::ca_core::op::MeasureKind;
use cordis_anima::ca_core::scene::Location;
use cordis_anima::ca_io::perform::Performance;
use cordis_anima::{Loaded, Options};
use proptest::prelude::*;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

fn compiled(text: &str, file: &str) -> Scene {
    let compiled = Loaded::read(text, file).compile(&Options::default());
    compiled.map_err(cordis_anima::Error::from).unwrap_or_else(|e| panic!("{file}: {e}\n{text}")).scene
}

/// Name and scene of every bundled model.
fn models() -> Vec<(String, Scene)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
    let mut all: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    all.sort();
    let named = all.iter().map(|p| (p.file_name().unwrap().to_string_lossy().into_owned(), p));
    named.map(|(name, p)| (name, cordis_anima::load(p).unwrap_or_else(|e| panic!("{e}")).scene)).collect()
}

/// What a page reads.
struct Page {
    n: usize,
    rest: Vec<[f64; 3]>,
    axis: Vec<[f64; 3]>,
    space: Vec<bool>,
    fixed: Vec<bool>,
    kinds: Vec<String>,
    /// kind, contact, ends
    links: Vec<(String, bool, [usize; 2])>,
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn points(v: &Value) -> Vec<[f64; 3]> {
    numbers(v).chunks(3).map(|p| p.try_into().unwrap()).collect()
}

fn page(d: &Drawing) -> Page {
    let v = d.json();
    let bits = |key: &str| numbers(&v[key]).into_iter().map(|b| b == 1.0).collect::<Vec<bool>>();
    let names: Vec<&str> = v["kinds"].as_array().unwrap().iter().map(|k| k.as_str().unwrap()).collect();
    let mut links = Vec::new();
    for l in v["links"].as_array().unwrap() {
        let ends: Vec<usize> = numbers(&l["ends"]).into_iter().map(|e| e as usize).collect();
        assert_eq!(ends.len() % 2, 0);
        let kind = l["kind"].as_str().unwrap();
        let contact = l["contact"].as_bool().unwrap();
        links.extend(ends.chunks(2).map(|e| (kind.to_string(), contact, [e[0], e[1]])));
    }
    Page {
        n: v["masses"].as_u64().unwrap() as usize,
        rest: points(&v["rest"]),
        axis: points(&v["axis"]),
        space: bits("space"),
        fixed: bits("fixed"),
        kinds: numbers(&v["kind"]).into_iter().map(|k| names[k as usize].to_string()).collect(),
        links,
    }
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// What is true of every drawing.
fn check(name: &str, scene: &Scene, d: &Drawing) {
    let p = page(d);
    let again = Drawing::new(scene);
    assert_eq!(*d, again, "{name}");
    assert_eq!(d.json().to_string(), again.json().to_string(), "{name}");
    assert_eq!((p.n, d.masses()), (p.rest.len(), p.n), "{name}");
    assert!([p.axis.len(), p.space.len(), p.fixed.len(), p.kinds.len()].iter().all(|n| *n == p.n), "{name}");
    assert!(p.rest.iter().chain(&p.axis).flatten().all(|v| v.is_finite()), "{name}");
    for (i, axis) in p.axis.iter().enumerate() {
        let length = apart(*axis, [0.0; 3]);
        assert!(if p.space[i] { length == 0.0 } else { (length - 1.0).abs() < 1e-6 }, "{name}: {axis:?}");
        if let Some(m) = d.scene_mass(i) {
            let s = scene.symbols.get(m).unwrap();
            assert_eq!((s.axes > 1, s.code, s.code == "SOL"), (p.space[i], &*p.kinds[i], p.fixed[i]), "{name}");
            assert_eq!(d.drawn_mass(m), Some(i), "{name}");
        }
    }
    let mut all = BTreeSet::new();
    for (kind, _, [a, b]) in &p.links {
        assert!(*a < p.n && *b < p.n && a != b, "{name}: {kind} {a} {b} of {}", p.n);
        all.insert((a.min(b), a.max(b)));
    }
    assert!(d.scene_mass(p.n).is_none() && d.drawn_mass(scene.mats()).is_none(), "{name}");
    // masses on a line stand apart, each from all others
    let width = p.rest.iter().flat_map(|a| p.rest.iter().take(1).map(|b| apart(*a, *b))).fold(0.0, f64::max);
    let cell = |v: [f64; 3]| v.map(|x| (x / (1e-6 * width)).round() as i64);
    let mut taken = BTreeMap::new();
    for i in (0..p.n).filter(|i| !p.space[*i] && p.kinds[*i] != "@") {
        let Some(other) = taken.insert(cell(p.rest[i]), i) else { continue };
        // strings and meshes that are tied to masses in space, along their axes, may cross there
        let names = [i, other].map(|i| d.scene_mass(i).and_then(|m| scene.symbols.get(m)).map(|s| s.name));
        let cross = match &names {
            [Some(a), Some(b)] => {
                a.of != b.of && (a.index, b.index) != (Index::None, Index::None) && p.space.contains(&true)
            }
            _ => false,
        };
        assert!(cross, "{name}: {names:?} at {:?}", p.rest[i]);
    }
}

/// A view has what the state has, by the names of the scene.
fn views(name: &str, scene: &Scene, d: &Drawing, ticks: usize) {
    let mut play = Performance::new(scene, None).unwrap();
    (0..ticks).for_each(|_| play.tick());
    let space = page(d).space;
    let mut out = vec![7];
    d.view(&play.state.x, &mut out);
    let seen: Vec<f32> = out[1..].chunks(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
    let mut at = 0;
    for (i, space) in space.iter().enumerate() {
        let n = if *space { 3 } else { 1 };
        if let Some(s) = d.scene_mass(i).and_then(|m| scene.symbols.get(m)) {
            let Location::Mat(place) = s.location else { panic!() };
            // a port that is a share of a way has no place to move from
            if s.name == "slide" {
                assert_eq!(seen[at], 0.0);
                at += n;
                continue;
            }
            for k in 0..n {
                let x = play.state.x[place as usize + k] as f32;
                assert_eq!(seen[at + k].to_bits(), x.to_bits(), "{name}: {} of {}", s.name, s.code);
            }
        }
        at += n;
    }
    assert_eq!(at, seen.len(), "{name}");
}

#[test]
fn every_bundled_model_is_drawn() {
    for (name, scene) in models() {
        let d = Drawing::new(&scene);
        check(&name, &scene, &d);
        views(&name, &scene, &d, 500);
        let p = page(&d);
        assert_eq!(d.json()["decimated"], Value::Null);
        // all MATs, and all links but those of sets and of masses that are left out
        assert!((0..scene.mats()).all(|m| d.drawn_mass(m) == Some(m)), "{name}");
        let sets = scene.forces.iter().filter(|op| op.ports.pair_set.is_some()).count();
        let waves = p.links.iter().filter(|l| l.0 == "WAVE").count();
        assert_eq!(p.links.len() - waves, scene.lias() - sets, "{name}");
        in_order(&name, &scene, &d, &p);
    }
}

/// Strings stand in the order of their masses, evenly, and neighbours of a mesh are equally far apart.
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
        // a bank among banks goes into the depth
        let along = masses.windows(2).all(|w| p.rest[w[0]][0] < p.rest[w[1]][0]);
        let deep = masses.windows(2).all(|w| p.rest[w[0]][0] == p.rest[w[1]][0] && p.rest[w[0]][2] > p.rest[w[1]][2]);
        let banks = ["marimba", "piano_key"].iter().any(|r| name.starts_with(r));
        assert!(ring || if banks { deep } else { along }, "{name}: {row} not in order");
    }
    let lengths: Vec<f64> = grid
        .iter()
        .flat_map(|((of, a, b), i)| [(a + 1, *b), (*a, b + 1)].map(|(a, b)| (grid.get(&(of.clone(), a, b)), *i)))
        .filter_map(|(other, i)| Some(apart(p.rest[*other?], p.rest[i])))
        .collect();
    assert!(lengths.iter().all(|l| (l - lengths[0]).abs() < 1e-4 * lengths[0]), "{name}: {lengths:?}");
    // links of a string or mesh join neighbours, wherever its passes have put them
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

/// Strings long enough to be folded, a mesh, and a row of cells; each mass is where its name says.
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
    assert!(scene.moves.iter().chain(&scene.forces).any(|op| op.form.folded), "nothing is folded");
    let d = Drawing::new(&scene);
    check("folded", &scene, &d);
    views("folded", &scene, &d, 300);
    let p = page(&d);
    in_order("folded", &scene, &d, &p);
    assert_eq!(p.links.len(), scene.lias());
    // the hammers stand below what they strike
    let place = |name: &str| {
        let m = (0..scene.mats()).find(|m| scene.symbols.get(*m).unwrap().name == name).unwrap();
        p.rest[d.drawn_mass(m).unwrap()]
    };
    for (hammer, struck) in [("h", "a[9]"), ("g", "m[7,5]")] {
        let [h, s] = [place(hammer), place(struck)];
        assert_eq!([h[0], h[2]], [s[0], s[2]], "{hammer}");
        assert!((s[1] - h[1] - 1e-4).abs() < 1e-9, "{hammer} {h:?} {s:?}");
    }
    let hold = scene.forces.iter().all(|op| op.form.measure == MeasureKind::Line);
    assert!(hold && d.json()["spheres"].as_array().unwrap().is_empty());
}

/// Of a string that goes by its modes, these are drawn, and the masses that are played or heard, which are no MATs.
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
    assert!(!scene.modal.is_empty() && scene.symbols.iter().any(|s| s.name.part == Part::Mode));
    let d = Drawing::new(&scene);
    check("modes", &scene, &d);
    views("modes", &scene, &d, 900);
    let p = page(&d);
    assert_eq!(p.n, scene.mats() + scene.modal.len());
    let blows: Vec<_> = p.links.iter().filter(|l| l.1).collect();
    let [(_, _, [_, struck])] = blows[..] else { panic!("{blows:?}") };
    assert!(d.scene_mass(*struck).is_none() && !p.fixed[*struck]);
}

/// What holds others is a sphere around its mass.
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

/// Of a long string, a large mesh and a large cloud every k-th mass is drawn, and links between what is left.
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
        // what is drawn of it still hangs together
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
        let (room, at) = (out.capacity(), out.as_ptr());
        out.clear();
        d.view(&scene.initial.x, &mut out);
        assert_eq!((out.capacity(), out.as_ptr()), (room, at), "{name}: it allocates");
    }
}

fn root(part: &mut [usize], mut i: usize) -> usize {
    while part[i] != i {
        part[i] = part[part[i]];
        i = part[i];
    }
    i
}

/// Masses, fixed points and ports on a line and in space, strings, meshes and cells, with links between any two of them.
fn random(seed: u64) -> String {
    let mut state = seed;
    let mut below = |n: usize| {
        // splitmix64
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % n.max(1) as u64) as usize
    };
    let (n, f, ports, cells) = (below(30), below(4), below(3), below(12));
    let mut t = String::from("[MAS]\n");
    let mut line = Vec::new();
    for i in 0..n {
        let _ = writeln!(t, "m{i} = {{ m = 1, x = {} }}", [0.0, -0.01, 0.02][below(3)]);
        line.push(format!("m{i}"));
    }
    t += "[SOL]\nanchor = {}\n";
    line.push("anchor".into());
    (0..f).for_each(|i| {
        let _ = writeln!(t, "f{i} = {{}}");
        line.push(format!("f{i}"));
    });
    t += "[ENX]\n";
    (0..ports).for_each(|i| {
        let _ = writeln!(t, "p{i} = {{}}");
        line.push(format!("p{i}"));
    });
    t += "[CEL]\n";
    (0..cells).for_each(|i| {
        let _ = writeln!(t, "c{i} = {{ m = 1, k = 100 }}");
        line.push(format!("c{i}"));
    });
    if below(2) == 0 {
        let n = 3 + below(40);
        let kind = ["STRING", "CHAIN", "RING"][below(3)];
        let _ = writeln!(t, "[{kind}]\ns = {{ n = {n}, m = 1, k = 100 }}");
        line.extend((0..n).map(|i| format!("s[{i}]")));
        line.extend((kind != "RING").then(|| format!("s@0.{}", 1 + below(8))));
    }
    if below(2) == 0 {
        let (nx, ny) = (2 + below(12), 2 + below(9));
        let edges = ["open", "closed", "corner"][below(3)];
        let _ = writeln!(t, "[MESH]\ng = {{ nx = {nx}, ny = {ny}, m = 1, k = 100, edges = \"{edges}\" }}");
        line.extend((0..nx).flat_map(|i| (0..ny).map(move |j| format!("g[{i},{j}]"))));
        line.push(format!("g@0.{},0.{}", 1 + below(8), 1 + below(8)));
    }
    let space = below(20);
    t += "[w]\ndim = 3\n[w.MAS]\n";
    for i in 0..space {
        let _ = writeln!(t, "m{i} = {{ m = 1, x = [{}, {}, {}] }}", below(9), below(9), i);
    }
    for (kind, numbers) in [("REF", "k = 10, z = 0.1"), ("BUT", "k = 10"), ("FRO", "z = 0.1"), ("BOW", "f = 1, v0 = 1")]
    {
        let _ = writeln!(t, "[{kind}]");
        for i in 0..below(40) {
            let [a, b] = [below(line.len()), below(line.len())].map(|i| line[i].clone());
            if a != b && !(a.contains('@') && b.contains('@')) {
                let _ = writeln!(t, "{kind}{i} = {{ between = [\"{a}\", \"{b}\"], {numbers} }}");
            }
            if space > 1 && below(3) == 0 {
                let (a, b) = (below(space), below(space));
                if a != b {
                    let _ = writeln!(t, "{kind}x{i} = {{ between = [\"w.m{a}\", \"w.m{b}\"], {numbers} }}");
                }
            }
            if space > 0 && below(9) == 0 && !line[i % line.len()].contains('@') {
                let (a, b) = (&line[i % line.len()], below(space));
                let along = ["x", "y", "z"][below(3)];
                let _ =
                    writeln!(t, "{kind}y{i} = {{ between = [\"{a}\", \"w.m{b}\"], along = \"{along}\", {numbers} }}");
            }
        }
    }
    // what nobody hears is left out
    t += "[SOX]\n";
    for (i, name) in line.iter().enumerate() {
        let _ = writeln!(t, "o{i} = {{ from = \"{name}\", channel = 0 }}");
    }
    for i in 0..space {
        let _ = writeln!(t, "a{i} = {{ from = \"w.m{i}\", along = \"x\", channel = 0 }}");
    }
    t
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_linked_at_random_is_drawn(seed in any::<u64>()) {
        let text = random(seed);
        let scene = compiled(&text, "random.ca.toml");
        let d = Drawing::new(&scene);
        let name = format!("random {seed}");
        check(&name, &scene, &d);
        views(&name, &scene, &d, 5);
        let few = Drawing::of_at_most(&scene, 10);
        prop_assert!(few.masses() <= d.masses());
        let p = page(&few);
        prop_assert!(p.links.iter().all(|(_, _, [a, b])| a.max(b) < &p.n && a != b));
    }
}

/// A hundred thousand masses are laid out at once; how long it takes is measured where it is asked for.
#[test]
fn much_is_laid_out_in_time() {
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
        let begin = std::time::Instant::now();
        let d = Drawing::new(&scene);
        let took = begin.elapsed();
        println!("{name}: {} of {} masses in {took:?}", d.masses(), scene.mats());
        assert!(took.as_secs() < 5, "{name}: {took:?}");
    }
}
