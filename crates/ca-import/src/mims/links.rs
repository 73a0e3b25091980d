//! Converts the links of MIMS, by the laws of mi.lib.
//!
//! | MIMS | law, d = x_b − x_a, v its change per sample | here |
//! |---|---|---|
//! | `spring K`, `springDamper K Z`, `damper Z` | K d + Z v | RES, REF, FRO |
//! | `nlSpring2 K Q Z`, `nlSpring3 K Q Z` | K d + Q sgn(d)\|d\|^p + Z v, p = 2, 3 | POW, CUB |
//! | `contact K Z t` | K (d − t) + Z v while d < t | BUT |
//! | `nlPluck K s` | slope K/10 − K up to s/10, then rising to 0 at s: it pushes away | LNL |
//! | `nlBow Z s` | slope Z − Z/3 up to s/3, then falling to 0 at s | BOW |
//!
//! The two curves are written with the parameters of LNL (four points) and BOW (f, v0, v1), which give the same
//! polygon: K s/10 − (K/10) s and Z s/3 − (Z/3) s are 0. Another law in the catalog would be the same force twice.

use super::parse::Line;
use super::part::{Arg, Part};
use super::reader::Reader;
use super::types::What;
use alloc::format;
use alloc::vec::Vec;
use ca_model::diag::Diag;

pub(super) fn give_meaning(r: &mut Reader<'_, '_>, line: &Line<'_>, what: What, nums: &[Arg], part: &mut Part) {
    match (what, nums) {
        (What::Spring, &[k]) => {
            part.kind = "RES";
            part.args.push(("k", k));
        }
        (What::Spring, &[k, z]) => {
            part.kind = "REF";
            part.args.extend([("k", k), ("z", z)]);
        }
        (What::Damper, &[z]) => {
            part.kind = "FRO";
            part.args.push(("z", z));
        }
        (What::NlSpring | What::NlSpring2, &[k, q, z]) => {
            part.kind = "POW";
            part.args.extend([("k", k), ("q", q), ("p", Arg::Num(2.0)), ("z", z)]);
            if what == What::NlSpring {
                let d = Diag::note("N201", "`nlSpring` is read as quadratic, like `nlSpring2`")
                    .at(line.ty.span, "one of its generators makes it cubic")
                    .help("write `nlSpring3` if the model was made with that one");
                r.losses.add("nlSpring", d);
            }
        }
        (What::NlSpring3, &[k, k3, z]) => {
            part.kind = "CUB";
            part.args.extend([("k", k), ("k3", k3), ("z", z)]);
        }
        (What::Contact | What::Detent, &[k, z, d]) => {
            part.kind = "BUT";
            part.args.extend([("k", k), ("z", z), ("d", d)]);
            if what == What::Detent && d != Arg::Num(0.0) {
                let note = Diag::note("N201", "`detent` is read as `contact`, its name since 2020")
                    .at(line.ty.span, "the force began with a step then")
                    .help("its force is now 0 at the threshold");
                r.losses.add("detent", note);
            }
        }
        (What::NlPluck, &[k, scale]) => {
            part.kind = "LNL";
            let (k, reach) = (r.fold(k, &part.name), r.fold(scale, &part.name));
            let (tip, most) = (reach / 10.0, 0.9 * k * reach / 10.0);
            product(r, line, part, most);
            part.args.push(("spring", Arg::Curve([[-reach, 0.0], [-tip, most], [tip, -most], [reach, 0.0]])));
        }
        (What::NlBow, &[z, scale]) => {
            part.kind = "BOW";
            let (z, v1) = (r.fold(z, &part.name), r.fold(scale, &part.name));
            let f = 2.0 * z * v1 / 9.0;
            product(r, line, part, f);
            part.args.push(("curve", Arg::Word("piecewise")));
            for (key, x) in [("f", f), ("v0", v1 / 3.0), ("v1", v1), ("fd", 0.0)] {
                part.args.push((key, Arg::Num(x)));
            }
        }
        _ => {}
    }
}

/// Refuses a force that is not finite.
fn product(r: &mut Reader<'_, '_>, line: &Line<'_>, part: &Part, f: f64) {
    if !f.is_finite() {
        let d = Diag::error("E009", format!("the force of `{}` is out of range: {f}", part.name));
        r.diags.push(d.at(line.label.span, "this link"));
    }
}

/// Writes the rest length, which is 0 for every link of MIMS, where the default (the distance at rest) differs. Laws
/// without a rest length (contacts, plucks) measure from 0 as in MIMS.
pub(super) fn rest_lengths(parts: &mut [Part]) {
    let catalog = ca_model::catalog();
    let rests: Vec<Arg> = parts.iter().map(|p| p.rest).collect();
    for part in parts {
        let elastic = part.kind != "FRO" && catalog.get(part.kind).is_some_and(|k| k.param("l0").is_some());
        if let [a, b] = part.ends[..]
            && elastic
            && rests.get(a) != rests.get(b)
        {
            part.args.push(("l0", Arg::Num(0.0)));
        }
    }
}
