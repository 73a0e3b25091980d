//! Converts typed lines to parts: gives each argument of a line its meaning.
//!
//! Only this module and [`super::links`] give numbers a meaning. A named parameter stays a name where its value is used
//! unchanged. If a law needs the product of two parameters, the product is written as a number, with a note: a model
//! file does not have expressions, and an extra parameter (`nlK_times_0_9`) would look like the author's.
//!
//! In MIMS positions are absolute and a link is slack at distance 0, so all parts rest at 0 and x0 is the displacement
//! at the start. Only a `posInput`, which stays at its x0 until it is moved, rests there. A mass starts with the
//! velocity x0 − xDelayed per sample, and the first two samples follow mi.lib (`start`).

use super::links;
use super::names::Losses;
use super::parse::{Line, Token, shown};
use super::part::{Arg, Net, Param, Part};
use super::reader::{Reader, number};
use super::start;
use super::types::{Type, What};
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use ca_model::Span;
use ca_model::diag::{Diag, Diags};
use ca_model::quantity::Plain;

/// Largest number. Beyond it, or below its inverse, a number leaves the range of a float on the way to SI units.
const HUGE: f64 = 1e290;

/// Converts all lines to parts, which are valid only if `diags` is free of errors.
pub(super) fn build<'a>(typed: &[(&Line<'a>, &'static Type)], diags: &mut Diags) -> Net {
    let mut r = Reader {
        net: Net::default(),
        losses: Losses::default(),
        diags,
        params: BTreeMap::new(),
        mats: BTreeMap::new(),
        other_labels: BTreeMap::new(),
    };
    let mut n_parts = 0;
    let mut seen: BTreeMap<&'a str, Span> = BTreeMap::new();
    for (line, ty) in typed {
        let is_part = !matches!(ty.what, What::Param | What::AudioParam);
        match (is_part, ty.ends) {
            (false, _) => r.param(line, ty),
            (true, 0) => {
                if let Some(first) = seen.insert(line.label.text, line.label.span) {
                    r.twice(line, first);
                }
                r.mats.insert(line.label.text, n_parts);
            }
            _ => _ = r.other_labels.insert(line.label.text, line.label.span),
        }
        n_parts += usize::from(is_part);
    }
    for (line, ty) in typed {
        if r.diags.is_full() {
            break;
        }
        if !matches!(ty.what, What::Param | What::AudioParam) {
            let part = r.part(line, ty);
            r.net.parts.push(part);
        }
    }
    let Reader { mut net, mut losses, diags, .. } = r;
    links::rest_lengths(&mut net.parts);
    start::notes(&net, &mut losses);
    name_groups(&mut net);
    losses.into_diags(diags);
    net
}

/// Names the groups `g1`, `g2` …, after all labels have their names, and puts them before the names of their members.
fn name_groups(net: &mut Net) {
    for (i, (name, _)) in net.groups.iter_mut().enumerate() {
        *name = net.names.unique(&format!("g{}", i + 1));
    }
    for part in &mut net.parts {
        if let Some((group, _)) = part.group.and_then(|g| net.groups.get(g)) {
            part.name = format!("{group}.{}", part.name);
        }
    }
}

impl<'a> Reader<'a, '_> {
    fn param(&mut self, line: &Line<'a>, ty: &Type) {
        let Some(token) = line.args.first() else { return };
        let label = line.label;
        if ty.what == What::AudioParam && token.text.starts_with('@') {
            self.diags.push(
                Diag::error(
                    "E028",
                    format!("a parameter driven by a signal is not supported: `{}`", shown(label.text)),
                )
                .at(token.span, "the signal")
                .help("give it an initial value instead, as in `audioParam 0.1`"),
            );
            return;
        }
        let Some(value) = number(token.text) else {
            self.diags.push(
                Diag::error("E007", format!("not a number: `{}`, of `{}`", shown(token.text), shown(label.text)))
                    .at(token.span, "expected a number")
                    .help("a parameter is one number; expressions are not supported"),
            );
            return;
        };
        if ty.what == What::AudioParam {
            self.losses.add(
                &format!("audio {}", label.text),
                Diag::note("N201", format!("`{}` keeps its initial value: {value}", shown(label.text)))
                    .at(line.ty.span, "a signal cannot move a parameter")
                    .help("write `live = true` on it to move it by hand or by a gesture"),
            );
        }
        let index = self.net.params.len();
        let name = self.name(label);
        self.net.params.push(Param { name, span: label.span, value, folded: None });
        if let Some(first) = self.params.insert(label.text, index) {
            self.twice(line, self.net.params[first].span);
        }
    }

    fn part(&mut self, line: &Line<'a>, ty: &'static Type) -> Part {
        let name = self.name(line.label);
        let ends: Vec<usize> = line.args.iter().take(ty.ends).filter_map(|t| self.mat(t)).collect();
        if let [a, b] = ends[..]
            && a == b
        {
            self.diags.push(
                Diag::error("E022", format!("a link needs two different ends: `{}`", shown(line.label.text)))
                    .at(line.args[1].span, "the same module again"),
            );
        }
        let numbers = line.args.iter().skip(ty.ends).take(ty.numbers.len());
        let read: Vec<Option<Arg>> = numbers.map(|t| self.arg(t)).collect();
        for ((name, arg), token) in ty.numbers.iter().zip(&read).zip(line.args.iter().skip(ty.ends)) {
            if let Some(arg) = *arg {
                self.in_range(line, ty, name, arg, token);
            }
        }
        let nums: Vec<Arg> = read.into_iter().map(|arg| arg.unwrap_or(Arg::Num(0.0))).collect();
        if line.args.len() > ty.ends + ty.numbers.len() {
            let first = &line.args[ty.ends + ty.numbers.len()];
            let what = Diag::note("N201", "the drawing position of a module is not imported")
                .at(first.span, "buffer, x and y");
            self.losses.add("drawn", what);
        }
        let (span, rest) = (line.label.span, Arg::Num(0.0));
        let mut part = Part { name, span, kind: "SOL", args: Vec::new(), ends, group: None, rest };
        self.give_meaning(line, ty, &nums, &mut part);
        part
    }

    /// Refuses a number that is out of range for every kind, at its place.
    fn in_range(&mut self, line: &Line<'a>, ty: &Type, name: &str, arg: Arg, token: &Token<'a>) {
        let x = self.net.value(arg);
        let wanted = match name {
            "M" | "scale" if x <= 0.0 => "above 0",
            // a pluck may pull
            "K" if ty.what == What::NlPluck && x.abs() <= HUGE => return,
            "K" | "Q" | "Z" if x < 0.0 => "0 or more",
            "M" if x < 1.0 / HUGE => "1e-290 or more",
            _ if x.abs() > HUGE => "at most 1e290 in magnitude",
            _ => return,
        };
        let title = format!("`{name}` of `{}` is out of range: {}", shown(line.label.text), Plain(x));
        let mut d = Diag::error("E009", title).at(token.span, format!("must be {wanted}"));
        if let Arg::Param(i) = arg {
            d = d.at(self.net.params[i].span, "from here");
        }
        self.diags.push(d);
    }

    fn give_meaning(&mut self, line: &Line<'a>, ty: &Type, nums: &[Arg], part: &mut Part) {
        match (ty.what, nums) {
            (What::Ground, &[x]) => part.place(x),
            (What::PosInput, &[x]) => {
                part.kind = "ENX";
                part.rest = x;
                if x != Arg::Num(0.0) {
                    let d =
                        Diag::note("N201", format!("`{}` stays at its start position until it is moved", part.name));
                    let d = d.at(line.args[0].span, "mi.lib adds this to the first sample only");
                    self.losses.add(&format!("start {}", part.name), d);
                }
            }
            (What::Mass, &[m, x, x1]) => {
                part.kind = "MAS";
                part.args.push(("m", m));
                self.start(line, ty, part, x, x1);
            }
            (What::MassG, &[m, g, x, x1]) => {
                part.kind = "MAS";
                part.args.push(("m", m));
                self.start(line, ty, part, x, x1);
                self.fall(line, part, m, g);
            }
            (What::Osc, &[m, k, z, x, x1]) => {
                part.kind = "CEL";
                part.args.extend([("m", m), ("k", k), ("z", z)]);
                self.start(line, ty, part, x, x1);
            }
            (What::FrcInput, _) => part.kind = "ENF",
            (What::PosOutput, _) => part.kind = "SOX",
            (What::FrcOutput, _) => part.kind = "SOF",
            _ => links::give_meaning(self, line, ty.what, nums, part),
        }
        if !matches!(part.rest, Arg::Num(x) if x == 0.0) {
            part.args.push(("x", part.rest));
        }
    }

    fn start(&mut self, line: &Line<'a>, ty: &Type, part: &mut Part, x: Arg, x1: Arg) {
        part.place(x);
        let same = x == x1;
        let v = if same { 0.0 } else { self.fold(x, &part.name) - self.fold(x1, &part.name) };
        if v != 0.0 {
            part.args.push(("v", Arg::Num(v)));
        }
        let at = self.net.value(x);
        let (key, title) = if v != 0.0 {
            ("velocity", format!("`{}` starts with the velocity {v} per sample", part.name))
        } else if at != 0.0 {
            ("at rest", format!("`{}` starts at rest, at {at}", part.name))
        } else {
            return;
        };
        // the younger dialect lacks `massG`
        let unclear = ty.younger.is_some();
        if let Some(last) = line.args.get(ty.numbers.len() - 1).filter(|_| unclear || v != 0.0) {
            let d = Diag::note("N201", title).at(last.span, "read as the position one sample before");
            let help = "MIMS4Max writes a velocity per second here; this line does not show which of the two it is";
            self.losses.add(key, if unclear { d.help(help) } else { d });
        }
    }

    fn fall(&mut self, line: &Line<'a>, part: &mut Part, m: Arg, g: Arg) {
        let (mass, force) = (self.fold(m, &part.name), self.fold(g, &part.name));
        // an invalid mass has been reported
        if force == 0.0 || mass <= 0.0 {
            return;
        }
        let a = force / mass;
        if a.abs() > HUGE {
            let d = Diag::error(
                "E009",
                format!("the acceleration of `{}` is out of range: {}/{}", part.name, Plain(force), Plain(mass)),
            );
            self.diags.push(d.at(line.args[0].span, "the mass"));
            return;
        }
        let known = self.net.groups.iter().position(|(_, other)| *other == a);
        part.group = known.or(Some(self.net.groups.len()));
        if known.is_none() {
            self.net.groups.push((String::new(), a));
        }
    }
}
