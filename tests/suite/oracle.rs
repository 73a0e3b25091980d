//! The oracle: a model played module by module, a plain loop over a `Vec`, written without the compiler.
use ca_core::model::select::{At, Coord, Index, Part, parse};
use ca_core::model::{Entry, Item, Model, Value, quantity};
use std::collections::BTreeMap;

type Law = Box<dyn FnMut(f64, f64) -> f64>;
#[derive(Default, Clone)]
pub struct Mat {
    pub x: f64,
    d: f64,
    f: f64,
    rest: f64,
    p: f64,
    q: f64,
    c: f64,
    weight: f64,
}
pub struct Lia {
    ends: [usize; 2],
    e0: f64,
    pub f: f64,
    law: Law,
    pub bends: bool,
}
enum Place {
    At(f64),
    Of(usize),
}
struct Point {
    mat: usize,
    nodes: Vec<usize>,
    size: [usize; 2],
    at: Vec<Place>,
    cell: Vec<(usize, f64)>,
}
pub struct Port {
    pub name: String,
    role: u8,
    to: Vec<usize>,
    held: f64,
    from: f64,
}
enum Heard {
    X(usize),
    F(usize),
    Of(usize),
}
#[derive(Default, Clone)]
struct Family {
    masses: Vec<usize>,
    links: Vec<usize>,
    tips: Vec<usize>,
    nodes: Vec<usize>,
    size: [usize; 2],
}
#[rustfmt::skip]
pub struct Oracle<'a> {
    model: &'a Model, te: f64, alg: Option<f64>, ratio: u64, n: u64, pub mats: Vec<Mat>, pub lias: Vec<Lia>,
    points: Vec<Point>, seen: BTreeMap<String, usize>, pub ports: Vec<Port>, outs: Vec<(usize, f64, Heard)>,
    channels: usize, names: BTreeMap<String, Family>,
}
fn entry<'e>(list: &'e [Entry], key: &str) -> Option<&'e Value> {
    list.iter().find(|e| e.key == key).map(|e| &e.value)
}
fn list(v: &Value) -> &[Entry] {
    if let Value::List(l) = v { l } else { &[] }
}
fn word<'i>(i: &'i Item, key: &str) -> &'i str {
    if let Some(Value::Text(t)) = entry(&i.args, key) { t } else { "" }
}
fn quarters(x: f64, n: u32) -> f64 {
    let (mut y, r) = ((0..n / 4).fold(1.0, |y, _| y * x), x.sqrt());
    if n & 2 != 0 {
        y *= r;
    }
    if n & 1 != 0 { y * r.sqrt() } else { y }
}
fn table(t: Vec<[f64; 2]>) -> impl Fn(f64) -> f64 {
    move |x| {
        let i = t.partition_point(|p| p[0] <= x);
        if i == 0 {
            return t[0][1];
        }
        let [[x0, y0], [x1, y1]] = [t[i - 1], *t.get(i).unwrap_or(&[f64::INFINITY, t[i - 1][1]])];
        y0 + (y1 - y0) * ((x - x0) / (x1 - x0))
    }
}
#[rustfmt::skip]
impl<'a> Oracle<'a> {
    pub fn new(model: &'a Model) -> Oracle<'a> {
        let mut o = Oracle { model, te: 0.0, alg: None, ratio: 1, n: 0, mats: vec![], lias: vec![], points: vec![],
            seen: BTreeMap::new(), ports: vec![], outs: vec![], channels: 0, names: BTreeMap::new() };
        let sound = entry(&model.rate, "sound").map_or(48e3, |v| o.value(v, 0.0));
        let gesture = entry(&model.rate, "gesture").map_or(sound / (sound / 3000.0).round().max(1.0), |v| o.value(v, 0.0));
        (o.te, o.ratio) = (1.0 / sound, (sound / gesture).round() as u64);
        if model.meta("units").is_some_and(|e| e.value == "alg".into()) {
            o.alg = Some(model.meta("reference_rate").map_or(o.te, |e| 1.0 / o.value(&e.value, 0.0)));
        }
        model.items.iter().for_each(|i| o.node(i));
        for i in &model.items { if entry(&i.args, "between").is_some() { o.link(i); } }
        for i in &model.items { match i.kind.as_str() { "ENF" => {
            let to = o.pick(word(i, "to")).1; o.ports.iter_mut().find(|p| p.name == i.name).unwrap().to = to; }
            "SOX" | "SOF" => o.output(i), _ => {} } }
        let before = o.mats.clone();
        o.forces();
        for (m, b) in o.mats.iter_mut().zip(before) {
            m.d = if b.c == 0.0 { 0.0 } else { b.d - 0.5 * (b.c * m.f + b.q * b.x - (1.0 - b.p) * b.d) };
            m.f = 0.0;
        }
        o
    }
    fn value(&self, v: &Value, power: f64) -> f64 {
        let bare = self.alg.map_or(1.0, |tr| libm::pow(tr, power));
        let q = |t: &str| quantity::parse(t).map_or(f64::NAN, |q| if q.has_unit { q.value } else { q.value * bare });
        match v {
            Value::Num(v) => v * bare, Value::Bool(b) => f64::from(u8::from(*b)), Value::Text(t) if quantity::is_quantity(t) => q(t),
            Value::Text(t) => match entry(&self.model.params, t) {
                Some(Value::Table(p)) => match (entry(p, "value"), entry(p, "unit")) {
                    (Some(Value::Num(v)), Some(Value::Text(u))) if !u.is_empty() => q(&format!("{v} {u}")),
                    (v, _) => self.value(v.unwrap(), power) },
                v => self.value(v.unwrap_or(&Value::Num(f64::NAN)), power) },
            _ => f64::NAN } }
    fn maybe(&self, i: &Item, key: &str) -> Option<f64> {
        let power = match (i.kind.as_str(), key) { (_, "m" | "m_total") => 2.0, (_, "z" | "zo" | "t60" | "h") => 1.0,
            ("BOW", "f") => 0.0, (_, "f" | "v" | "v0" | "v1") => -1.0, _ => 0.0 };
        entry(&i.args, key).map(|v| self.value(v, power)) }
    fn num(&self, i: &Item, key: &str) -> f64 { self.maybe(i, key).unwrap_or(0.0) }
    fn medium(&self, i: &Item, key: &str, power: f64) -> f64 {
        let group = i.group.and_then(|g| entry(&self.model.groups[g].props, key));
        group.or(self.model.meta(key).map(|e| &e.value)).map_or(0.0, |v| self.value(v, power)) }
    fn points_of(&self, i: &Item, key: &str, power: f64) -> Option<Vec<[f64; 2]>> {
        let pair = |e: &Entry| { let l = list(&e.value); [self.value(&l[0].value, power), self.value(&l[1].value, 0.0)] };
        entry(&i.args, key).map(|v| list(v).iter().map(pair).collect()) }
    /// k and z as ratios a = kT²/m, b = zT/m of what is heard at `f` and gone after `t60`.
    fn heard_at(&self, f: f64, t60: f64) -> (f64, f64) {
        let s = 3.0 * std::f64::consts::LN_10 / t60;
        let (q, sin) = (-libm::expm1(-s * self.te), libm::sin(std::f64::consts::PI * f * self.te));
        (q * q + 4.0 * (1.0 - q) * sin * sin, -libm::expm1(-2.0 * s * self.te)) }
    fn mat(&mut self, i: &Item, m: f64, p: f64, q: f64) -> usize {
        let (c, rest) = (if m == f64::INFINITY { 0.0 } else { self.te * self.te / m }, self.num(i, "x"));
        let (p, g) = (p - self.medium(i, "friction", 1.0) / self.te * c, self.medium(i, "gravity", -2.0));
        let weight = if c == 0.0 { 0.0 } else { -g * m };
        self.mats.push(Mat { rest, p, q, c, weight, ..Mat::default() }); self.mats.len() - 1 }
    fn node(&mut self, i: &Item) {
        let (te, m, mut f) = (self.te, self.num(i, "m"), Family { size: [1, 1], ..Family::default() });
        match i.kind.as_str() {
            "MAS" | "SOL" | "CEL" => {
                let c = te * te / m;
                let (p, q, m) = match (i.kind.as_str(), self.maybe(i, "f")) { ("SOL", _) => (0.0, 0.0, f64::INFINITY), ("MAS", _) => (1.0, 0.0, m),
                    (_, None) => (1.0 - self.num(i, "z") * te / m, -self.num(i, "k") * c, m),
                    (_, Some(f)) => { let (a, b) = self.heard_at(f, self.maybe(i, "t60").unwrap_or(f64::INFINITY)); (1.0 - b, -a, m) } };
                let at = self.mat(i, m, p, q);
                (self.mats[at].x, self.mats[at].d) = (self.num(i, "dx0"), self.num(i, "v") * te);
                f.masses.push(at); }
            "ENX" | "TGR" | "ENF" => {
                if i.kind != "ENF" { f.masses.push(self.mat(i, f64::INFINITY, 0.0, 0.0)); }
                let role = match i.kind.as_str() { "ENX" => 0, "TGR" => 1, _ => 2 };
                self.ports.push(Port { name: i.name.clone(), role, to: f.masses.clone(), held: self.num(i, "x"), from: 0.0 }); }
            "BANK" => { let v = |k: &str| entry(&i.args, k); let n = v("f").map_or(1, |l| list(l).len().max(1));
                let get = |k: &str, j: usize, p| v(k).map(|v| self.value(list(v).get(j).map_or(v, |e| &e.value), p));
                let cells: Vec<_> = (0..n).map(|j| (get("m", j, 2.0).unwrap(), self.heard_at(get("f", j, -1.0).unwrap(), get("t60", j, 1.0).unwrap_or(f64::INFINITY)))).collect();
                f.masses = cells.into_iter().map(|(m, (a, b))| self.mat(i, m, 1.0 - b, -a)).collect(); }
            "STRING" | "CHAIN" | "STIFFSTRING" | "MESH" => self.net(i, &mut f),
            _ => return }
        self.names.insert(i.name.clone(), f); }
    fn net(&mut self, i: &Item, fam: &mut Family) {
        let (te, mesh, [nx, ny]) = (self.te, i.kind == "MESH", ["nx", "ny"].map(|k| self.num(i, k) as usize));
        let n = if mesh { nx * ny } else { self.num(i, "n") as usize };
        let m = self.maybe(i, "m").unwrap_or_else(|| self.num(i, "m_total") / n as f64);
        let zo = self.maybe(i, "t60").map_or(self.num(i, "zo"), |t| self.heard_at(0.0, t).1 * m / te);
        let (free, unit, p) = (i.kind == "CHAIN" || word(i, "ends") == "free", m / (te * te), 1.0 - zo * te / m);
        let sin2 = |n: f64| { let s = libm::sin(std::f64::consts::FRAC_PI_2 / n); s * s };
        let (r, n1) = ((1.0 - zo * te / m).max(0.0).sqrt(), n as f64 + 1.0);
        let (mut k, mut bend) = (self.num(i, "k"), self.num(i, "kb"));
        if let Some(f) = self.maybe(i, "f") {
            let half = libm::sin(std::f64::consts::PI * f * te);
            let lambda = (1.0 - r) * (1.0 - r) + 4.0 * r * half * half;
            let beta = self.num(i, "b") * n1 * n1 / (std::f64::consts::PI * std::f64::consts::PI);
            let s = libm::sin(std::f64::consts::FRAC_PI_2 / n1);
            let a = match i.kind.as_str() { "STIFFSTRING" => lambda / (4.0 * s * s * (1.0 + 4.0 * beta * s * s)),
                "MESH" if word(i, "edges") == "closed" => lambda / (4.0 * (sin2(nx as f64 - 1.0) + sin2(ny as f64 - 1.0))),
                "MESH" => lambda / (4.0 * sin2(nx.max(ny) as f64)), _ if free => { let s = libm::sin(std::f64::consts::FRAC_PI_2 / n as f64); lambda / (4.0 * s * s) }
                _ => lambda / (4.0 * s * s) };
            (k, bend) = if i.kind == "STIFFSTRING" { (a * unit, beta * a * unit) } else { (a * m / (te * te), 0.0) };
        }
        let z = self.num(i, "z") / te;
        let tie = |o: &mut Self, fam: &mut Family, a: usize, b: usize, k: f64, z: f64| { fam.links.push(o.lias.len());
            o.lias.push(Lia { ends: [a, b], e0: 0.0, f: 0.0, law: Box::new(move |e, w| k * e + z * w), bends: false }); };
        if mesh {
            for (x, y) in (0..nx).flat_map(|x| (0..ny).map(move |y| (x, y))) {
                let rim = [x == 0 || x == nx - 1, y == 0 || y == ny - 1];
                let held = match word(i, "edges") { "closed" => rim[0] || rim[1], "corner" => rim[0] && rim[1], _ => false };
                let at = if held { self.mat(i, f64::INFINITY, 0.0, 0.0) } else { self.mat(i, m, p, 0.0) }; fam.masses.push(at); }
            let g = fam.masses.clone();
            for (x, y) in (0..nx).flat_map(|x| (1..ny).map(move |y| (x, y))) { tie(self, fam, g[x * ny + y - 1], g[x * ny + y], k, z); }
            for (x, y) in (1..nx).flat_map(|x| (0..ny).map(move |y| (x, y))) { tie(self, fam, g[(x - 1) * ny + y], g[x * ny + y], k, z); }
            (fam.nodes, fam.size) = (g, [nx, ny]);
            return; }
        let ends = usize::from(!free);
        let row: Vec<usize> = (0..n + 2 * ends).map(|j| if j < ends || j >= n + ends { self.mat(i, f64::INFINITY, 0.0, 0.0) } else { self.mat(i, m, p, 0.0) }).collect();
        let last = row.len() - 2;
        for j in 0..=last {
            let clamp = u32::from(word(i, "ends") == "fixed") * (u32::from(j == 0) + u32::from(j == last));
            let shares = f64::from(2 * u32::from(j > 0) + 2 * u32::from(j < last) + clamp);
            let k = if i.kind == "STIFFSTRING" { k + shares * bend } else { k }; tie(self, fam, row[j], row[j + 1], k, z); }
        if i.kind == "STIFFSTRING" && bend != 0.0 { for j in 0..last { tie(self, fam, row[j], row[j + 2], -bend, 0.0); } }
        (fam.masses, fam.tips) = (row[ends..n + ends].to_vec(), if free { vec![] } else { vec![row[0], row[n + 1]] });
        (fam.size, fam.nodes) = ([row.len(), 1], row); }
    /// What a selector means: true and links, or false and MATs.
    fn pick(&mut self, text: &str) -> (bool, Vec<usize>) {
        let s = parse(text).unwrap(); let f = self.names[&s.name].clone();
        if let Some(At(at)) = s.at {
            if let Some(p) = self.seen.get(text) { return (false, vec![*p]); }
            let place = |c: &Coord| match c { Coord::Num(v) => Place::At(*v), Coord::Name(n) => self.names.get(n).map_or_else(
                || Place::At(self.value(&n.as_str().into(), 0.0)), |f| Place::Of(f.masses[0])) };
            let at = at.iter().map(place).collect();
            self.mats.push(Mat { rest: self.mats[f.nodes[0]].rest, ..Mat::default() });
            let mat = self.mats.len() - 1; self.seen.insert(text.into(), mat);
            self.points.push(Point { mat, nodes: f.nodes, size: f.size, at, cell: vec![] });
            return (false, vec![mat]); }
        let links = s.part == Part::Link || s.part == Part::Mass && f.masses.is_empty();
        let all = match s.part { Part::End => f.tips, _ if links => f.links, _ => f.masses };
        let wrap = |i: i64, n: usize| (if i < 0 { i + n as i64 } else { i }) as usize;
        (links, match s.index { Index::None | Index::All => all, Index::One(i) => vec![all[wrap(i, all.len())]],
            Index::Two(i, j) => vec![all[wrap(i, f.size[0]) * f.size[1] + wrap(j, f.size[1])]],
            Index::Range(a, b) => all[wrap(a, all.len())..wrap(b, all.len())].to_vec() }) }
    fn side(&mut self, v: &Value) -> Vec<usize> {
        if let Value::Text(t) = v { self.pick(t).1 } else { list(v).to_vec().iter().flat_map(|e| self.side(&e.value)).collect() } }
    fn link(&mut self, i: &Item) {
        let l = list(entry(&i.args, "between").unwrap()); let (a, b) = (self.side(&l[0].value), self.side(&l[1].value));
        let pairs: Vec<[usize; 2]> = if word(i, "pairs") == "all" {
            let twice = a == b; (0..a.len()).flat_map(|i| (if twice { i + 1 } else { 0 }..b.len()).map(move |j| (i, j))).map(|(i, j)| [a[i], b[j]]).collect()
        } else { (0..a.len().max(b.len())).map(|i| [a[i.min(a.len() - 1)], b[i.min(b.len() - 1)]]).collect() };
        let own = Family { links: (self.lias.len()..self.lias.len() + pairs.len()).collect(), ..Family::default() };
        for ends in pairs {
            let distance = self.mats[ends[1]].rest - self.mats[ends[0]].rest;
            let slack = matches!(i.kind.as_str(), "RES" | "FRO" | "REF" | "CUB" | "POW" | "LNL");
            let e0 = distance - if slack { self.maybe(i, "l0").unwrap_or(distance) } else { 0.0 };
            let bends = !matches!(i.kind.as_str(), "RES" | "FRO" | "REF");
            let law = self.law(i); self.lias.push(Lia { ends, e0, f: 0.0, law, bends }); }
        self.names.insert(i.name.clone(), own); }
    fn law(&self, i: &Item) -> Law {
        let (te, v) = (self.te, |k: &str| self.num(i, k)); let [k, z, d, f, h] = ["k", "z", "d", "f", "h"].map(v);
        let (z, h, n) = (z / te, h / te, (4.0 * self.maybe(i, "p").unwrap_or(1.5)) as u32);
        let side = if word(i, "sense") == "inside" { -1.0 } else { 1.0 };
        match (i.kind.as_str(), word(i, "curve")) {
            ("RES" | "FRO" | "REF", _) => Box::new(move |e, w| k * e + z * w),
            ("BUT", _) => { let clip = entry(&i.args, "sticky") == Some(&Value::Bool(false)); Box::new(move |e, w| {
                let f = if side * (e - d) < 0.0 { k * (e - d) + z * w } else { 0.0 }; if clip && side * f > 0.0 { 0.0 } else { f } }) }
            ("CUB", _) => { let k3 = v("k3"); Box::new(move |e, w| (k + k3 * e * e) * e + z * w) }
            ("POW", _) => { let q = v("q"); Box::new(move |e, w| k * e + q * quarters(e.abs(), n).copysign(e) + z * w) }
            ("HRZ", _) => Box::new(move |e, w| { let eta = side * (d - e);
                if eta > 0.0 { -side * (k * quarters(eta, n) * (1.0 - h * side * w)).max(0.0) } else { 0.0 } }),
            ("LNL", _) => { let (s, f) = (self.points_of(i, "spring", 0.0).map(table), self.points_of(i, "friction", -1.0).map(table));
                Box::new(move |e, w| match (&s, &f) { (Some(s), Some(f)) => s(e) + f(w * (1.0 / te)), (Some(s), _) => s(e), (_, f) => f.as_ref().unwrap()(w * (1.0 / te)) }) }
            ("PLK", _) => { let (mut on, mut last) = (None, 0.0); Box::new(move |e, w| {
                let held = *on.get_or_insert(e.abs() < d); let crossed = last <= 0.0 && e >= 0.0 || last >= 0.0 && e <= 0.0;
                on = Some(e.abs() < d && (held || crossed)); last = e; if on == Some(true) { k * e + z * w } else { 0.0 } }) }
            ("ATT", _) => { let rho = self.maybe(i, "rho").unwrap_or(0.5); Box::new(move |e, w| { let r = e.abs();
                if r < rho * d { k * e + z * w } else if r < d { (k * rho / (1.0 - rho) * (d - r)).copysign(e) + z * w } else { 0.0 } }) }
            ("BOW", "table") => { let t = table(self.points_of(i, "points", -1.0).unwrap()); Box::new(move |_, w| t(w * (1.0 / te))) }
            ("BOW", curve) => { let (v0, fd) = (v("v0") * te, v("fd").min(f));
                let v1 = self.maybe(i, "v1").map_or(3.0 * v0, |v| (v * te).max(v0 * (1.0 + 1e-9)));
                let bell = table((0..=4096).map(|j| 8.0 * f64::from(j) / 4096.0).map(|u| [u, u * libm::exp(0.5 - 0.5 * u * u)]).collect());
                match curve { "coulomb" => Box::new(move |_, w| (f / v0 * w).min(f).max(-f)),
                    "piecewise" => Box::new(move |_, w| { let v = w.abs(); if v < v0 { f / v0 * w } else if v < v1 { (fd + (f - fd) / (v1 - v0) * (v1 - v)).copysign(w) } else { fd.copysign(w) } }),
                    _ => Box::new(move |_, w| { let u = w * (1.0 / v0); (f * bell(u.abs())).copysign(u) }) } }
            (other, _) => panic!("the oracle does not know {other}") } }
    fn output(&mut self, i: &Item) {
        let ((links, ids), gain) = (self.pick(word(i, "from")), self.maybe(i, "gain").unwrap_or(1.0));
        for id in ids {
            let channel = self.maybe(i, "channel").map_or(self.channels, |c| c as usize); self.channels = self.channels.max(channel + 1);
            self.outs.push((channel, gain, if links { Heard::Of(id) } else if i.kind == "SOF" { Heard::F(id) } else { Heard::X(id) })); } }
    fn forces(&mut self) {
        for p in &mut self.points {
            let u = |c: &Place| match c { Place::At(v) => v.clamp(0.0, 1.0), Place::Of(m) => (self.mats[*m].x + self.mats[*m].rest).clamp(0.0, 1.0) };
            let step = |u: f64, n: usize| { let at = u * (n - 1) as f64; let i = (at as usize).min(n - 2); (i, at - i as f64) };
            let (i, a) = step(u(&p.at[0]), p.size[0]);
            p.cell = if p.size[1] == 1 { vec![(p.nodes[i], 1.0 - a), (p.nodes[i + 1], a)] } else {
                let (j, b) = step(u(&p.at[1]), p.size[1]); let at = |i: usize, j: usize| p.nodes[i * p.size[1] + j];
                vec![(at(i, j), (1.0 - a) * (1.0 - b)), (at(i, j + 1), (1.0 - a) * b), (at(i + 1, j), a * (1.0 - b)), (at(i + 1, j + 1), a * b)] };
            (self.mats[p.mat].x, self.mats[p.mat].d) = p.cell.iter().fold((0.0, 0.0), |(x, d), (n, w)| (x + w * self.mats[*n].x, d + w * self.mats[*n].d));
        }
        for m in &mut self.mats { m.f += m.weight; }
        for l in &mut self.lias {
            let [a, b] = l.ends; l.f = (l.law)(self.mats[b].x - self.mats[a].x + l.e0, self.mats[b].d - self.mats[a].d);
            self.mats[a].f += l.f; self.mats[b].f -= l.f; }
        for p in &self.points { for (n, w) in &p.cell { self.mats[*n].f += w * self.mats[p.mat].f; } }
    }
    /// One tick with the values of the ports, in their order; writes the channels.
    pub fn tick(&mut self, inputs: &[f64], out: &mut [f64]) {
        let phase = if self.n == 0 { 0 } else { (self.n - 1) % self.ratio + 1 };
        for (p, v) in self.ports.iter_mut().zip(inputs) {
            if p.role == 2 { p.to.iter().for_each(|m| self.mats[*m].f += v); continue; }
            let m = &mut self.mats[p.to[0]];
            if p.role == 0 || phase <= 1 { (p.from, p.held) = (if self.n == 0 { v - m.rest } else { p.held }, v - m.rest); }
            let way = if p.role == 0 || phase == 0 || phase == self.ratio { p.held } else { p.from + phase as f64 / self.ratio as f64 * (p.held - p.from) };
            (m.d, m.x) = (if self.n == 0 { 0.0 } else { way - m.x }, way); }
        self.forces();
        out.fill(0.0);
        for (c, gain, heard) in &self.outs { out[*c] += gain * match heard { Heard::X(m) => self.mats[*m].x, Heard::F(m) => self.mats[*m].f, Heard::Of(l) => self.lias[*l].f }; }
        for m in &mut self.mats {
            if m.c != 0.0 { m.d = m.p * m.d + m.q * m.x + m.c * m.f; m.x += m.d; }
            if self.n & 1023 == 1023 { for v in [&mut m.x, &mut m.d] { if v.abs() < 1e-270 { *v = 0.0; } } }
            m.f = 0.0; }
        self.n += 1; }
    pub fn channels(&self) -> usize { self.channels }
}
