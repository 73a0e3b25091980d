//! Builds plain modules from the text of a model: names, links and their laws, inputs and outputs.

use super::bodies::body;
use super::expand::{Family, bank, fixed, mat, mesh, row};
use super::listed::{Listed, drawn, kind};
use super::network::{Law, Link, Mat, MeasureKind, Network, OutputSignal, Past, Point, Port};
use super::numbers::{Numbers, entry, list, word};
use super::waves::string;
use ca_core::Role;
use ca_model::select::{At, Coord, Index, Part, parse};
use ca_model::{Item, Model, Value};
use std::collections::BTreeMap;

struct Builder<'a> {
    numbers: Numbers<'a>,
    net: Network,
    names: BTreeMap<String, Family>,
    /// Moving points by their text: the same text is the same point.
    points: BTreeMap<String, usize>,
}

pub fn build(model: &Model) -> Network {
    let (names, points) = (BTreeMap::new(), BTreeMap::new());
    let mut b = Builder { numbers: Numbers::new(model), net: Network::default(), names, points };
    model.items.iter().for_each(|i| b.module(i));
    model.items.iter().filter(|i| entry(&i.args, "between").is_some()).for_each(|i| b.link(i));
    for i in &model.items {
        match i.kind.as_str() {
            "ENF" => {
                let to = b.pick(word(i, "to")).1;
                let axis = b.numbers.along(i).map_or(0, |n| n.iter().position(|v| *v == 1.0).expect("an axis"));
                let port = b.net.ports.iter_mut().find(|p| p.name == i.name).expect("its port");
                (port.to, port.axis) = (to, axis);
            }
            "SOX" | "SOF" => b.output(i),
            _ => {}
        }
    }
    b.net.start();
    b.net
}

impl Builder<'_> {
    fn num(&self, i: &Item, key: &str) -> f64 {
        self.numbers.num(i, key)
    }

    fn module(&mut self, i: &Item) {
        let (numbers, net) = (&self.numbers, &mut self.net);
        let one = |at: usize| Family { masses: vec![at], size: [1, 1], ..Family::default() };
        let family = match i.kind.as_str() {
            "MAS" | "CEL" => {
                let (tick_dt, m) = (numbers.tick_dt, numbers.num(i, "m"));
                let (a, b) = match numbers.maybe(i, "f") {
                    _ if i.kind == "MAS" => (0.0, 0.0),
                    Some(f) => numbers.heard_at(f, numbers.maybe(i, "t60").unwrap_or(f64::INFINITY)),
                    None => (numbers.num(i, "k") * (tick_dt * tick_dt / m), numbers.num(i, "z") * tick_dt / m),
                };
                let at = mat(numbers, net, i, m, 1.0 - b, -a);
                (net.mats[at].x, net.mats[at].d) =
                    (numbers.place(i, "dx0"), numbers.place(i, "v").map(|v| v * tick_dt));
                one(at)
            }
            "SOL" => one(fixed(numbers, net, i)),
            "ENX" | "TGR" | "ENF" => {
                let period = match i.kind.as_str() {
                    "ENX" => Some(1),
                    "TGR" => Some(numbers.ratio),
                    _ => None,
                };
                let family = if period.is_some() { one(fixed(numbers, net, i)) } else { Family::default() };
                let axes = if i.kind == "ENF" { 1 } else { numbers.axes(i) };
                let given = entry(&i.args, "dof").filter(|_| axes > 1).map_or(axes, |v| list(v).len());
                for axis in 0..given {
                    let name = if axes == 1 { i.name.clone() } else { format!("{}.{}", i.name, ["x", "y", "z"][axis]) };
                    net.ports.push(Port { name, to: family.masses.clone(), axis, period, held: 0.0, from: 0.0 });
                }
                family
            }
            "TETRA" | "GRAINS" | "CLOUD" => body(numbers, net, i),
            "BANK" => bank(numbers, net, i),
            "STRING" | "CHAIN" | "STIFFSTRING" => row(numbers, net, i),
            "WAVEGUIDE" => string(numbers, net, i),
            "MESH" => mesh(numbers, net, i),
            _ => match kind(i).role {
                Role::Generator(g) => drawn(numbers, net, i, g),
                _ => return,
            },
        };
        self.names.insert(i.name.clone(), family);
    }

    /// Resolves a selector: true and links, or false and MATs.
    fn pick(&mut self, text: &str) -> (bool, Vec<usize>) {
        let s = parse(text).expect("a selector");
        let family = self.names[&s.name].clone();
        if let Some(At(at)) = &s.at {
            return (false, vec![self.point(text, family, at)]);
        }
        let links = s.part == Part::Link || s.part == Part::Mass && family.masses.is_empty();
        let all = match s.part {
            Part::End => family.ends,
            _ if links => family.links,
            _ => family.masses,
        };
        let [nx, ny] = family.size;
        let wrap = |i: i64, n: usize| (if i < 0 { i + n as i64 } else { i }) as usize;
        let chosen = match s.index {
            Index::None | Index::All => all,
            Index::One(i) => vec![all[wrap(i, all.len())]],
            Index::Two(i, j) => vec![all[wrap(i, nx) * ny + wrap(j, ny)]],
            Index::Range(a, b) => all[wrap(a, all.len())..wrap(b, all.len())].to_vec(),
        };
        (links, chosen)
    }

    fn point(&mut self, text: &str, family: Family, at: &[Coord]) -> usize {
        if let Some(mat) = self.points.get(text) {
            return *mat;
        }
        let mut place = |c: &Coord| {
            let rest = match c {
                Coord::Num(v) => *v,
                Coord::Name(n) if self.names.contains_key(n) => return self.names[n].masses[0],
                Coord::Name(n) => self.numbers.value(&n.as_str().into(), 0.0),
            };
            self.net.mats.push(Mat { axes: 1, rest: [rest, 0.0, 0.0], ..Mat::default() });
            self.net.mats.len() - 1
        };
        let at = at.iter().map(&mut place).collect();
        let mat = self.net.mats.len();
        self.net.mats.push(Mat { axes: 1, rest: self.net.mats[family.nodes[0]].rest, ..Mat::default() });
        self.net.points.push(Point { mat, nodes: family.nodes, size: family.size, at });
        self.points.insert(text.into(), mat);
        mat
    }

    fn side(&mut self, v: &Value) -> Vec<usize> {
        match v {
            Value::Text(t) => self.pick(t).1,
            v => list(v).iter().flat_map(|e| self.side(&e.value)).collect(),
        }
    }

    fn link(&mut self, i: &Item) {
        let sides = |key: &str| entry(&i.args, key).map(|v| [&list(v)[0].value, &list(v)[1].value]);
        let [a, b] = sides("between").expect("between").map(|v| self.side(v));
        let onto = sides("onto").map(|s| s.map(|v| self.side(v)));
        let first = self.net.links.len();
        let mut pairs: Vec<[usize; 2]> = Vec::new();
        if word(i, "pairs") == "all" || a.len() > 1 && a == b {
            for (j, from) in a.iter().enumerate() {
                let start = if a == b { j + 1 } else { 0 };
                b[start..].iter().for_each(|to| pairs.push([*from, *to]));
            }
        } else {
            (0..a.len().max(b.len())).for_each(|j| pairs.push([a[j.min(a.len() - 1)], b[j.min(b.len() - 1)]]));
        }
        for (j, ends) in pairs.into_iter().enumerate() {
            self.tie(i, ends, onto.as_ref().map(|s| [0, 1].map(|k| s[k][j.min(s[k].len() - 1)])));
        }
        let links = (first..self.net.links.len()).collect();
        self.names.insert(i.name.clone(), Family { links, ..Family::default() });
    }

    /// A port between two ends: how it measures, its constant part of the elongation at rest, and its length at rest.
    fn port(&self, i: &Item, ends: [usize; 2], along: Option<[f64; 3]>) -> (MeasureKind, f64, f64) {
        let [a, b] = ends.map(|m| &self.net.mats[m]);
        let apart = [0, 1, 2].map(|k| b.rest[k] - a.rest[k]);
        let axis = |m: &Mat| if m.axes == 1 { Some(0) } else { along?.iter().position(|v| *v == 1.0) };
        match (axis(a), axis(b), along) {
            (Some(j), Some(k), _) => {
                let d = b.rest[k] - a.rest[j];
                (MeasureKind::Line([j, k]), d, d)
            }
            (.., Some(n)) => {
                let d = n[0] * apart[0] + n[1] * apart[1] + n[2] * apart[2];
                (MeasureKind::Along(n), d, d)
            }
            (.., None) => {
                let soft = self.num(i, "soften");
                let distance = apart.iter().map(|v| v * v).sum::<f64>().sqrt();
                (MeasureKind::Radial(apart, soft * soft, Past::Stored(None)), 0.0, distance)
            }
        }
    }

    fn tie(&mut self, i: &Item, ends: [usize; 2], onto: Option<[usize; 2]>) {
        let (measure, e0, distance) = self.port(i, ends, self.numbers.along(i));
        let soft = |l: f64, g: &MeasureKind| match g {
            MeasureKind::Radial(_, soft, _) if *soft != 0.0 => (l * l + soft).sqrt(),
            _ => l,
        };
        let length = if kind(i).param("l0").is_some() { self.numbers.maybe(i, "l0").unwrap_or(distance) } else { 0.0 };
        let mut e0 = e0 - soft(length, &measure);
        if onto.is_none()
            && length == 0.0
            && ["RES", "FRO", "REF"].contains(&i.kind.as_str())
            && matches!(measure, MeasureKind::Radial(..))
        {
            // a link of zero length has no direction
            for k in 0..self.net.mats[ends[0]].axes.max(self.net.mats[ends[1]].axes) {
                let e0 = self.net.mats[ends[1]].rest[k] - self.net.mats[ends[0]].rest[k];
                let ports = vec![(ends, MeasureKind::Line([k, k]))];
                self.net.links.push(Link { ports, e0, law: self.law(i), f: 0.0 });
            }
            return;
        }
        let (law, mut ports) = (self.law(i), vec![(ends, measure)]);
        if let Some(ends) = onto {
            let (measure, constant, distance) = self.port(i, ends, None);
            e0 += constant - soft(distance, &measure);
            ports.push((ends, measure));
        } else if let (MeasureKind::Radial(.., past), true) = (&mut ports[0].1, law.passes()) {
            *past = Past::Motion;
        }
        self.net.links.push(Link { ports, e0, law, f: 0.0 });
    }

    fn law(&self, i: &Item) -> Law {
        let tick_dt = self.numbers.tick_dt;
        let [k, d, f] = ["k", "d", "f"].map(|key| self.num(i, key));
        let [z, h] = ["z", "h"].map(|key| self.num(i, key) / tick_dt);
        let quarters = (4.0 * self.numbers.maybe(i, "p").unwrap_or(1.5)) as u32;
        let side = if word(i, "sense") == "inside" { -1.0 } else { 1.0 };
        match (i.kind.strip_prefix("LPR_").unwrap_or(&i.kind), word(i, "curve")) {
            ("RES" | "FRO" | "REF" | "LPR", _) => Law::Linear { k, z },
            ("CUB", _) => Law::Cubic { k, k3: self.num(i, "k3"), z },
            ("POW", _) => Law::Power { k, q: self.num(i, "q"), quarters, z },
            ("BUT", _) => Law::Buffer { k, z, d, side, sticky: entry(&i.args, "sticky") != Some(&Value::Bool(false)) },
            ("HRZ", _) => Law::Hertz { k, quarters, h, d, side },
            ("PLK", _) => {
                let value = |key: &str| i.args.iter().find(|e| e.key == key).map(|e| &e.value);
                let side = match value("side") {
                    Some(Value::Text(t)) if t == "up" => 1.0,
                    Some(Value::Text(t)) if t == "down" => -1.0,
                    _ => 0.0,
                };
                let engaged = value("engaged") != Some(&Value::Bool(false));
                Law::Pluck { k, z, d, side, engaged, held: None, last: 0.0 }
            }
            ("ATT", _) => Law::Attract { k, z, d, rho: self.numbers.maybe(i, "rho").unwrap_or(0.5) },
            ("LNL", _) => {
                let (spring, friction) =
                    (self.numbers.curve(i, "spring", 0.0), self.numbers.curve(i, "friction", -1.0));
                Law::Curves { spring, friction, tick_dt }
            }
            ("BOW", "table") => Law::Curves { spring: None, friction: self.numbers.curve(i, "points", -1.0), tick_dt },
            ("BOW", curve) => {
                let v0 = self.num(i, "v0") * tick_dt;
                let v1 = self.numbers.maybe(i, "v1").map_or(3.0 * v0, |v| (v * tick_dt).max(v0 * (1.0 + 1e-9)));
                match curve {
                    "coulomb" => Law::Stribeck { f, fd: f, v0, v1 },
                    "piecewise" => Law::Stribeck { f, fd: self.num(i, "fd").min(f), v0, v1 },
                    _ => {
                        // u exp((1 − u²)/2), by linear interpolation from 0 to 8 as documented for the kind
                        let u = (0..=4096).map(|j| 8.0 * f64::from(j) / 4096.0);
                        let bell = u.map(|u| [u, u * libm::exp(0.5 - 0.5 * u * u)]).collect();
                        Law::Smooth { f, v0, bell }
                    }
                }
            }
            _ => Law::Listed(Listed::new(&self.numbers, i)),
        }
    }

    fn output(&mut self, i: &Item) {
        let gain = self.numbers.maybe(i, "gain").unwrap_or(1.0);
        let n = self.numbers.along(i).unwrap_or([1.0, 0.0, 0.0]);
        let hear = i.args.iter().find(|e| e.key == "hear").map_or("position", |_| word(i, "hear"));
        assert_ne!(hear, "acceleration", "outputs.rs has a test of it");
        let per_tick = if hear == "speed" { 1.0 / self.numbers.tick_dt } else { 1.0 };
        let from = entry(&i.args, "from").expect("from");
        let (links, chosen) = match from {
            Value::List(all) => (false, all.iter().flat_map(|e| self.side(&e.value)).collect()),
            _ => self.pick(word(i, "from")),
        };
        let minus = i.args.iter().find(|e| e.key == "minus").map(|_| self.pick(word(i, "minus")).1);
        for (j, at) in chosen.into_iter().enumerate() {
            let channel = self.numbers.maybe(i, "channel").map_or(self.net.channels(), |c| c as usize);
            let other = minus.as_ref().map(|m| (m[j], -per_tick));
            for (at, factor) in [(at, per_tick)].into_iter().chain(other) {
                let signal = |k: usize| match (i.kind.as_str(), hear) {
                    _ if links => OutputSignal::ForceOf(at),
                    ("SOF", _) | (_, "force") => OutputSignal::ForceOn(at, k),
                    (_, "speed") => OutputSignal::Motion(at, k),
                    _ => OutputSignal::Position(at, k),
                };
                let axes = (0..3).filter(|k| n[*k] != 0.0);
                self.net.outputs.extend(axes.map(|k| (channel, n[k] * factor * gain, signal(k))));
            }
        }
    }
}
