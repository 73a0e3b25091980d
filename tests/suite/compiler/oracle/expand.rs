//! Expands generators to plain masses and springs, independently of the compiler, from their definitions.

use super::network::{Law, Link, Mat, MeasureKind, Network};
use super::numbers::{Numbers, entry, list, word};
use ca_model::Item;
use std::f64::consts::{FRAC_PI_2, PI};

/// The modules that a name stands for.
#[derive(Default, Clone)]
pub struct Family {
    pub masses: Vec<usize>,
    pub links: Vec<usize>,
    pub ends: Vec<usize>,
    /// Places between which a moving point moves, and their arrangement.
    pub nodes: Vec<usize>,
    pub size: [usize; 2],
}

/// A MAT of mass `m`, infinite if fixed, in the medium of its module.
pub fn mat(numbers: &Numbers, net: &mut Network, i: &Item, m: f64, p: f64, q: f64) -> usize {
    let c = if m == f64::INFINITY { 0.0 } else { numbers.tick_dt * numbers.tick_dt / m };
    let p = p - numbers.friction(i) / numbers.tick_dt * c;
    let mut weight = [0.0; 3];
    if c != 0.0 {
        weight = numbers.gravity(i).map(|g| g * m);
    }
    net.mats.push(Mat { axes: numbers.axes(i), rest: numbers.place(i, "x"), pqc: [p, q, c], weight, ..Mat::default() });
    net.mats.len() - 1
}

pub fn fixed(numbers: &Numbers, net: &mut Network, i: &Item) -> usize {
    mat(numbers, net, i, f64::INFINITY, 0.0, 0.0)
}

pub fn bank(numbers: &Numbers, net: &mut Network, i: &Item) -> Family {
    let n = entry(&i.args, "f").map_or(1, |l| list(l).len().max(1));
    let get = |key: &str, j: usize, power| {
        entry(&i.args, key).map(|v| numbers.value(list(v).get(j).map_or(v, |e| &e.value), power))
    };
    let cell = |j| {
        let (f, t60) = (get("f", j, -1.0).expect("f"), get("t60", j, 1.0).unwrap_or(f64::INFINITY));
        let (a, b) = numbers.heard_at(f, t60);
        mat(numbers, net, i, get("m", j, 2.0).expect("m"), 1.0 - b, -a)
    };
    Family { masses: (0..n).map(cell).collect(), size: [1, 1], ..Family::default() }
}

fn tie(net: &mut Network, family: &mut Family, a: usize, b: usize, k: f64, z: f64) {
    family.links.push(net.links.len());
    net.links.push(Link {
        ports: vec![([a, b], MeasureKind::Line([0, 0]))],
        e0: 0.0,
        law: Law::Linear { k, z },
        f: 0.0,
    });
}

/// Mass, damping to ground as the factor p, and eigenvalue kT²/m of the lowest mode if `f` is given.
fn matter(numbers: &Numbers, i: &Item, n: usize) -> (f64, f64, Option<f64>) {
    let tick_dt = numbers.tick_dt;
    let m = numbers.maybe(i, "m").unwrap_or_else(|| numbers.num(i, "m_total") / n as f64);
    let t60 = numbers.maybe(i, "t60");
    let zo = t60.map_or(numbers.num(i, "zo"), |t| numbers.heard_at(0.0, t).1 * m / tick_dt);
    let p = 1.0 - zo * tick_dt / m;
    (m, p, numbers.maybe(i, "f").map(|f| eigenvalue_at(f, p, tick_dt)))
}

/// (1 − r)² + 4r sin²(θ/2) of a mode heard at `f`, with r² = p.
fn eigenvalue_at(f: f64, p: f64, tick_dt: f64) -> f64 {
    let (r, half) = (p.max(0.0).sqrt(), libm::sin(PI * f * tick_dt));
    (1.0 - r) * (1.0 - r) + 4.0 * r * half * half
}

/// A row of masses: STRING, CHAIN or STIFFSTRING, between two fixed ends unless free.
///
/// A row of n between fixed ends has λ₁ = 4a sin²(π/2(n+1)), a free one 4a sin²(π/2n). Bending acts on second
/// differences. Their square is a spring of −kb to the second neighbour and shares of kb on the near springs.
pub fn row(numbers: &Numbers, net: &mut Network, i: &Item) -> Family {
    let (tick_dt, n, stiff) = (numbers.tick_dt, numbers.num(i, "n") as usize, i.kind == "STIFFSTRING");
    let free = i.kind == "CHAIN" || word(i, "ends") == "free";
    let (m, p, eigenvalue) = matter(numbers, i, n);
    let (mut k, mut bend) = (numbers.num(i, "k"), numbers.num(i, "kb"));
    if let Some(lambda) = eigenvalue {
        let n1 = n as f64 + 1.0;
        let s = libm::sin(FRAC_PI_2 / if free && !stiff { n as f64 } else { n1 });
        (k, bend) = if stiff {
            // partials 1 and 2 give two equations, linear in k and B
            let (b, f) = (numbers.num(i, "b"), numbers.num(i, "f"));
            let second = eigenvalue_at(2.0 * f * ((1.0 + 4.0 * b) / (1.0 + b)).sqrt(), p, tick_dt);
            let (s1, s2) = (s * s, libm::sin(PI / n1) * libm::sin(PI / n1));
            let (one, two, unit) = (lambda / (4.0 * s1), second / (4.0 * s2), m / (tick_dt * tick_dt));
            let bend = ((two - one) / (4.0 * (s2 - s1))).clamp(0.0, one / (4.0 * s1));
            ((one - 4.0 * bend * s1) * unit, bend * unit)
        } else {
            (lambda / (4.0 * s * s) * m / (tick_dt * tick_dt), 0.0)
        };
    }
    let ends = usize::from(!free);
    let place = |j| {
        let outside = j < ends || j >= n + ends;
        if outside { fixed(numbers, net, i) } else { mat(numbers, net, i, m, p, 0.0) }
    };
    let nodes: Vec<usize> = (0..n + 2 * ends).map(place).collect();
    let mut family = Family { masses: nodes[ends..n + ends].to_vec(), size: [nodes.len(), 1], ..Family::default() };
    if !free {
        family.ends = vec![nodes[0], nodes[n + 1]];
    }
    let last = nodes.len() - 2;
    for j in 0..=last {
        let (start, end) = (u32::from(j == 0), u32::from(j == last));
        let clamped = u32::from(word(i, "ends") == "fixed") * (start + end);
        let shares = f64::from(2 * (1 - start) + 2 * (1 - end) + clamped);
        let k = if stiff { k + shares * bend } else { k };
        tie(net, &mut family, nodes[j], nodes[j + 1], k, numbers.num(i, "z") / tick_dt);
    }
    if stiff && bend != 0.0 {
        (0..last).for_each(|j| tie(net, &mut family, nodes[j], nodes[j + 2], -bend, 0.0));
    }
    Family { nodes, ..family }
}

/// A grid of masses with springs to the neighbours, those along y first.
///
/// The lowest mode has λ₁ = 4a (sin²(π/2(nx−1)) + sin²(π/2(ny−1))) if held at the rim, else 4a sin²(π/2 max(nx, ny)).
pub fn mesh(numbers: &Numbers, net: &mut Network, i: &Item) -> Family {
    let (tick_dt, [nx, ny]) = (numbers.tick_dt, ["nx", "ny"].map(|key| numbers.num(i, key) as usize));
    let (m, p, eigenvalue) = matter(numbers, i, nx * ny);
    let sin2 = |n: usize| {
        let s = libm::sin(FRAC_PI_2 / n as f64);
        s * s
    };
    let closed = word(i, "edges") == "closed";
    let shape = if closed { sin2(nx - 1) + sin2(ny - 1) } else { sin2(nx.max(ny)) };
    let k = eigenvalue.map_or(numbers.num(i, "k"), |lambda| lambda / (4.0 * shape) * m / (tick_dt * tick_dt));
    let places = (0..nx).flat_map(|x| (0..ny).map(move |y| (x, y)));
    let place = |(x, y)| {
        let rim = [x == 0 || x == nx - 1, y == 0 || y == ny - 1];
        let held = match word(i, "edges") {
            "closed" => rim[0] || rim[1],
            "corner" => rim[0] && rim[1],
            _ => false,
        };
        if held { fixed(numbers, net, i) } else { mat(numbers, net, i, m, p, 0.0) }
    };
    let nodes: Vec<usize> = places.clone().map(place).collect();
    let mut family = Family { masses: nodes.clone(), size: [nx, ny], ..Family::default() };
    let z = numbers.num(i, "z") / tick_dt;
    for (x, y) in places.clone().filter(|(_, y)| *y > 0) {
        tie(net, &mut family, nodes[x * ny + y - 1], nodes[x * ny + y], k, z);
    }
    for (x, y) in places.filter(|(x, _)| *x > 0) {
        tie(net, &mut family, nodes[(x - 1) * ny + y], nodes[x * ny + y], k, z);
    }
    Family { nodes, ..family }
}
