//! Bodies in space, from their definitions: positions, starts and links of the masses of TETRA, GRAINS and CLOUD.

use super::expand::{Family, mat};
use super::network::{Law, Link, MeasureKind, Network, Past};
use super::numbers::{Numbers, entry, list};
use ca_model::Item;
use std::f64::consts::TAU;

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Rotates a point by a rotation vector, in turns: p cos + (n × p) sin + n (n·p)(1 − cos). Quarter turns are exact.
fn turned(turn: [f64; 3], p: [f64; 3]) -> [f64; 3] {
    let angle = dot(turn, turn).sqrt();
    if angle == 0.0 {
        return p;
    }
    let n = turn.map(|v| v / angle);
    let quarters = (4.0 * angle).round();
    let rest = TAU * (angle - 0.25 * quarters);
    let (s, c) = (libm::sin(rest), libm::cos(rest));
    let (s, c) = [(s, c), (c, -s), (-s, -c), (-c, s)][quarters as usize % 4];
    let (side, along) = (cross(n, p), dot(n, p));
    [0, 1, 2].map(|k| p[k] * c + side[k] * s + n[k] * (along * (1.0 - c)))
}

/// Corners of a body relative to its origin.
fn corners(numbers: &Numbers, i: &Item) -> Vec<[f64; 3]> {
    let n = numbers.num(i, "n") as usize;
    match i.kind.as_str() {
        "TETRA" => {
            let s = numbers.num(i, "edge") / 8f64.sqrt();
            vec![[s, s, s], [s, -s, -s], [-s, s, -s], [-s, -s, s]]
        }
        "GRAINS" => {
            let flat = if numbers.axes(i) == 3 { 30 } else { 0 };
            let square = |p: &[i32; 3]| p.iter().map(|v| v * v).sum::<i32>();
            let mut all: Vec<[i32; 3]> =
                (-30..=30).flat_map(|x| (-30..=30).flat_map(move |y| (-flat..=flat).map(move |z| [x, y, z]))).collect();
            all.sort_by_key(|p| (square(p), *p));
            all[..n].iter().map(|p| p.map(|v| f64::from(v) * numbers.num(i, "gap"))).collect()
        }
        _ => {
            let scale = numbers.maybe(i, "scale").unwrap_or(1.0);
            let point = |p| [0, 1, 2].map(|k: usize| numbers.value(&list(p)[k].value, 0.0) * scale);
            list(entry(&i.args, "points").expect("a list of points")).iter().map(|p| point(&p.value)).collect()
        }
    }
}

pub fn body(numbers: &Numbers, net: &mut Network, i: &Item) -> Family {
    let corners = corners(numbers, i);
    let m = numbers.maybe(i, "m").unwrap_or_else(|| numbers.num(i, "m_total") / corners.len() as f64);
    let (at, v) = (numbers.place(i, "x"), numbers.place(i, "v"));
    let (turn, spin) = (numbers.place(i, "turn"), numbers.place(i, "spin").map(|v| v * TAU));
    let mut family = Family { size: [1, 1], ..Family::default() };
    for p in &corners {
        let p = turned(turn, *p);
        let (mass, round) = (mat(numbers, net, i, m, 1.0, 0.0), cross(spin, p));
        net.mats[mass].rest = [0, 1, 2].map(|k| at[k] + p[k]);
        net.mats[mass].d = [0, 1, 2].map(|k| (v[k] + round[k]) * numbers.tick_dt);
        family.masses.push(mass);
    }
    let reach = numbers.maybe(i, "reach").unwrap_or(f64::INFINITY);
    let (k, z) = (numbers.num(i, "k"), numbers.num(i, "z") / numbers.tick_dt);
    for a in 0..if k == 0.0 { 0 } else { corners.len() } {
        for b in a + 1..corners.len() {
            let ends = [family.masses[a], family.masses[b]];
            let apart = [0, 1, 2].map(|k| net.mats[ends[1]].rest[k] - net.mats[ends[0]].rest[k]);
            let length = dot(apart, apart).sqrt();
            if length <= reach {
                family.links.push(net.links.len());
                let ports = vec![(ends, MeasureKind::Radial(apart, 0.0, Past::Stored(None)))];
                net.links.push(Link { ports, e0: -length, law: Law::Linear { k, z }, f: 0.0 });
            }
        }
    }
    family
}
