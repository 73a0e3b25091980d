//! Typed lines → parts: every module with its kind, its arguments and what it holds on to, by index.
//!
//! Decides that the meaning of a number is given once, here and in [`super::links`], and that a named parameter stays
//! a name wherever its value is used as it is. Where a law needs a product of two of them, the product is
//! written as a number and said so: a model file has no expressions, and a hidden second parameter
//! (`nlK_times_0_9`) would look like the author's.
//! A mass starts with velocity x0 − xDelayed per sample; an `osc` is drawn to 0, not to its x0, so x0 is a
//! displacement there and a rest position everywhere else.

use super::links;
use super::names::Losses;
use super::parse::{Line, shown};
use super::part::{Arg, Net, Param, Part};
use super::reader::{Reader, number};
use super::types::{Type, What};
use crate::model::Span;
use crate::model::diag::{Diag, Diags};
use crate::model::quantity::Plain;
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;

/// Gives every line its meaning. Parts are only to be used where `diags` has no error.
pub(super) fn build<'a>(typed: &[(&Line<'a>, &'static Type)], diags: &mut Diags) -> Net {
    let mut r = Reader {
        net: Net::default(),
        losses: Losses::default(),
        diags,
        params: BTreeMap::new(),
        mats: BTreeMap::new(),
        others: BTreeMap::new(),
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
            _ => _ = r.others.insert(line.label.text, line.label.span),
        }
        n_parts += usize::from(is_part);
    }
    for (line, ty) in typed {
        if !matches!(ty.what, What::Param | What::AudioParam) {
            let part = r.part(line, ty);
            r.net.parts.push(part);
        }
    }
    let Reader { mut net, losses, diags, .. } = r;
    links::rest_lengths(&mut net.parts);
    name_groups(&mut net);
    losses.into_diags(diags);
    net
}

/// Names the groups `g1`, `g2` …, after all labels have theirs, and puts the name before those of their members.
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
                Diag::error("E028", format!("a parameter driven by a signal is not read: `{}`", shown(label.text)))
                    .at(token.span, "the signal")
                    .help("give it an initial value instead, as in `audioParam 0.1`"),
            );
            return;
        }
        let Some(value) = number(token.text) else {
            self.diags.push(
                Diag::error("E007", format!("not a number: `{}`, of `{}`", shown(token.text), shown(label.text)))
                    .at(token.span, "expected a number")
                    .help("a parameter is one number; expressions are not read"),
            );
            return;
        };
        if ty.what == What::AudioParam {
            self.losses.add(
                &format!("audio {}", label.text),
                Diag::note("N201", format!("`{}` keeps its initial value: {value}", shown(label.text)))
                    .at(line.ty.span, "no signal moves a parameter")
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
        let room = line.args.iter().skip(ty.ends).take(ty.numbers.len());
        let nums: Vec<Arg> = room.map(|t| self.arg(t).unwrap_or(Arg::Num(0.0))).collect();
        if line.args.len() > ty.ends + ty.numbers.len() {
            let first = &line.args[ty.ends + ty.numbers.len()];
            let what = Diag::note("N201", "where a module is drawn is not kept").at(first.span, "buffer, x and y");
            self.losses.add("drawn", what);
        }
        let mut part = Part { name, kind: "SOL", args: Vec::new(), ends, group: None, rest: Arg::Num(0.0) };
        self.give_meaning(line, ty, &nums, &mut part);
        part
    }

    fn give_meaning(&mut self, line: &Line<'a>, ty: &Type, nums: &[Arg], part: &mut Part) {
        match (ty.what, nums) {
            (What::Ground, &[x]) => part.rest = x,
            (What::PosInput, &[x]) => {
                part.kind = "ENX";
                part.rest = x;
                if x != Arg::Num(0.0) {
                    let d = Diag::note("N201", format!("`{}` stays where it starts until it is moved", part.name));
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
                part.rest = Arg::Num(0.0);
                if x != Arg::Num(0.0) {
                    part.args.insert(3, ("dx0", x));
                }
            }
            (What::FrcInput, _) => part.kind = "ENF",
            (What::PosOutput, _) => part.kind = "SOX",
            (What::FrcOutput, _) => part.kind = "SOF",
            _ => links::give_meaning(self, line, ty.what, nums, part),
        }
        if !matches!(part.rest, Arg::Num(x) if x == 0.0) {
            let at = part.args.iter().take_while(|(k, _)| *k != "v").count();
            part.args.insert(at, ("x", part.rest));
        }
    }

    /// Rest position and initial velocity.
    fn start(&mut self, line: &Line<'a>, ty: &Type, part: &mut Part, x: Arg, x1: Arg) {
        part.rest = x;
        if x == x1 {
            return;
        }
        let v = self.fold(x, &part.name) - self.fold(x1, &part.name);
        if v == 0.0 {
            return;
        }
        part.args.push(("v", Arg::Num(v)));
        if let Some(last) = line.args.get(ty.numbers.len() - 1) {
            let d = Diag::note("N201", format!("`{}` starts at a velocity: {v} per sample", part.name))
                .at(last.span, "read as the position one sample before")
                .help("MIMS4Max writes a velocity per second here; this line does not tell which it is");
            self.losses.add("velocity", d);
        }
    }

    fn fall(&mut self, line: &Line<'a>, part: &mut Part, m: Arg, g: Arg) {
        let (mass, force) = (self.fold(m, &part.name), self.fold(g, &part.name));
        if force == 0.0 {
            return;
        }
        let a = force / mass;
        if !a.is_finite() {
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
