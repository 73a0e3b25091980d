//! Checks that hold for every drawing, and a reader for its JSON.

use ca_view::Drawing;
use cordis_anima::ca_core::internal::kind::name::Index;
use cordis_anima::ca_core::{Location, Scene};
use cordis_anima::ca_io::perform::Performance;
use cordis_anima::{Loaded, Options};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

pub fn compiled(text: &str, file: &str) -> Scene {
    let compiled = Loaded::read(text, file).compile(&Options::default());
    compiled.map_err(cordis_anima::Error::from).unwrap_or_else(|e| panic!("{file}: {e}\n{text}")).scene
}

/// Returns name and scene of every bundled model.
pub fn models() -> Vec<(String, Scene)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
    let mut all: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    // `models` also has a folder of parts
    all.retain(|p| p.is_file());
    all.sort();
    let named = all.iter().map(|p| (p.file_name().unwrap().to_string_lossy().into_owned(), p));
    named.map(|(name, p)| (name, cordis_anima::load(p).unwrap_or_else(|e| panic!("{e}")).scene)).collect()
}

/// Drawing as a page reads it.
pub struct Page {
    pub n: usize,
    pub rest: Vec<[f64; 3]>,
    pub axis: Vec<[f64; 3]>,
    pub space: Vec<bool>,
    pub fixed: Vec<bool>,
    pub kinds: Vec<String>,
    /// Kind, contact, ends.
    pub links: Vec<(String, bool, [usize; 2])>,
}

pub fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

pub fn points(v: &Value) -> Vec<[f64; 3]> {
    numbers(v).chunks(3).map(|p| p.try_into().unwrap()).collect()
}

pub fn page(d: &Drawing) -> Page {
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

pub fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Checks properties of every drawing.
pub fn check(name: &str, scene: &Scene, d: &Drawing) {
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
    // masses on a line have different places
    let width = p.rest.iter().flat_map(|a| p.rest.iter().take(1).map(|b| apart(*a, *b))).fold(0.0, f64::max);
    let cell = |v: [f64; 3]| v.map(|x| (x / (1e-6 * width)).round() as i64);
    let mut taken = BTreeMap::new();
    for i in (0..p.n).filter(|i| !p.space[*i] && p.kinds[*i] != "@") {
        let Some(other) = taken.insert(cell(p.rest[i]), i) else { continue };
        // strings and meshes that are tied to masses in space along their axes may cross there, and so may banks along
        // two axes (but not in two directions of one axis)
        let names = [i, other].map(|i| d.scene_mass(i).and_then(|m| scene.symbols.get(m)).map(|s| s.name));
        let cross = match &names {
            [Some(a), Some(b)] => {
                let bodies = (a.index, b.index) != (Index::None, Index::None)
                    || p.axis[i].map(f64::abs) != p.axis[other].map(f64::abs);
                a.of != b.of && bodies && p.space.contains(&true)
            }
            _ => false,
        };
        assert!(cross, "{name}: {names:?} at {:?}", p.rest[i]);
    }
}

/// Checks that a view has the numbers of the state, by the names of the scene.
pub fn views(name: &str, scene: &Scene, d: &Drawing, ticks: usize) {
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
            // a port that controls a moving point has a fraction, not a position
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
