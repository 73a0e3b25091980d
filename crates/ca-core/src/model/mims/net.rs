//! Typed lines → parts: every module with its kind, its arguments and what it holds on to, by index.
//!
//! Decides that the meaning of a number is given once, here and in [`super::links`], and that a named parameter stays
//! a name wherever its value is used as it is. Where a law needs a product of two of them, the product is
//! written as a number and said so: a model file has no expressions, and a hidden second parameter
//! (`nlK_times_0_9`) would look like the author's.
//! A mass starts with velocity x0 − xDelayed per sample; an `osc` is drawn to 0, not to its x0, so x0 is a
//! displacement there and a rest position everywhere else.

use super::links;
use super::names::{Losses, Names, legal};
use super::parse::{Line, Token, shown};
use super::types::{Type, What, nearest};
use crate::model::Span;
use crate::model::diag::{Diag, Diags};
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;

/// An argument of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Arg {
    Num(f64),
    /// index into [`Net::params`]
    Param(usize),
    Word(&'static str),
}

impl Arg {
    /// The same argument as an ordered key; numbers by their bits.
    pub fn key(self) -> (u8, u64) {
        match self {
            Arg::Num(x) => (0, x.to_bits()),
            Arg::Param(i) => (1, i as u64),
            Arg::Word(w) => (2, w.len() as u64),
        }
    }
}

/// A named parameter.
#[derive(Clone, Debug)]
pub(super) struct Param {
    pub name: String,
    pub span: Span,
    pub value: f64,
    /// the first part that took its value as a number
    pub folded: Option<String>,
}

/// A module.
#[derive(Clone, Debug)]
pub(super) struct Part {
    pub name: String,
    pub kind: &'static str,
    pub args: Vec<(&'static str, Arg)>,
    /// the parts it holds on to: none, one (port) or two (link)
    pub ends: Vec<usize>,
    /// index into [`Net::groups`]
    pub group: Option<usize>,
    /// rest position of a material element
    pub rest: Arg,
}

/// A model before it is written.
#[derive(Clone, Debug, Default)]
pub(super) struct Net {
    pub params: Vec<Param>,
    /// in document order
    pub parts: Vec<Part>,
    /// name and acceleration [m per sample²] of each group
    pub groups: Vec<(String, f64)>,
    pub names: Names,
}

/// What the lines are read with.
pub(super) struct Reader<'a, 'd> {
    pub net: Net,
    pub losses: Losses,
    pub diags: &'d mut Diags,
    params: BTreeMap<&'a str, usize>,
    /// label of a material element → its part
    mats: BTreeMap<&'a str, usize>,
    /// labels of anything else
    others: BTreeMap<&'a str, Span>,
}

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
            let d = Diag::error("E009", format!("the acceleration of `{}` is out of range: {force}/{mass}", part.name));
            self.diags.push(d.at(line.args[0].span, "the mass"));
            return;
        }
        let known = self.net.groups.iter().position(|(_, other)| *other == a);
        part.group = known.or(Some(self.net.groups.len()));
        if known.is_none() {
            self.net.groups.push((String::new(), a));
        }
    }

    /// The number behind an argument, where its name cannot be kept.
    pub fn fold(&mut self, arg: Arg, by: &str) -> f64 {
        match arg {
            Arg::Num(x) => x,
            Arg::Param(i) => {
                let p = &mut self.net.params[i];
                p.folded.get_or_insert_with(|| by.to_string());
                p.value
            }
            Arg::Word(_) => 0.0,
        }
    }

    /// A name of its own for `label`, saying where it had to be changed.
    fn name(&mut self, label: Token<'a>) -> String {
        let wanted = legal(label.text);
        if wanted.is_empty() {
            let d = Diag::error("E014", "not a name: `@` alone");
            self.diags.push(d.at(label.span, "expected a label"));
        }
        let name = self.net.names.unique(&wanted);
        if name != wanted {
            let d = Diag::note("N201", format!("`{}` is used twice; this one is now `{name}`", shown(label.text)));
            self.losses.add(&name, d.at(label.span, "renamed"));
        } else if wanted != label.text {
            let d = Diag::note("N201", format!("`{}` is not a name here; it is now `{name}`", shown(label.text)));
            self.losses.add("renamed", d.at(label.span, "letters, digits and `_`"));
        }
        name
    }

    fn twice(&mut self, line: &Line<'a>, first: Span) {
        let d = Diag::error("E012", format!("name used twice: `{}`", shown(line.label.text)))
            .at(line.label.span, "again here")
            .at(first, "first here")
            .help("references to it would not say which one; rename one of them");
        self.diags.push(d);
    }

    fn mat(&mut self, token: &Token<'a>) -> Option<usize> {
        let Some(label) = token.text.strip_prefix('@') else {
            let d = Diag::error("E006", format!("expected a module: `{}`", shown(token.text)));
            self.diags.push(d.at(token.span, "a module is written `@label`"));
            return None;
        };
        if let Some(&part) = self.mats.get(label) {
            return Some(part);
        }
        let found = shown(label);
        let d = if self.others.contains_key(label) || self.params.contains_key(label) {
            Diag::error("E017", format!("not a material element: `{found}`"))
                .at(token.span, "expected a mass or ground")
        } else {
            let d = Diag::error("E013", format!("unknown name: `{found}`")).at(token.span, "no line defines it");
            match nearest(label, self.mats.keys().copied().take(1000)) {
                Some(name) => d.help(format!("did you mean `@{name}`?")).fix(token.span, format!("@{name}")),
                None => d,
            }
        };
        self.diags.push(d);
        None
    }

    fn arg(&mut self, token: &Token<'a>) -> Option<Arg> {
        if let Some(x) = number(token.text) {
            return Some(Arg::Num(x));
        }
        if let Some(&i) = self.params.get(token.text) {
            return Some(Arg::Param(i));
        }
        let found = shown(token.text);
        let d = if token.text.starts_with('@') {
            Diag::error("E006", format!("expected a number: `{found}`")).at(token.span, "a module")
        } else if token.text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) {
            Diag::error("E007", format!("not a number: `{found}`")).at(token.span, "expected a number")
        } else {
            let d =
                Diag::error("E013", format!("unknown parameter: `{found}`")).at(token.span, "no `param` of this name");
            match nearest(token.text, self.params.keys().copied().take(1000)) {
                Some(name) => d.help(format!("did you mean `{name}`?")).fix(token.span, name),
                None => d,
            }
        };
        self.diags.push(d);
        None
    }
}

/// A finite number as MIMS writes them (`0.`, `.5`, `1e-3`); words like `inf` are names.
fn number(text: &str) -> Option<f64> {
    text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c))
        .then(|| text.parse::<f64>().ok())
        .flatten()
        .filter(|x| x.is_finite())
}
