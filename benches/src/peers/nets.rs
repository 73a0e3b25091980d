//! Networks that peers play. Parameters differ from module to module, because a program specialised for equal modules
//! is not comparable; the stencils are such programs.
//!
//! Everything moves from the start, and loads keep their size, because decaying numbers change the time of a tick.

use super::net::{Kind, Law, Net};

/// Stiffness and viscosity of the stencils (`benches/peers/stencil.c`), and start position of the mass at a third.
const STIFF: f64 = 0.2;
const VISCOUS: f64 = 0.005;
const START: f64 = 1e-3;

/// Pseudo-random numbers in 0 … 1, the same on every machine: Knuth's linear congruential generator.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.next() * n as f64) as usize).min(n - 1)
    }

    fn m(&mut self) -> f64 {
        1.0 + 0.2 * self.next()
    }

    /// Returns a spring with damper, of about `k`.
    fn spring(&mut self, k: f64) -> Law {
        Law::Ref(k * (0.3 + 0.2 * self.next()), 2e-5 * (0.5 + self.next()), 0.0)
    }

    /// Returns the start position of a mass on a line.
    fn place(&mut self) -> f64 {
        1e-4 * (self.next() - 0.5)
    }

    fn mas(&mut self, net: &mut Net) -> usize {
        let (m, x) = (self.m(), self.place());
        net.mat(Kind::Mas, m, x)
    }

    /// Adds `n` masses between two fixed ends; returns all in order.
    fn string(&mut self, net: &mut Net, n: usize) -> Vec<usize> {
        let mut row = vec![net.mat(Kind::Sol, 1.0, 0.0)];
        row.extend((0..n).map(|_| self.mas(net)));
        net.mats[row[1 + n / 3]].x[0] = START;
        row.push(net.mat(Kind::Sol, 1.0, 0.0));
        for ends in row.windows(2) {
            net.lia(self.spring(0.5), ends[0], ends[1]);
        }
        row
    }

    /// Adds `n` × `n` masses with free edges; returns all by rows.
    fn mesh(&mut self, net: &mut Net, n: usize) -> Vec<usize> {
        let all: Vec<usize> = (0..n * n).map(|_| self.mas(net)).collect();
        net.mats[all[n * (n / 3) + n / 3]].x[0] = START;
        for (a, b) in grid(n) {
            net.lia(self.spring(0.3), all[a], all[b]);
        }
        all
    }

    /// Returns random links between `n` ends, none with more than six. They start with a tree, because the compiler
    /// leaves out modules not connected to an output.
    fn links(&mut self, n: usize, links: usize) -> Vec<(usize, usize)> {
        let mut degree = vec![0; n];
        let mut all = Vec::new();
        while all.len() < links {
            let tree = all.len() + 1;
            let b = if tree < n { tree } else { self.below(n) };
            let a = self.below(if tree < n { tree } else { n });
            if a != b && degree[a] < 6 && degree[b] < 6 {
                degree[a] += 1;
                degree[b] += 1;
                all.push((a, b));
            }
        }
        all
    }
}

/// Returns the links of a grid of `n` × `n`, along its rows, then across.
fn grid(n: usize) -> impl Iterator<Item = (usize, usize)> {
    let along = (0..n).flat_map(move |j| (1..n).map(move |i| (j * n + i - 1, j * n + i)));
    let across = (1..n).flat_map(move |j| (0..n).map(move |i| ((j - 1) * n + i, j * n + i)));
    along.chain(across)
}

/// Makes a string.
pub fn string(n: usize) -> Net {
    let mut net = Net::new(&format!("string {n}"), false);
    let row = Numbers(1).string(&mut net, n);
    net.outputs = vec![row[4]];
    net
}

/// Makes a mesh with free edges.
pub fn mesh(n: usize) -> Net {
    let mut net = Net::new(&format!("mesh {n}×{n}"), false);
    let all = Numbers(2).mesh(&mut net, n);
    net.outputs = vec![all[3 * n + 3]];
    net
}

/// Makes masses joined at random.
pub fn random(masses: usize, links: usize) -> Net {
    let mut net = Net::new(&format!("random {masses}/{links}"), false);
    let mut r = Numbers(3);
    for _ in 0..masses {
        r.mas(&mut net);
    }
    net.mats[7].x[0] = START;
    for (a, b) in r.links(masses, links) {
        net.lia(r.spring(0.2), a, b);
    }
    net.outputs = vec![3];
    net
}

/// A cell that swings up from below and strikes.
const HAMMER: Kind = Kind::Cel { k: 2.2e-4, z: 2e-4 };
const BELOW: f64 = -2e-3;

/// Makes three strings on a mesh, struck by eight hammers each way, with one of the strings bowed.
pub fn mixture() -> Net {
    let mut net = Net::new("mixture", false);
    let mut r = Numbers(4);
    let strings: Vec<_> = (0..3).map(|_| r.string(&mut net, 60)).collect();
    let mesh = r.mesh(&mut net, 10);
    for i in 0..8 {
        let hammer = net.mat(HAMMER, 5.0, BELOW);
        net.lia(Law::But(0.02, 1e-3, 0.0), hammer, strings[i % 3][7 + 5 * i]);
    }
    for i in 0..8 {
        let hammer = net.mat(HAMMER, 5.0, BELOW);
        net.lia(Law::Hrz(1.3, 0.0), hammer, mesh[10 * (1 + i) + 2 + i % 5]);
    }
    // too heavy to be slowed down
    let bow = net.mat(Kind::Mas, 1e9, 0.0);
    net.mats[bow].v[0] = 4e-6;
    net.lia(Law::Bow(9e-8, 1e-6), strings[0][9], bow);
    for (s, string) in strings.iter().enumerate() {
        net.lia(Law::Ref(9e-3, 2e-4, 0.0), string[60], mesh[30 * s + 9]);
    }
    net.outputs = vec![strings[0][4]];
    net
}

/// Makes cells, each with an output.
pub fn cells(n: usize) -> Net {
    let mut net = Net::new(&format!("{n} CEL, {n} SOX"), false);
    for i in 0..n {
        let w = std::f64::consts::TAU * 100.0 * 1.06_f64.powf(i as f64) / 48_000.0;
        let cell = net.mat(Kind::Cel { k: w * w, z: 4.6 / 48_000.0 }, 1.0, START);
        net.outputs.push(cell);
    }
    net
}

/// Makes twelve strings of 30 masses on one bridge, struck by twelve felt hammers, one after the other.
pub fn piano() -> Net {
    let mut net = Net::new("piano 12×30", false);
    let mut r = Numbers(5);
    let bridge = net.mat(Kind::Cel { k: 0.05, z: 0.01 }, 50.0, 0.0);
    for i in 0..12 {
        let row = r.string(&mut net, 30);
        net.lia(Law::Ref(0.05, 1e-4, 0.0), row[30], bridge);
        let hammer = net.mat(Kind::Cel { k: 1e-6, z: 1e-4 }, 10.0, BELOW);
        net.mats[hammer].v[0] = 2e-6 + 3e-7 * f64::from(i);
        net.lia(Law::Hrz(1.0, 0.0), hammer, row[5]);
    }
    net.outputs = vec![bridge];
    net
}

/// Makes masses in space, with springs between them that are a hundredth shorter than their distances.
fn space(name: &str, places: &[[f64; 3]], links: impl Iterator<Item = (usize, usize)>, r: &mut Numbers) -> Net {
    let mut net = Net::new(name, true);
    for x in places {
        let mass = net.mat(Kind::Mas, r.m(), 0.0);
        net.mats[mass].x = *x;
    }
    for (a, b) in links {
        let far: f64 = (0..3).map(|e| (places[a][e] - places[b][e]).powi(2)).sum();
        let Law::Ref(k, z, _) = r.spring(0.1) else { continue };
        net.lia(Law::Ref(k, z, 0.99 * far.sqrt()), a, b);
    }
    net.outputs = vec![3];
    net
}

/// Makes a cloth in space, not quite flat.
pub fn cloth(n: usize) -> Net {
    let mut r = Numbers(6);
    let at = |k: usize, r: &mut Numbers| [0.01 * (k / n) as f64, 0.01 * (k % n) as f64, 5e-4 * r.next()];
    let places: Vec<_> = (0..n * n).map(|k| at(k, &mut r)).collect();
    space(&format!("cloth {n}×{n}, 3-D"), &places, grid(n), &mut r)
}

/// Makes masses in space joined at random.
pub fn random_space(masses: usize, links: usize) -> Net {
    let mut r = Numbers(7);
    let places: Vec<_> = (0..masses).map(|_| [r.next(), r.next(), r.next()]).collect();
    let links_at = r.links(masses, links);
    space(&format!("random {masses}/{links}, 3-D"), &places, links_at.into_iter(), &mut r)
}

/// Makes grains in a shell, with contacts between all pairs: first on a grid of `n` × `n` × `n`, each with its own
/// velocity.
pub fn grains(n: usize) -> Net {
    let mut net = Net::new(&format!("{} grains, 3-D", n * n * n), true);
    let mut r = Numbers(8);
    let (diameter, gap) = (0.005, 0.006);
    let middle = net.mat(Kind::Sol, 1.0, 0.0);
    let centre = 0.5 * (n - 1) as f64;
    let mut all = Vec::new();
    for k in 0..n * n * n {
        let grain = net.mat(Kind::Mas, r.m(), 0.0);
        net.mats[grain].x = [k / (n * n), k / n % n, k % n].map(|i| gap * (i as f64 - centre));
        net.mats[grain].v = [(); 3].map(|()| 4e-5 * (r.next() - 0.5));
        all.push(grain);
    }
    let radius = gap * centre * 3_f64.sqrt();
    for grain in &all {
        net.lia(Law::Inside(0.1, 1e-3, radius), middle, *grain);
    }
    for (i, a) in all.iter().enumerate() {
        for b in &all[i + 1..] {
            net.lia(Law::But(0.1, 1e-3, diameter), *a, *b);
        }
    }
    net.outputs = vec![all[0]];
    net.pairs = Some(all);
    net
}

/// Makes the network of a stencil: all modules equal, with fixed ends or edges.
pub fn alike(mesh: bool, n: usize, damped: bool) -> Net {
    let mut net = Net::new("all alike", false);
    let link = Law::Ref(STIFF, if damped { VISCOUS } else { 0.0 }, 0.0);
    let wall = net.mat(Kind::Sol, 1.0, 0.0);
    let count = if mesh { n * n } else { n };
    let all: Vec<usize> = (0..count).map(|_| net.mat(Kind::Mas, 1.0, 0.0)).collect();
    let at = |i: usize| if mesh { all[n * i + i] } else { all[i] };
    net.mats[at(n / 3)].x[0] = START;
    net.outputs = vec![at(3)];
    if mesh {
        for (a, b) in grid(n) {
            net.lia(link, all[a], all[b]);
        }
        for i in 0..n {
            for edge in [i, n * (n - 1) + i, n * i, n * i + n - 1] {
                net.lia(link, wall, all[edge]);
            }
        }
    } else {
        net.lia(link, wall, all[0]);
        for i in 1..n {
            net.lia(link, all[i - 1], all[i]);
        }
        net.lia(link, all[n - 1], wall);
    }
    net
}
