//! Scenes that the benches share.
// nobody but the benches calls these: what fails is a defect of the bench
#![allow(clippy::missing_errors_doc, clippy::missing_panics_doc)]

pub mod accuracy;
pub mod atlas;
pub mod costs;
pub mod latency;
pub mod peers;
pub mod rattle;

use ca_compile::{KernelClass, Options, compile};
use ca_core::{Catalog, Scene};
use ca_model::Model;
use std::fmt::Write as _;

/// Whose times these are.
pub fn machine() -> String {
    let reported = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = reported.lines().find_map(|l| l.strip_prefix("model name")).and_then(|l| l.split_once(": "));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let virtual_one = if reported.contains("hypervisor") { ", a virtual one that it shares with others" } else { "" };
    format!("{cores} cores of {}{virtual_one}", name.map_or("a kind it does not tell", |(_, name)| name.trim()))
}

/// All kinds there are.
pub fn catalog() -> Catalog {
    ca_model::catalog().with(ca_lpr::KINDS)
}

/// Reads a model of ours; a finding is a defect of the bench.
pub fn model(text: &str) -> Model {
    let (model, findings) = ca_model::read::read(text, "bench.ca.toml", &catalog());
    assert!(!findings.has_errors(), "{findings}");
    model
}

/// Compiles a model with one class of kernels.
pub fn scene(model: &Model, kernel: KernelClass, energy: bool) -> Scene {
    compile(model, &catalog(), &Options { kernel, energy, ..Options::default() }).expect("the bench compiles").scene
}

/// A string of `n` masses by its generator.
pub fn string(n: usize) -> String {
    format!(
        "[STRING]\ns = {{ n = {n}, m = \"1 g\", k = \"100 kN/m\", z = \"1 mN s/m\" }}\n[SOX]\nout = {{ from = \"s[3]\" }}\n"
    )
}

/// A mesh of `n` × `n` masses by its generator.
pub fn mesh(n: usize) -> String {
    format!(
        "[MESH]\ns = {{ nx = {n}, ny = {n}, m = \"1 g\", k = \"50 kN/m\", z = \"1 mN s/m\" }}\n[SOX]\nout = {{ from = \"s[3,3]\" }}\n"
    )
}

/// A string of `n` masses with every module written by hand.
pub fn by_hand(n: usize) -> String {
    let mut t = String::from("[SOL]\nwall = {}\n[MAS]\n");
    for i in 0..n {
        let _ = writeln!(t, "m{i} = {{ m = \"1 g\" }}");
    }
    t += "[REF]\nr0 = { between = [\"wall\", \"m0\"], k = \"100 kN/m\", z = 0.001 }\n";
    for i in 1..n {
        let _ = writeln!(t, "r{i} = {{ between = [\"m{}\", \"m{i}\"], k = \"100 kN/m\", z = 0.001 }}", i - 1);
    }
    t + "[SOX]\nout = { from = \"m3\" }\n"
}

/// `masses` joined at random by `links` REF: the worst case, nothing stands in a row.
pub fn random(masses: u64, links: u64) -> String {
    let mut t = String::from("[MAS]\n");
    for i in 0..masses {
        let _ = writeln!(t, "m{i} = {{ m = \"1 g\" }}");
    }
    t += "[REF]\n";
    let mut seed = 12345u64;
    let mut next = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        seed % masses
    };
    for i in 0..links {
        let (a, b) = (next(), next());
        let b = if a == b { (b + 1) % masses } else { b };
        let _ = writeln!(t, "r{i} = {{ between = [\"m{a}\", \"m{b}\"], k = \"1 kN/m\", z = 0.001 }}");
    }
    t + "[SOX]\nout = { from = \"m3\" }\n"
}

/// A MIMS file of ours: a 20 × 30 mesh held at two corners, one line per module, as that format is written.
pub fn mims_mesh() -> String {
    let mut t = String::from("@M param 1.0\n@K param 0.1\n@Z param 0.01\n");
    let corner = |i: usize, j: usize| (i == 0 && j == 0) || (i == 19 && j == 29);
    for i in 0..20 {
        for j in 0..30 {
            let kind = if corner(i, j) { "ground 0." } else { "mass M 0. 0." };
            let _ = writeln!(t, "@n_m{i}_{j} {kind}");
        }
    }
    let mut r = 0;
    for i in 0..20 {
        for j in 0..30 {
            for (p, q) in [(i, j + 1), (i + 1, j)] {
                if p < 20 && q < 30 {
                    let _ = writeln!(t, "@n_r{r} springDamper @n_m{i}_{j} @n_m{p}_{q} K Z");
                    r += 1;
                }
            }
        }
    }
    t + "@in1 frcInput @n_m2_6\n@out1 posOutput @n_m19_3\n"
}

/// `n` grains of 5 mm in a shell that they fill to the part `fill`, each flying at `speed` \[diameters per tick\]; the
/// shell holds them, and all pairs of them may touch.
pub fn grains(n: usize, fill: f64, speed: f64) -> String {
    let diameter = 0.005;
    let radius = 0.5 * diameter * (n as f64 / fill).cbrt();
    let mut seed = 88_172_645_463_325_252u64;
    let mut next = || {
        seed ^= seed << 13;
        seed ^= seed >> 7;
        seed ^= seed << 17;
        (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let mut t = String::from("[room]\ndim = 3\n[room.SOL]\nmiddle = {}\n[room.MAS]\n");
    let mut at: Vec<[f64; 3]> = Vec::new();
    let square = |v: [f64; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let mut tries = 0;
    while at.len() < n {
        let p = [next(), next(), next()].map(|c| c * radius);
        tries += 1;
        // where no free place is left, they begin a little pressed
        let apart = diameter * if tries < 200 * n { 0.95 } else { 0.7 };
        if square(p) < radius * radius && at.iter().all(|q| square([0, 1, 2].map(|k| p[k] - q[k])) > apart * apart) {
            at.push(p);
        }
    }
    for (i, p) in at.iter().enumerate() {
        let v = [next(), next(), next()];
        let v = v.map(|c| c * speed * diameter * 48e3 / square(v).sqrt());
        let _ = writeln!(t, "g{i} = {{ m = \"0.5 g\", x = {p:?}, v = {v:?} }}");
    }
    let all: Vec<String> = (0..n).map(|i| format!("\"room.g{i}\"")).collect();
    let all = all.join(", ");
    let _ = writeln!(
        t,
        "[BUT]\nshell = {{ between = [\"room.middle\", [{all}]], k = \"200 kN/m\", d = {radius}, sense = \"inside\" }}"
    );
    let _ = writeln!(t, "hits = {{ between = [[{all}], [{all}]], k = \"200 kN/m\", d = {diameter} }}");
    t + "[SOX]\nout = { from = \"room.g0\", along = \"x\" }\n"
}
