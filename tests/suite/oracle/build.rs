//! From the text of a model to plain modules: what names mean, who is linked to whom by which law, what goes in and out.

use super::expand::{Family, bank, fixed, mat, mesh, row};
use super::network::{Heard, Law, Link, Mat, Network, Point, Port};
use super::numbers::{Numbers, entry, list, word};
use ca_core::model::select::{At, Coord, Index, Part, parse};
use ca_core::model::{Item, Model, Value};
use std::collections::BTreeMap;

struct Builder<'a> {
    numbers: Numbers<'a>,
    net: Network,
    names: BTreeMap<String, Family>,
    /// moving points by their text: the same text is the same point
    points: BTreeMap<String, usize>,
}

/// The network of a model, ready for its first tick.
pub fn build(model: &Model) -> Network {
    let (names, points) = (BTreeMap::new(), BTreeMap::new());
    let mut b = Builder { numbers: Numbers::new(model), net: Network::default(), names, points };
    model.items.iter().for_each(|i| b.module(i));
    model.items.iter().filter(|i| entry(&i.args, "between").is_some()).for_each(|i| b.link(i));
    for i in &model.items {
        match i.kind.as_str() {
            "ENF" => {
                let to = b.pick(word(i, "to")).1;
                b.net.ports.iter_mut().find(|p| p.name == i.name).expect("its port").to = to;
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
                let (te, m) = (numbers.te, numbers.num(i, "m"));
                let (a, b) = match numbers.maybe(i, "f") {
                    _ if i.kind == "MAS" => (0.0, 0.0),
                    Some(f) => numbers.heard_at(f, numbers.maybe(i, "t60").unwrap_or(f64::INFINITY)),
                    None => (numbers.num(i, "k") * (te * te / m), numbers.num(i, "z") * te / m),
                };
                let at = mat(numbers, net, i, m, 1.0 - b, -a);
                (net.mats[at].x, net.mats[at].d) = (numbers.num(i, "dx0"), numbers.num(i, "v") * te);
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
                let (name, to) = (i.name.clone(), family.masses.clone());
                net.ports.push(Port { name, to, period, held: 0.0, from: 0.0 });
                family
            }
            "BANK" => bank(numbers, net, i),
            "STRING" | "CHAIN" | "STIFFSTRING" => row(numbers, net, i),
            "MESH" => mesh(numbers, net, i),
            _ => return,
        };
        self.names.insert(i.name.clone(), family);
    }

    /// What a selector means: true and links, or false and MATs.
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
            self.net.mats.push(Mat { rest, ..Mat::default() });
            self.net.mats.len() - 1
        };
        let at = at.iter().map(&mut place).collect();
        let mat = self.net.mats.len();
        self.net.mats.push(Mat { rest: self.net.mats[family.nodes[0]].rest, ..Mat::default() });
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
        let between = list(entry(&i.args, "between").expect("between"));
        let (a, b) = (self.side(&between[0].value), self.side(&between[1].value));
        let first = self.net.links.len();
        if word(i, "pairs") == "all" {
            for (j, from) in a.iter().enumerate() {
                let start = if a == b { j + 1 } else { 0 };
                b[start..].iter().for_each(|to| self.tie(i, [*from, *to]));
            }
        } else {
            for j in 0..a.len().max(b.len()) {
                self.tie(i, [a[j.min(a.len() - 1)], b[j.min(b.len() - 1)]]);
            }
        }
        let links = (first..self.net.links.len()).collect();
        self.names.insert(i.name.clone(), Family { links, ..Family::default() });
    }

    fn tie(&mut self, i: &Item, ends: [usize; 2]) {
        let distance = self.net.mats[ends[1]].rest - self.net.mats[ends[0]].rest;
        let springs = ["RES", "FRO", "REF", "CUB", "POW", "LNL"].contains(&i.kind.as_str());
        let slack = if springs { self.numbers.maybe(i, "l0").unwrap_or(distance) } else { 0.0 };
        self.net.links.push(Link { ends, e0: distance - slack, law: self.law(i), f: 0.0 });
    }

    fn law(&self, i: &Item) -> Law {
        let te = self.numbers.te;
        let [k, d, f] = ["k", "d", "f"].map(|key| self.num(i, key));
        let [z, h] = ["z", "h"].map(|key| self.num(i, key) / te);
        let quarters = (4.0 * self.numbers.maybe(i, "p").unwrap_or(1.5)) as u32;
        let side = if word(i, "sense") == "inside" { -1.0 } else { 1.0 };
        match (i.kind.as_str(), word(i, "curve")) {
            ("RES" | "FRO" | "REF", _) => Law::Linear { k, z },
            ("CUB", _) => Law::Cubic { k, k3: self.num(i, "k3"), z },
            ("POW", _) => Law::Power { k, q: self.num(i, "q"), quarters, z },
            ("BUT", _) => Law::Buffer { k, z, d, side, sticky: entry(&i.args, "sticky") != Some(&Value::Bool(false)) },
            ("HRZ", _) => Law::Hertz { k, quarters, h, d, side },
            ("PLK", _) => Law::Pluck { k, z, d, held: None, last: 0.0 },
            ("ATT", _) => Law::Attract { k, z, d, rho: self.numbers.maybe(i, "rho").unwrap_or(0.5) },
            ("LNL", _) => {
                let (spring, friction) =
                    (self.numbers.curve(i, "spring", 0.0), self.numbers.curve(i, "friction", -1.0));
                Law::Curves { spring, friction, te }
            }
            ("BOW", "table") => Law::Curves { spring: None, friction: self.numbers.curve(i, "points", -1.0), te },
            ("BOW", curve) => {
                let v0 = self.num(i, "v0") * te;
                let v1 = self.numbers.maybe(i, "v1").map_or(3.0 * v0, |v| (v * te).max(v0 * (1.0 + 1e-9)));
                match curve {
                    "coulomb" => Law::Stribeck { f, fd: f, v0, v1 },
                    "piecewise" => Law::Stribeck { f, fd: self.num(i, "fd").min(f), v0, v1 },
                    _ => {
                        // u exp((1 − u²)/2), by straight lines from 0 to 8 as the kind's page says
                        let u = (0..=4096).map(|j| 8.0 * f64::from(j) / 4096.0);
                        let bell = u.map(|u| [u, u * libm::exp(0.5 - 0.5 * u * u)]).collect();
                        Law::Smooth { f, v0, bell }
                    }
                }
            }
            (other, _) => panic!("the oracle does not know {other}"),
        }
    }

    fn output(&mut self, i: &Item) {
        let (links, chosen) = self.pick(word(i, "from"));
        let gain = self.numbers.maybe(i, "gain").unwrap_or(1.0);
        for at in chosen {
            let heard = match i.kind.as_str() {
                _ if links => Heard::ForceOf(at),
                "SOF" => Heard::ForceOn(at),
                _ => Heard::Position(at),
            };
            let channel = self.numbers.maybe(i, "channel").map_or(self.net.channels(), |c| c as usize);
            self.net.outputs.push((channel, gain, heard));
        }
    }
}
