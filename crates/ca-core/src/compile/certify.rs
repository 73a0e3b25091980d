//! Certify: what can be said of stability before anything moves, and which module to blame.
//!
//! Decides for the cheap bounds of numerics 1.3 (two sums per module, no matrix), which settle almost every scene; the
//! exact test by one sparse factorisation is for `analysis`. With h = T²k + 2Tz for each link and d_i their sum at mass
//! i: d_i/m_i ≥ 4 is certainly unstable and this module is the cause; the smaller of the Gershgorin and the link bound
//! below 4 is certainly stable. Contacts and other non-linear links are judged by rule (numerics 3.2) and said to be.

use super::net::{End, LiaNode, Net};
pub use crate::certificate::{Certificate, Level};
use crate::kind::Coefs;
use crate::kind::{Role, Unit};
use crate::law::Bound;
use crate::live::Loader;
use crate::model::diag::{Diag, Diags};
use crate::model::{Model, Span, quantity};
use alloc::format;
use alloc::vec::Vec;

#[derive(Clone, Copy)]
struct Row {
    /// T²k + 2Tz of all linear links at this mass
    own: f64,
    /// the same with links between masses counted twice
    disc: f64,
    /// T²/m
    c: f64,
    /// contacts
    touch: f64,
}

/// Judges the network; warnings name the module and what would mend it.
pub fn certify(model: &Model, net: &Net, diags: &mut Diags) -> Certificate {
    let mut rows: Vec<Row> = worst_rows(net);
    // what is left out does not move
    for (r, _) in rows.iter_mut().zip(&net.alive).filter(|(_, alive)| !**alive) {
        *r = Row { own: 0.0, disc: 0.0, c: 0.0, touch: 0.0 };
    }
    let bounds: Vec<Bound> = worst_bounds(net);
    let mut springs = Negative::default();
    for (l, b) in net.lias.iter().zip(&bounds) {
        let h = b.k + 2.0 * b.z;
        let sides = l.ends.map(|e| net.under(e));
        let moving = |ids: &[u32]| ids.iter().any(|m| rows[*m as usize].c > 0.0);
        let both = moving(&sides[0]) && moving(&sides[1]);
        for m in sides.iter().flatten() {
            let r = &mut rows[*m as usize];
            if b.linear {
                r.own += h;
                r.disc += if both { h + h.abs() } else { h };
            } else if !b.contact {
                r.own += b.k + 2.0 * b.z;
                r.disc += (b.k + 2.0 * b.z) * if both { 2.0 } else { 1.0 };
            } else {
                r.touch += h;
            }
        }
        if let [End::Mat(i), End::Mat(j)] = l.ends {
            springs.add(i, j, b.k);
        }
    }
    if overflow(model, net, &rows, &bounds, diags) {
        return Certificate::default();
    }
    let mut cert = Certificate::default();
    let mut pair: f64 = 0.0;
    for r in &rows {
        let g = r.disc * r.c;
        cert.bound = cert.bound.max(g);
        cert.lower = cert.lower.max(r.own * r.c);
    }
    for l in &net.lias {
        let d = |e: End| net.under(e).iter().map(|m| rows[*m as usize].own * rows[*m as usize].c).fold(0.0, f64::max);
        pair = pair.max(d(l.ends[0]) + d(l.ends[1]));
    }
    // a mass with a spring of its own is a link to the ground
    pair = rows.iter().map(|r| r.own * r.c).fold(pair, f64::max);
    let negative = bounds.iter().any(|b| b.k < 0.0);
    if !negative {
        cert.bound = cert.bound.min(pair);
    }
    let worst = (0..rows.len()).max_by(|a, b| (rows[*a].own * rows[*a].c).total_cmp(&(rows[*b].own * rows[*b].c)));
    cert.worst = worst.map(|i| net.mats[i].name.clone()).unwrap_or_default();

    let covered = !negative || springs.covered();
    let linear = bounds.iter().all(|b| b.linear);
    cert.level = if cert.lower >= 4.0 {
        Level::Unstable
    } else if cert.bound < 4.0 && covered {
        if linear { Level::Proven } else { Level::RuleOfThumb }
    } else {
        Level::NotProven
    };
    if let (Level::Unstable, Some(i)) = (cert.level, worst) {
        diags.push(unstable(model, net, &rows, &bounds, i));
    }
    if cert.level == Level::NotProven {
        let why = if covered {
            format!("the bounds allow up to {:.3}, the limit is 4", cert.bound)
        } else {
            "some spring is negative and not covered by those beside it".into()
        };
        let mut d = Diag::warning("W107", format!("stability is not proven by the cheap bounds: {why}"));
        if let Some(i) = worst {
            d = d.at(span(model, net, net.mats[i].item), "nearest to the limit");
        }
        let help = "it may well be stable; to be sure, lower the stiffness and viscosity at";
        diags.push(d.help(format!("{help} `{}`, make it heavier, or raise the sound rate", cert.worst)));
    }
    contacts(model, net, &rows, &bounds, &mut cert, diags);
    devices(model, net, &bounds, diags);
    cert
}

/// Numbers so large or so small that the coefficients are not numbers any more. Said for each item, and an error.
fn overflow(model: &Model, net: &Net, rows: &[Row], bounds: &[Bound], diags: &mut Diags) -> bool {
    let mats =
        net.mats.iter().zip(rows).filter(|(_, r)| !(r.c.is_finite() && (r.own * r.c).is_finite())).map(|(m, _)| m.item);
    let links = net.lias.iter().zip(bounds).filter(|(_, b)| !(b.k.is_finite() && b.z.is_finite())).map(|(l, _)| l.item);
    let items: alloc::collections::BTreeSet<u32> = mats.chain(links).collect();
    for item in &items {
        let name = &net.items[*item as usize].name;
        let d = Diag::error("E009", format!("the numbers of `{name}` are beyond computing"));
        diags.push(
            d.at(span(model, net, *item), "overflows").help("use a larger mass, or less stiffness and viscosity"),
        );
    }
    !items.is_empty()
}

/// A row for each MAT; generators make thousands with the same values, and each corner may solve for a pitch.
fn worst_rows(net: &Net) -> Vec<Row> {
    let mut last: Option<(&super::net::MatNode, Row)> = None;
    let mut rows = Vec::with_capacity(net.mats.len());
    for m in &net.mats {
        let same = last.as_ref().filter(|(o, _)| {
            o.item == m.item
                && o.code == m.code
                && (alloc::sync::Arc::ptr_eq(&o.values, &m.values) || o.values[..] == m.values[..])
        });
        let r = same.map_or_else(|| row(net, m), |s| s.1);
        rows.push(r);
        last = Some((m, r));
    }
    rows
}

fn row(net: &Net, m: &super::net::MatNode) -> Row {
    let super::net::MatRole::Mat(spec) = m.role else { return Row { own: 0.0, disc: 0.0, c: 0.0, touch: 0.0 } };
    let mut out = [0.0; 8];
    let mut corner = Coefs { p: 1.0, q: 0.0, c: 0.0 };
    // worst corner of what may change: lightest, stiffest, most damped
    for values in corners(net, m.item, &m.values) {
        Loader::Mat(spec, net.medium(m).friction).load(&values, net.te, &mut out);
        corner = Coefs { p: corner.p.min(out[0]), q: corner.q.min(out[1]), c: corner.c.max(out[2]) };
    }
    if corner.c == 0.0 || spec.fixed {
        return Row { own: 0.0, disc: 0.0, c: 0.0, touch: 0.0 };
    }
    let own = (-corner.q + 2.0 * (1.0 - corner.p)) / corner.c;
    Row { own, disc: own, c: corner.c, touch: 0.0 }
}

/// The parameter values of a module at load and, for each live parameter it follows, at both ends of its range.
fn corners(net: &Net, item: u32, values: &[crate::live::Source]) -> Vec<Vec<Option<f64>>> {
    let it = &net.items[item as usize];
    let mut all = alloc::vec![net.values(item, values)];
    for (arg, p, factor) in &it.follows {
        let param = &net.params[*p];
        for v in [param.min, param.max] {
            let mut args = it.args.clone();
            args[*arg] = crate::sketch::Arg::Num((v * factor).clamp(-1e30, 1e30));
            let slots = match it.kind.role {
                Role::Generator(g) => {
                    match (g.derive)(&crate::sketch::Args {
                        code: it.kind.code,
                        params: it.kind.params,
                        values: &args,
                        te: net.te,
                    }) {
                        Ok(s) => s,
                        // out of reach, so a change to it is refused
                        Err(_) => continue,
                    }
                }
                _ => args.iter().map(crate::sketch::Arg::num).collect(),
            };
            all.push(values.iter().map(|s| s.get(&slots)).collect());
        }
    }
    all
}

fn worst_bounds(net: &Net) -> Vec<Bound> {
    let mut last: Option<(u32, alloc::sync::Arc<[crate::live::Source]>, Bound)> = None;
    let mut bounds = Vec::with_capacity(net.lias.len());
    for l in &net.lias {
        if let Some((item, values, b)) = &last {
            if *item == l.item && values[..] == l.values[..] {
                bounds.push(*b);
                continue;
            }
        }
        let mut worst = Bound::default();
        for (i, values) in corners(net, l.item, &l.values).into_iter().enumerate() {
            let mut c = [0.0; 8];
            (l.law.load)(&values, net.te, &mut c[..l.law.coefs]);
            let b = (l.law.bound)(&c[..l.law.coefs], &net.tables);
            worst = if i == 0 { b } else { Bound { k: worst.k.max(b.k), z: worst.z.max(b.z), ..b } };
        }
        last = Some((l.item, l.values.clone(), worst));
        bounds.push(worst);
    }
    bounds
}

fn span(model: &Model, net: &Net, item: u32) -> Span {
    model.items[net.items[item as usize].model].name_span
}

fn unstable(model: &Model, net: &Net, rows: &[Row], bounds: &[Bound], i: usize) -> Diag {
    let m = &net.mats[i];
    let r = &rows[i];
    let at = r.own * r.c;
    let title = format!("`{}` is too stiff for its mass at this sound rate: {at:.3}, the limit is 4", m.name);
    let d = Diag::warning("W103", title).at(span(model, net, m.item), "this mass");
    // the link that weighs most is the one to change
    let mut most: Option<(&LiaNode, &Bound)> = None;
    for (l, b) in net.lias.iter().zip(bounds) {
        let touches = b.linear && l.ends.iter().any(|e| net.under(*e).contains(&(i as u32)));
        if touches && most.is_none_or(|(_, o)| b.k + 2.0 * b.z > o.k + 2.0 * o.z) {
            most = Some((l, b));
        }
    }
    let mass = net.te * net.te / r.c * at / 4.0;
    let heavier = format!("make `{}` heavier than {}", m.name, quantity::show(round_up(mass), Unit::KILOGRAM));
    let rate = format!("raise the sound rate above {:.0} Hz", net.rate * libm::sqrt(at / 4.0));
    match most {
        Some((l, b)) => {
            let h = b.k + 2.0 * b.z;
            let room = 4.0 / r.c - (r.own - h);
            let fix = if room > 0.0 && b.k >= 2.0 * b.z {
                let k = quantity::show(round_down(room - 2.0 * b.z), Unit::STIFFNESS);
                format!("keep `k` of `{}` below {k}", l.name)
            } else if room > 0.0 {
                let z = quantity::show(round_down((room - b.k) * 0.5 * net.te), Unit::VISCOSITY);
                format!("keep `z` of `{}` below {z}", l.name)
            } else {
                format!("soften `{}` and the other links of `{}`", l.name, m.name)
            };
            d.at(span(model, net, l.item), "its stiffest link").help(format!("{fix}, or {heavier}, or {rate}"))
        }
        None => d.help(format!("{heavier}, or {rate}")),
    }
}

/// Three digits, towards zero.
fn round_down(v: f64) -> f64 {
    three_digits(v, libm::floor)
}

/// Three digits, away from zero.
fn round_up(v: f64) -> f64 {
    three_digits(v, libm::ceil)
}

/// The power of ten goes through text, so that what is shown has three digits and no noise behind them.
fn three_digits(v: f64, to: fn(f64) -> f64) -> f64 {
    let ten = libm::floor(libm::log10(v.abs().max(1e-300))) - 2.0;
    let n = to(v / libm::pow(10.0, ten));
    format!("{n}e{ten}").parse().unwrap_or(v)
}

/// Rules for contacts (numerics 3.2): kT²/m ≤ 1 recommended, ≤ 2 at the most, with the other links at the masses.
fn contacts(model: &Model, net: &Net, rows: &[Row], bounds: &[Bound], cert: &mut Certificate, diags: &mut Diags) {
    let mut told = alloc::collections::BTreeSet::new();
    for (l, b) in net.lias.iter().zip(bounds) {
        if b.active && told.insert(l.item) {
            let d = Diag::warning("W110", format!("`{}` may feed energy in: its table does not only resist", l.name));
            diags.push(d.at(span(model, net, l.item), "active").help("a force of the sign of its speed only resists, and a spring that never falls only returns; if it is meant to drive, mind the level"));
        }
        if !b.contact || b.k == 0.0 {
            continue;
        }
        let c: f64 = l.ends.iter().map(|e| net.under(*e).iter().map(|m| rows[*m as usize].c).fold(0.0, f64::max)).sum();
        let a = b.k * c;
        if a > cert.contact {
            cert.contact = a;
            cert.stiffest.clone_from(&l.name);
        }
        if a > 1.0 && told.insert(l.item) {
            let safe = quantity::show(round_down(1.0 / c), Unit::STIFFNESS);
            let word = if a > 2.0 { "makes energy at every blow" } else { "may make energy at a blow" };
            let d = Diag::warning("W104", format!("contact `{}` {word}: kT²/m is {a:.3}, stay below 1", l.name));
            let (lo, hi) = (0.12 * a, 1.9 - a);
            let help = if hi > lo {
                let z = |b: f64| quantity::show(round_down(b / (c / net.te)), Unit::VISCOSITY);
                format!("use `k` up to {safe}, or add viscosity `z` between {} and {}", z(lo), z(hi))
            } else {
                format!("use `k` up to {safe}, heavier masses, or a higher sound rate")
            };
            diags.push(d.at(span(model, net, l.item), "stiff contact").help(help));
        }
    }
}

/// The delay of a device turns viscosity straight on a key into noise and instability (ICMC 2013, 7.1).
fn devices(model: &Model, net: &Net, bounds: &[Bound], diags: &mut Diags) {
    let is_key = |e: &End| matches!(e, End::Mat(m) if net.mats[*m as usize].code == "TGR");
    let mut told = alloc::collections::BTreeSet::new();
    for (l, b) in net.lias.iter().zip(bounds) {
        if b.z > 0.0 && l.ends.iter().any(is_key) && told.insert(l.item) {
            let d = Diag::warning("W105", format!("`{}` puts viscosity straight on a device key", l.name))
                .at(span(model, net, l.item), "noisy, and limited by the device's own friction")
                .help("tie the key to a MAS by a RES, and damp that MAS to ground instead");
            diags.push(d);
        }
    }
}

/// Negative springs (bending) and the positive ones that cover them: −B across a node is covered by 2B on either side,
/// since (a + b)² ≤ 2(a² + b²).
#[derive(Default)]
struct Negative {
    positive: alloc::collections::BTreeMap<(u32, u32), f64>,
    negative: Vec<(u32, u32, f64)>,
}

impl Negative {
    fn add(&mut self, i: u32, j: u32, k: f64) {
        if k < 0.0 {
            self.negative.push((i, j, -k));
        } else {
            *self.positive.entry((i.min(j), i.max(j))).or_default() += k;
        }
    }

    fn covered(mut self) -> bool {
        if self.negative.is_empty() {
            return true;
        }
        let mut around: alloc::collections::BTreeMap<u32, Vec<u32>> = alloc::collections::BTreeMap::new();
        for (i, j) in self.positive.keys() {
            around.entry(*i).or_default().push(*j);
            around.entry(*j).or_default().push(*i);
        }
        for (i, j, b) in &self.negative {
            let key = |a: u32, c: u32| (a.min(c), a.max(c));
            let need = 2.0 * b * (1.0 - 1e-12);
            let middle =
                around.get(i).into_iter().flatten().copied().find(|m| {
                    [key(*i, *m), key(*m, *j)].iter().all(|k| self.positive.get(k).is_some_and(|v| *v >= need))
                });
            let Some(m) = middle else { return false };
            for k in [key(*i, m), key(m, *j)] {
                if let Some(v) = self.positive.get_mut(&k) {
                    *v -= 2.0 * b;
                }
            }
        }
        true
    }
}
