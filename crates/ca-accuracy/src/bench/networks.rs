//! Networks of the bench, as model texts of any size.
//!
//! Texts are used instead of scenes made by hand so that the bench measures what an author gets. Numbers differ from
//! module to module, by a generator that is the same everywhere.

use std::fmt::Write as _;

/// Network of any size.
pub struct Network {
    /// Name for `ca bench --only`.
    pub name: &'static str,
    /// Description.
    pub about: &'static str,
    /// Returns the text with this number of masses.
    pub text: fn(usize) -> String,
    /// Maximum number of masses.
    pub most: usize,
}

const MOST: usize = 400_000;

/// All networks: elements, then structures made of them, then space.
pub const NETWORKS: &[Network] = &[
    Network { name: "string", about: "MAS in a row, REF between them", text: |n| row(n, "REF", spring), most: MOST },
    Network { name: "cells", about: "CEL, each with a SOX", text: cells, most: MOST },
    Network { name: "mesh", about: "MAS on a grid, REF to four neighbours", text: mesh, most: MOST },
    Network { name: "random", about: "MAS, each with two REF to random others", text: random, most: MOST },
    Network { name: "RES", about: "MAS in a row, RES between them", text: |n| row(n, "RES", stiffness), most: MOST },
    Network { name: "FRO", about: "CEL in a row, FRO between them", text: |n| row(n, "FRO", viscosity), most: MOST },
    Network { name: "CUB", about: "CEL in a row, CUB between them", text: |n| row(n, "CUB", cubic), most: MOST },
    Network { name: "POW", about: "CEL in a row, POW between them", text: |n| row(n, "POW", power), most: MOST },
    Network { name: "LNL", about: "CEL in a row, LNL between them", text: |n| row(n, "LNL", table), most: MOST },
    Network {
        name: "BUT",
        about: "CEL in a row, BUT between them, half of them closed",
        text: |n| row(n, "BUT", contact),
        most: MOST,
    },
    Network {
        name: "HRZ",
        about: "CEL in a row, HRZ between them, half of them closed",
        text: |n| row(n, "HRZ", hertz),
        most: MOST,
    },
    Network {
        name: "PLK",
        about: "CEL in a row, PLK between them, that let go and engage",
        text: |n| row(n, "PLK", pluck),
        most: MOST,
    },
    Network { name: "ATT", about: "CEL in a row, ATT between them", text: |n| row(n, "ATT", attractor), most: MOST },
    Network { name: "BOW", about: "CEL in a row, BOW between them", text: |n| row(n, "BOW", bow), most: MOST },
    Network { name: "cloth", about: "MAS on a grid in space, REF to four neighbours", text: cloth, most: MOST },
    Network {
        name: "random 3-D",
        about: "MAS in space, each with two REF to random others",
        text: random_space,
        most: MOST,
    },
    Network { name: "LPR", about: "springs in space, each onto a separate CEL", text: lpr, most: MOST },
    Network { name: "GRAINS", about: "GRAINS in a bowl, BUT between near ones", text: grains, most: MOST },
    Network {
        name: "WAVEGUIDE",
        about: "WAVEGUIDE, each with an output, and a CEL connected to it by a REF",
        text: waveguides,
        most: MOST,
    },
    Network {
        name: "implicit",
        about: "the string with `method = \"implicit\"`",
        text: |n| format!("[model]\nmethod = \"implicit\"\n{}", row(n, "REF", spring)),
        most: MOST,
    },
    Network {
        name: "stable",
        about: "CEL in a row, BUT with `method = \"stable\"` between them, half of them closed",
        text: |n| row(n, "BUT", |r| contact(r) + ", method = \"stable\""),
        most: MOST,
    },
];

/// Numbers in [0, 1), the same on every machine: Knuth's linear congruential generator.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Returns a number within 20 % of `v`.
    fn near(&mut self, v: f64) -> f64 {
        v * (0.8 + 0.4 * self.next())
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.next() * n as f64) as usize).min(n - 1)
    }
}

fn spring(r: &mut Numbers) -> String {
    format!("k = {:.0}, z = {:.5}", r.near(2e5), r.near(2e-2))
}
fn stiffness(r: &mut Numbers) -> String {
    format!("k = {:.0}", r.near(2e5))
}
fn cubic(r: &mut Numbers) -> String {
    format!("k = {:.0}, k3 = {:.0}, z = {:.5}", r.near(1e4), r.near(1e8), r.near(1e-3))
}
fn viscosity(r: &mut Numbers) -> String {
    format!("z = {:.5}", r.near(1e-2))
}
fn power(r: &mut Numbers) -> String {
    format!("k = {:.0}, q = \"{:.0} N/m^2\", p = 2, z = {:.5}", r.near(1e4), r.near(1e7), r.near(1e-3))
}
fn pluck(r: &mut Numbers) -> String {
    format!("k = {:.0}, z = {:.5}, d = {:.7}", r.near(1e4), r.near(1e-3), r.near(3e-5))
}
fn attractor(r: &mut Numbers) -> String {
    format!("k = {:.0}, z = {:.5}, d = {:.7}", r.near(1e4), r.near(1e-4), r.near(3e-5))
}
fn table(r: &mut Numbers) -> String {
    let k = r.near(1e4);
    format!(
        "spring = [[-0.01, {:.3}], [-0.001, {:.3}], [0.001, {:.3}], [0.01, {:.3}]]",
        -0.02 * k,
        -1e-3 * k,
        1e-3 * k,
        0.02 * k
    )
}
fn contact(r: &mut Numbers) -> String {
    format!("k = {:.0}, z = {:.5}, d = {:.6}", r.near(1e4), r.near(1e-3), 1e-4 * (r.next() - 0.5))
}
fn hertz(r: &mut Numbers) -> String {
    format!("k = \"{:.0} N/m^1.5\", d = {:.6}", r.near(1e5), 1e-4 * (r.next() - 0.5))
}
fn bow(r: &mut Numbers) -> String {
    format!("curve = \"smooth\", f = {:.4}, v0 = {:.3}", r.near(0.01), r.near(0.5))
}

/// Returns masses in a row, with links of one kind between neighbours. Links that stiffen or let go are between cells,
/// so that the row does not drift.
fn row(n: usize, kind: &str, link: fn(&mut Numbers) -> String) -> String {
    let (mut r, n) = (Numbers(1), n.max(2));
    let mut t = String::from("[SOX]\nout = { from = \"m0\" }\n");
    if matches!(kind, "REF" | "RES") {
        t += "[MAS]\n";
        for i in 0..n {
            let _ = writeln!(t, "m{i} = {{ m = {:.7}, dx0 = {:.7} }}", r.near(1e-3), 1e-4 * (r.next() - 0.5));
        }
    } else {
        t += "[CEL]\n";
        for i in 0..n {
            let (m, dx0) = (r.near(1e-3), 1e-4 * (r.next() - 0.5));
            let _ = writeln!(t, "m{i} = {{ m = {m:.7}, k = {:.0}, z = 1e-4, dx0 = {dx0:.7} }}", r.near(2e4));
        }
    }
    let _ = writeln!(t, "[{kind}]");
    for i in 1..n {
        let _ = writeln!(t, "l{i} = {{ between = [\"m{}\", \"m{i}\"], {} }}", i - 1, link(&mut r));
    }
    t
}

fn cells(n: usize) -> String {
    let mut r = Numbers(2);
    let mut t = String::from("[CEL]\n");
    for i in 0..n {
        let _ = writeln!(
            t,
            "m{i} = {{ m = {:.7}, f = {:.2}, t60 = {:.3}, dx0 = 1e-4 }}",
            r.near(1e-3),
            r.near(800.0),
            r.near(1.0)
        );
    }
    t += "[SOX]\n";
    for i in 0..n {
        let _ = writeln!(t, "o{i} = {{ from = \"m{i}\", channel = 0, gain = {:.3} }}", r.near(1.0));
    }
    t
}

fn grid(w: usize, h: usize) -> impl Iterator<Item = (usize, usize)> {
    let along = (0..h).flat_map(move |j| (1..w).map(move |i| (j * w + i - 1, j * w + i)));
    let across = (1..h).flat_map(move |j| (0..w).map(move |i| ((j - 1) * w + i, j * w + i)));
    along.chain(across)
}

fn side(n: usize) -> usize {
    ((n as f64).sqrt().round() as usize).max(2)
}

fn net(n: usize, seed: u64, links: impl Iterator<Item = (usize, usize)>) -> String {
    let mut r = Numbers(seed);
    let mut t = String::from("[SOX]\nout = { from = \"m0\" }\n[MAS]\n");
    for i in 0..n {
        let _ = writeln!(t, "m{i} = {{ m = {:.7}, dx0 = {:.7} }}", r.near(1e-3), 1e-4 * (r.next() - 0.5));
    }
    t += "[REF]\n";
    for (i, (a, b)) in links.enumerate() {
        let _ =
            writeln!(t, "l{i} = {{ between = [\"m{a}\", \"m{b}\"], k = {:.0}, z = {:.5} }}", r.near(8e4), r.near(5e-3));
    }
    t
}

fn mesh(n: usize) -> String {
    let s = side(n);
    net(s * s, 3, grid(s, s))
}

/// Two links from each mass to others: a tree that connects the network, and one more.
fn pairs(n: usize) -> Vec<(usize, usize)> {
    let mut r = Numbers(4);
    let tree: Vec<_> = (1..n).map(|i| (r.below(i), i)).collect();
    let more = (0..n).map(|i| (i, (i + 1 + r.below(n - 1)) % n));
    let more: Vec<_> = more.collect();
    tree.into_iter().chain(more).collect()
}

fn random(n: usize) -> String {
    let n = n.max(3);
    // a mass of a tree may have many links, so all of them are softer
    net(n, 5, pairs(n).into_iter())
}

/// Returns masses in space with these places and links.
fn space(places: &[[f64; 3]], links: impl Iterator<Item = (usize, usize)>) -> String {
    let mut r = Numbers(6);
    let mut t = String::from("[air]\ndim = 3\n[SOX]\nout = { from = \"air.m0\", along = \"z\" }\n[air.MAS]\n");
    for (i, p) in places.iter().enumerate() {
        let v = [(); 3].map(|()| 0.1 * (r.next() - 0.5));
        let _ = writeln!(t, "m{i} = {{ m = {:.7}, x = {p:?}, v = {v:?} }}", r.near(1e-3));
    }
    t += "[REF]\n";
    for (i, (a, b)) in links.enumerate() {
        let _ = writeln!(
            t,
            "l{i} = {{ between = [\"air.m{a}\", \"air.m{b}\"], k = {:.0}, z = {:.5} }}",
            r.near(2e4),
            r.near(2e-3)
        );
    }
    t
}

fn cloth(n: usize) -> String {
    let s = side(n);
    let places: Vec<[f64; 3]> = (0..s * s).map(|k| [0.01 * (k % s) as f64, 0.01 * (k / s) as f64, 0.0]).collect();
    space(&places, grid(s, s))
}

fn random_space(n: usize) -> String {
    let (mut r, n) = (Numbers(7), n.max(3));
    let places: Vec<[f64; 3]> = (0..n).map(|_| [(); 3].map(|()| 0.1 * r.next())).collect();
    space(&places, pairs(n).into_iter())
}

fn lpr(n: usize) -> String {
    let (mut r, n) = (Numbers(8), (n / 3).max(2));
    let mut t = String::from("[air]\ndim = 3\n[SOX]\nout = { from = \"c1\" }\n[SOL]\nwall = {}\n[air.MAS]\n");
    for i in 0..n {
        let v = [(); 3].map(|()| 0.1 * (r.next() - 0.5));
        let x = [0.01 * (i % 100) as f64, 0.01 * (i / 100) as f64, 0.01 * (i % 2) as f64];
        let _ = writeln!(t, "b{i} = {{ m = {:.7}, x = {x:?}, v = {v:?} }}", r.near(1e-3));
    }
    t += "[CEL]\n";
    for i in 1..n {
        let _ = writeln!(t, "c{i} = {{ m = {:.7}, f = {:.2}, t60 = 1 }}", r.near(1e-3), r.near(800.0));
    }
    t += "[LPR]\n";
    for i in 1..n {
        let _ = writeln!(
            t,
            "l{i} = {{ between = [\"air.b{}\", \"air.b{i}\"], onto = [\"wall\", \"c{i}\"], k = {:.0}, z = {:.5} }}",
            i - 1,
            r.near(2e4),
            r.near(2e-3)
        );
    }
    t
}

/// Cells that each drive a waveguide.
fn waveguides(n: usize) -> String {
    let (mut r, n) = (Numbers(9), (n / 2).max(1));
    let mut t = String::from("[CEL]\n");
    for i in 0..n {
        let _ = writeln!(t, "m{i} = {{ m = {:.7}, f = {:.2}, t60 = 1, dx0 = 1e-4 }}", r.near(1e-3), r.near(800.0));
    }
    t += "[WAVEGUIDE]\n";
    for i in 0..n {
        let f = r.near(220.0);
        let _ = writeln!(t, "w{i} = {{ f = {f:.2}, t60 = {:.3}, z = {:.4}, at = 0.3 }}", r.near(2.0), r.near(0.5));
    }
    t += "[REF]\n";
    for i in 0..n {
        let _ = writeln!(t, "l{i} = {{ between = [\"m{i}\", \"w{i}[0]\"], {} }}", spring(&mut r));
    }
    t += "[SOX]\n";
    for i in 0..n {
        let _ = writeln!(t, "o{i} = {{ from = \"w{i}[0]\", channel = 0 }}");
    }
    t
}

/// Loose masses in a sphere; they fill a few per cent of it at any number.
fn grains(n: usize) -> String {
    let side = (n as f64).cbrt();
    format!(
        "[air]\ndim = 3\ngravity = \"9.81 m/s^2\"\n[air.GRAINS]\nhail = {{ n = {n}, m = \"0.1 g\", gap = \"8 mm\", v = [0.3, 0.1, 0] }}\n\
         [air.SOL]\ncentre = {{}}\n[BUT]\nbowl = {{ between = [\"air.centre\", \"air.hail[*]\"], k = 2000, z = 0.02, d = {:.4}, sense = \"inside\" }}\n\
         apart = {{ between = [\"air.hail[*]\", \"air.hail[*]\"], pairs = \"all\", k = 2000, z = 0.02, d = \"5 mm\" }}\n\
         [SOX]\nout = {{ from = \"air.hail[0]\", along = \"z\" }}\n",
        0.008 * side + 0.01
    )
}
