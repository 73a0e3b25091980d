//! Writes a network as a model, as the table that the peers read, and as a Faust program, with the same numbers to the
//! last bit.

use super::net::{Kind, Law, Net};
use std::fmt::Write as _;

/// Group of the modules in space.
const GROUP: &str = "air";

/// Returns a model for `ca`, one line a module.
pub fn model(net: &Net) -> String {
    let mut t = String::from("[model]\nunits = \"alg\"\n");
    let group = if net.space { format!("{GROUP}.") } else { String::new() };
    if net.space {
        let _ = writeln!(t, "[{GROUP}]\ndim = 3");
    }
    let of = |code: &'static str| net.mats.iter().enumerate().filter(move |(_, m)| kind(m.kind) == code);
    for code in ["SOL", "MAS", "CEL"] {
        if of(code).next().is_some() {
            let _ = writeln!(t, "[{group}{code}]");
        }
        for (i, m) in of(code) {
            let own = match m.kind {
                Kind::Sol => String::new(),
                Kind::Mas => format!("m = {:?}, ", m.m),
                Kind::Cel { k, z } => format!("m = {:?}, k = {k:?}, z = {z:?}, ", m.m),
            };
            // in space, `x` is also the rest position
            let place = match (net.space, m.kind) {
                (true, Kind::Sol) => format!("x = {:?}", m.x),
                (true, _) => format!("x = {:?}, v = {:?}", m.x, m.v),
                (false, Kind::Sol) => String::new(),
                (false, _) => format!("dx0 = {:?}, v = {:?}", m.x[0], m.v[0]),
            };
            let _ = writeln!(t, "m{i} = {{ {own}{place} }}");
        }
    }
    let grains = net.pairs.as_deref().unwrap_or_default();
    let single = net.lias.len() - grains.len() * grains.len().saturating_sub(1) / 2;
    for code in ["REF", "BUT", "HRZ", "BOW"] {
        let of = net.lias[..single].iter().enumerate().filter(|(_, l)| law(l.law) == code);
        let pairs = net.lias.get(single).filter(|l| law(l.law) == code);
        let mut lines = String::new();
        for (i, l) in of {
            let (a, b) = (l.a, l.b);
            let _ = writeln!(
                lines,
                "l{i} = {{ between = [\"{group}m{a}\", \"{group}m{b}\"], {} }}",
                parameters(l.law, net.space)
            );
        }
        if let Some(l) = pairs {
            let all: Vec<_> = grains.iter().map(|i| format!("\"{group}m{i}\"")).collect();
            let all = all.join(", ");
            let _ = writeln!(lines, "pairs = {{ between = [[{all}], [{all}]], {} }}", parameters(l.law, true));
        }
        if !lines.is_empty() {
            let _ = write!(t, "[{code}]\n{lines}");
        }
    }
    t += "[SOX]\n";
    let along = if net.space { ", along = \"z\"" } else { "" };
    for (n, i) in net.outputs.iter().enumerate() {
        let _ = writeln!(t, "o{n} = {{ from = \"{group}m{i}\", channel = 0{along} }}");
    }
    t
}

fn kind(kind: Kind) -> &'static str {
    match kind {
        Kind::Mas => "MAS",
        Kind::Cel { .. } => "CEL",
        Kind::Sol => "SOL",
    }
}

fn law(law: Law) -> &'static str {
    match law {
        Law::Ref(..) => "REF",
        Law::But(..) | Law::Inside(..) => "BUT",
        Law::Hrz(..) => "HRZ",
        Law::Bow(..) => "BOW",
    }
}

fn parameters(law: Law, space: bool) -> String {
    match law {
        Law::Ref(k, z, l0) if space => format!("k = {k:?}, z = {z:?}, l0 = {l0:?}"),
        Law::Ref(k, z, _) => format!("k = {k:?}, z = {z:?}"),
        Law::But(k, z, d) => format!("k = {k:?}, z = {z:?}, d = {d:?}"),
        Law::Inside(k, z, d) => format!("k = {k:?}, z = {z:?}, d = {d:?}, sense = \"inside\""),
        Law::Hrz(k, d) => format!("k = {k:?}, p = 1.5, d = {d:?}"),
        Law::Bow(f, v0) => format!("curve = \"smooth\", f = {f:?}, v0 = {v0:?}"),
    }
}

/// Returns the table for `benches/peers/table.h`.
pub fn table(net: &Net) -> String {
    let axes = if net.space { 3 } else { 1 };
    let mut t = format!("{axes} {} {} {}\n", net.mats.len(), net.lias.len(), net.outputs.len());
    for m in &net.mats {
        let (code, k, z) = match m.kind {
            Kind::Mas => (0, 0.0, 0.0),
            Kind::Cel { k, z } => (1, k, z),
            Kind::Sol => (2, 0.0, 0.0),
        };
        let _ = write!(t, "{code} {:?} {k:?} {z:?}", m.m);
        for e in 0..axes {
            let _ = write!(t, " {:?} {:?}", m.x[e], m.v[e]);
        }
        t += "\n";
    }
    for l in &net.lias {
        let (code, p) = match l.law {
            Law::Ref(k, z, l0) => (0, [k, z, l0]),
            Law::But(k, z, d) => (1, [k, z, d]),
            Law::Hrz(k, d) => (2, [k, 0.0, d]),
            Law::Bow(f, v0) => (3, [f, v0, 0.0]),
            Law::Inside(k, z, d) => (4, [k, z, d]),
        };
        let _ = writeln!(t, "{code} {} {} {:?} {:?} {:?}", l.a, l.b, p[0], p[1], p[2]);
    }
    for i in &net.outputs {
        let _ = writeln!(t, "{i}");
    }
    t
}

/// Returns a Faust program with modules from mi.lib; `None` in space, which that library lacks. The Hertz contact is
/// written out, since the library has none.
///
/// A module takes its positions one and two samples before the first; no link acts in the step to the first sample. A
/// link takes the positions before the first sample with inverted sign, because the library adds them where it should
/// subtract them (`tests/suite/outside/peers.rs`).
pub fn faust(net: &Net) -> Option<String> {
    if net.space {
        return None;
    }
    let (nm, nl, heard) = (net.mats.len(), net.lias.len(), net.outputs.len());
    let modules: Vec<_> = net.mats.iter().map(module).collect();
    let modules = modules.join(",\n    ");
    let mut t = String::from("mi = library(\"mi.lib\");\n");
    if nl == 0 {
        let _ = writeln!(t, "process = par(i, {nm}, 0) : (\n    {modules}) :> _;");
        return Some(t);
    }
    let links: Vec<_> = net.lias.iter().map(|l| link(net, l)).collect();
    let (ends, links) = (2 * nl, links.join(",\n    "));
    let route = |pairs: Vec<String>, ins: usize, outs: usize| format!("route({ins}, {outs}, {})", pairs.join(", "));
    let ends_of = |(i, l): (usize, &super::net::Lia)| [(l.a + 1, 2 * i + 1), (l.b + 1, 2 * i + 2)].map(|(m, e)| (m, e));
    let pairs: Vec<_> = net.lias.iter().enumerate().flat_map(ends_of).collect();
    let mut there: Vec<_> = pairs.iter().map(|(m, e)| format!("{m}, {e}")).collect();
    there.extend(net.outputs.iter().enumerate().map(|(n, i)| format!("{}, {}", i + 1, ends + n + 1)));
    let mut back: Vec<_> = pairs.iter().map(|(m, e)| format!("{e}, {m}")).collect();
    back.extend((1..=heard).map(|n| format!("{}, {}", ends + n, nm + n)));
    let _ = write!(
        t,
        "hertz(k, d, a, b) = k * n * sqrt(n) <: *(-1), _ with {{ n = max(0.0, d - (b - a)); }};\n\
         modules = {modules};\nlinks = {links};\nto_links = {};\nto_modules = {};\n\
         process = (modules : to_links : (links, par(i, {heard}, _)) : to_modules) ~ par(i, {nm}, _)\n    \
         : par(i, {nm}, !), par(i, {heard}, _) :> _;\n",
        route(there, nm, ends + heard),
        route(back, ends + heard, nm + heard),
    );
    Some(t)
}

fn module(m: &super::net::Mat) -> String {
    let now = m.x[0] - m.v[0];
    let (k, z) = if let Kind::Cel { k, z } = m.kind { (k, z) } else { (0.0, 0.0) };
    // the module alone gives the first sample from these two
    let before = (m.x[0] - (2.0 - (k + z) / m.m) * now) / (z / m.m - 1.0);
    match m.kind {
        Kind::Mas => format!("mi.mass({:?}, 0, {now:?}, {before:?})", m.m),
        Kind::Cel { k, z } => format!("mi.oscil({:?}, {k:?}, {z:?}, 0, {now:?}, {before:?})", m.m),
        Kind::Sol => format!("mi.ground({now:?})"),
    }
}

fn link(net: &Net, l: &super::net::Lia) -> String {
    let [a, b] = [l.a, l.b].map(|i| net.mats[i].v[0] - net.mats[i].x[0]);
    match l.law {
        Law::Ref(k, z, _) => format!("mi.springDamper({k:?}, {z:?}, {a:?}, {b:?})"),
        Law::But(k, z, d) | Law::Inside(k, z, d) => format!("mi.collision({k:?}, {z:?}, {d:?}, {a:?}, {b:?})"),
        Law::Hrz(k, d) => format!("hertz({k:?}, {d:?})"),
        // the curve of the library is 0.63 z v exp(1/2 - 4 (v/scale)²)
        Law::Bow(f, v0) => format!("mi.nlBow({:?}, {:?}, 1, {a:?}, {b:?})", f / (0.63 * v0), 8_f64.sqrt() * v0),
    }
}
