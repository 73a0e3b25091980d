//! Code shared by the benches and by the tests of their pages: scenes, measurements, pages.
// only benches call these, so a failure is a defect of the bench
#![allow(clippy::missing_errors_doc, clippy::missing_panics_doc)]

pub mod accuracy;
pub mod acoustics;
pub mod atlas;
pub mod costs;
mod grains;
pub mod instruments;
pub mod latency;
pub mod peers;
pub mod proven;
pub mod rattle;
mod table;

use ca_compile::{KernelClass, Options, compile};
use ca_core::Scene;
use ca_model::Model;
pub use cordis_anima::catalog;
pub use grains::grains;
use std::fmt::Write as _;

/// Describes this machine and the vector extensions between which the engine chooses.
pub fn machine() -> String {
    let reported = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let flags: Vec<&str> =
        reported.lines().find(|l| l.starts_with("flags")).unwrap_or_default().split_whitespace().collect();
    let has: Vec<&str> = ["avx2", "avx512f"].into_iter().filter(|f| flags.contains(f)).collect();
    let vectors = if has.is_empty() { "neither AVX2 nor AVX-512".into() } else { has.join(" and ") };
    let name = reported.lines().find_map(|l| l.strip_prefix("model name")).and_then(|l| l.split_once(": "));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let virtual_one = if reported.contains("hypervisor") { ", a virtual one that it shares with others" } else { "" };
    format!(
        "{cores} cores of {}{virtual_one}, with {vectors}",
        name.map_or("a kind it does not tell", |(_, name)| name.trim())
    )
}

/// Prints a page of `docs/measured`; with `UPDATE=1` also writes it there, if it is `whole`.
pub fn publish(name: &str, page: &str, whole: bool) {
    println!("{page}");
    if whole && std::env::var_os("UPDATE").is_some() {
        let path = format!("{}/../docs/measured/{name}.md", env!("CARGO_MANIFEST_DIR"));
        std::fs::write(&path, page).unwrap_or_else(|e| panic!("{path}: {e}"));
    }
}

/// Formats a figure with `digits` decimals, and says whether it is at most `most`.
pub fn at_most(is: f64, digits: usize, most: Option<f64>) -> String {
    let Some(most) = most else { return format!("{is:.digits$}") };
    let holds = if is <= most { "holds" } else { "**not so**" };
    format!("{is:.digits$} (≤ {most}: {holds})")
}

/// Reads a model of a bench; panics on errors in it.
pub fn model(text: &str) -> Model {
    let (model, findings) = ca_model::read::read(text, "bench.ca.toml", &catalog());
    assert!(!findings.has_errors(), "{findings}");
    model
}

/// Compiles the scene of a text with the fastest kernels.
pub fn scene(text: &str) -> Scene {
    compiled(&model(text), KernelClass::Fast, false)
}

/// Returns the index of the MAT `name` in the state.
pub fn mat(scene: &Scene, name: &str) -> usize {
    (0..scene.counts.n_mat).find(|i| scene.mat_name(*i) == name).unwrap_or_else(|| panic!("no MAT `{name}`"))
}

/// Compiles a model with one class of kernels.
pub fn compiled(model: &Model, kernel: KernelClass, energy: bool) -> Scene {
    compile(model, &catalog(), &Options { kernel, energy, ..Options::default() }).expect("the bench compiles").scene
}

/// Returns the text of a string of `n` masses made by its generator.
pub fn string(n: usize) -> String {
    format!(
        "[STRING]\ns = {{ n = {n}, m = \"1 g\", k = \"100 kN/m\", z = \"1 mN s/m\" }}\n[SOX]\nout = {{ from = \"s[3]\" }}\n"
    )
}

/// Returns the text of a mesh of `n` × `n` masses made by its generator.
pub fn mesh(n: usize) -> String {
    format!(
        "[MESH]\ns = {{ nx = {n}, ny = {n}, m = \"1 g\", k = \"50 kN/m\", z = \"1 mN s/m\" }}\n[SOX]\nout = {{ from = \"s[3,3]\" }}\n"
    )
}

/// Returns the text of a string of `n` masses with every module written out.
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

/// Returns the text of `masses` joined at random by `links` REF: the worst case, since no links form a run.
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

/// Returns a MIMS file of a 20 × 30 mesh held at two corners, one line per module, as the format requires.
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
