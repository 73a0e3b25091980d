//! Wire: what is written between quotes becomes ends of links, ears of outputs and moving points.

use super::Options;
use super::net::{Coordinate, Ear, End, LiaNode, Net, OutNode, PointNode};
use crate::io::PortRole;
use crate::kind::Role;
use crate::live::Source;
use crate::model::diag::{Diag, Diags};
use crate::model::select::{self, Coord, Index, Part, Selector};
use crate::model::suggest::nearest;
use crate::model::{Entry, Item, Model, Span, Value};
use alloc::collections::BTreeMap;
use alloc::format;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;

/// What a selector means.
enum Meaning {
    Ends(Vec<End>),
    Links(Vec<u32>),
}

struct Wire<'a> {
    model: &'a Model,
    net: Net,
    diags: &'a mut Diags,
    points: BTreeMap<String, u32>,
}

/// Adds links, force ports, outputs and probes.
pub fn wire(model: &Model, net: Net, options: &Options, diags: &mut Diags) -> Net {
    let mut w = Wire { model, net, diags, points: BTreeMap::new() };
    for id in 0..w.net.items.len() {
        if let Role::Lia(_) = w.net.items[id].kind.role {
            w.link(id as u32);
        }
    }
    for id in 0..w.net.items.len() {
        match w.net.items[id].kind.role {
            Role::Port(PortRole::Enf) => w.push(id as u32),
            Role::Port(PortRole::Sox) => w.output(id as u32, false),
            Role::Port(PortRole::Sof) => w.output(id as u32, true),
            _ => {}
        }
    }
    for probe in &options.probes {
        w.probe(probe);
    }
    w.net.alive = alloc::vec![true; w.net.mats.len()];
    w.net
}

impl Wire<'_> {
    fn item(&self, id: u32) -> &Item {
        &self.model.items[self.net.items[id as usize].model]
    }

    fn entry(&self, id: u32, key: &str) -> Option<Entry> {
        self.item(id).args.iter().find(|e| e.key == key).cloned()
    }

    /// Reads one selector and looks it up.
    fn select(&mut self, text: &str, span: Span, owner: &str, wants_mat: bool) -> Option<Meaning> {
        let sel = match select::parse(text) {
            Ok(s) => s,
            Err(e) => {
                let d = Diag::error("E015", format!("`{owner}`: `{text}` is not a selector")).at(span, e.message);
                self.diags.push(d.help("write e.g. `hammer`, `low[8]`, `low[-1]`, `low[*]` or `low@0.31`"));
                return None;
            }
        };
        let Some(family) = self.net.families.get(&sel.name) else {
            self.unknown(&sel.name, span, owner);
            return None;
        };
        if let Some(at) = &sel.at {
            let at = at.0.clone();
            return self.moving(text, &sel, &at, span, owner).map(|p| Meaning::Ends(alloc::vec![End::Point(p)]));
        }
        let plain_link = family.masses.is_empty() && !family.links.is_empty();
        let (list, links) = match sel.part {
            Part::Mass if plain_link => (&family.links, true),
            Part::Mass => (&family.masses, false),
            Part::Link => (&family.links, true),
            Part::End => (&family.tips, false),
        };
        let size = family.size;
        if links && wants_mat {
            let d = Diag::error("E017", format!("`{owner}`: `{text}` is a link, a MAT is wanted")).at(span, "a LIA");
            self.diags.push(d);
            return None;
        }
        let chosen = match pick(list, sel.index, size) {
            Ok(ids) => ids,
            Err(why) => {
                let (code, help) = match why {
                    Pick::Needs => (
                        "E016",
                        format!(
                            "`{}` is {} modules: write `{}[0]` or `{}[*]`",
                            sel.name,
                            list.len(),
                            sel.name,
                            sel.name
                        ),
                    ),
                    Pick::Outside if size[1] > 1 => {
                        ("E016", format!("`{}` goes from [0,0] to [{},{}]", sel.name, size[0] - 1, size[1] - 1))
                    }
                    Pick::Outside => (
                        "E016",
                        format!("`{}` has {} of them: 0 to {}", sel.name, list.len(), list.len().saturating_sub(1)),
                    ),
                };
                let d = Diag::error(code, format!("`{owner}`: no `{text}`")).at(span, "out of range").help(help);
                self.diags.push(d);
                return None;
            }
        };
        Some(if links { Meaning::Links(chosen) } else { Meaning::Ends(chosen.into_iter().map(End::Mat).collect()) })
    }

    fn unknown(&mut self, name: &str, span: Span, owner: &str) {
        let mut d = Diag::error("E013", format!("`{owner}`: no module `{name}`")).at(span, "unknown");
        if let Some(item) = self.model.items.iter().find(|i| i.name == name) {
            // it is there, but it is an output, or it is broken and reported elsewhere
            if matches!(item.kind.as_str(), "SOX" | "SOF" | "ENF") {
                d = Diag::error("E017", format!("`{owner}`: `{name}` is not something a link can hold"))
                    .at(span, format!("{} is not a MAT or LIA", item.kind));
            } else {
                return;
            }
        } else if let Some(near) = nearest(name, self.net.families.keys().map(String::as_str)) {
            d = d.help(format!("did you mean `{near}`?"));
        } else {
            d = d.help("declare it, e.g. under `[MAS]` or `[SOL]`");
        }
        self.diags.push(d);
    }

    /// A moving point; the same text is the same point.
    fn moving(&mut self, text: &str, sel: &Selector, at: &[Coord], span: Span, owner: &str) -> Option<u32> {
        if let Some(p) = self.points.get(text) {
            return Some(*p);
        }
        let family = &self.net.families[&sel.name];
        let wants = if family.size[1] > 1 { 2 } else { 1 };
        let nodes = family.nodes.len();
        let bad = |title: String, label: &str| Diag::error("E015", title).at(span, label);
        if nodes < 2 || sel.part != Part::Mass || sel.index != Index::None {
            let d = bad(format!("`{owner}`: nothing to move along in `{}`", sel.name), "not a string or mesh");
            self.diags.push(d.help("`name@s` needs a STRING, STIFFSTRING, CHAIN or MESH"));
            return None;
        }
        if at.len() != wants {
            let d = bad(format!("`{owner}`: `{}` takes {wants} coordinate(s), not {}", sel.name, at.len()), "here");
            let help =
                if wants == 2 { format!("write `{}@0.3,0.4`", sel.name) } else { format!("write `{}@0.3`", sel.name) };
            self.diags.push(d.help(help));
            return None;
        }
        let mut coordinates = Vec::new();
        for c in at {
            coordinates.push(match c {
                Coord::Num(v) if (0.0..=1.0).contains(v) => Coordinate::At(*v),
                Coord::Num(v) => {
                    let d = Diag::error("E009", format!("`{owner}`: coordinate {v} of `{}` is not in 0 … 1", sel.name));
                    self.diags.push(d.at(span, "out of range"));
                    return None;
                }
                Coord::Name(n) => self.coordinate(n, span, owner)?,
            });
        }
        let id = self.net.points.len() as u32;
        self.net.points.push(PointNode { name: text.into(), family: sel.name.clone(), at: coordinates });
        self.points.insert(text.into(), id);
        Some(id)
    }

    fn coordinate(&mut self, name: &str, span: Span, owner: &str) -> Option<Coordinate> {
        if let Some(p) = self.net.params.iter_mut().find(|p| p.name == name) {
            // the place it stands in bounds it, unless the author was stricter
            p.min = p.min.max(0.0);
            p.max = p.max.min(1.0);
        }
        if let Some(p) = self.net.params.iter().position(|p| p.name == name) {
            return Some(Coordinate::Live(p as u32));
        }
        if let Some(v) = self.net.constants.get(name) {
            return Some(Coordinate::At(v.clamp(0.0, 1.0)));
        }
        let mat = self.net.families.get(name).and_then(|f| f.masses.first().copied());
        match mat {
            Some(m) if matches!(self.net.mats[m as usize].role, super::net::MatRole::Port(..)) => {
                Some(Coordinate::Port(m))
            }
            _ => {
                let d =
                    Diag::error("E013", format!("`{owner}`: no parameter or port `{name}`")).at(span, "unknown place");
                self.diags.push(d.help("a moving point follows a number, a `[param]`, or an ENX or TGR port"));
                None
            }
        }
    }

    /// The ends on one side of `between`.
    fn side(&mut self, e: &Entry, owner: &str) -> Option<Vec<End>> {
        match &e.value {
            Value::Text(t) => match self.select(t, e.span, owner, true)? {
                Meaning::Ends(v) => Some(v),
                Meaning::Links(_) => None,
            },
            Value::List(l) => {
                let sides: Vec<_> = l.iter().map(|x| self.side(x, owner)).collect();
                sides.into_iter().collect::<Option<Vec<_>>>().map(|v| v.concat())
            }
            _ => {
                let d = Diag::error("E006", format!("`between` of `{owner}` holds names")).at(e.span, "not a name");
                self.diags.push(d.help("write `between = [\"first\", \"second\"]`"));
                None
            }
        }
    }

    fn link(&mut self, id: u32) {
        let (name, kind) = (self.net.items[id as usize].name.clone(), self.net.items[id as usize].kind);
        let Role::Lia(law) = kind.role else { return };
        let Some(e) = self.entry(id, "between") else { return };
        let Value::List(l) = &e.value else {
            let d = Diag::error("E006", format!("`between` of `{name}` must be a list of two ends")).at(e.span, "here");
            self.diags.push(d.help("write `between = [\"first\", \"second\"]`"));
            return;
        };
        let [first, second] = l.as_slice() else {
            let d =
                Diag::error("E018", format!("`between` of `{name}` has {} ends, not two", l.len())).at(e.span, "here");
            self.diags.push(d.help("write `between = [\"first\", \"second\"]`; each side may itself be a list"));
            return;
        };
        let (a, b) = (self.side(first, &name), self.side(second, &name));
        let (Some(a), Some(b)) = (a, b) else { return };
        let arg = |key: &str| kind.param(key).and_then(|i| self.net.items[id as usize].args[i].num());
        let all = arg("pairs") == Some(1.0);
        let pairs: Vec<[End; 2]> = if all && a == b {
            (0..a.len()).flat_map(|i| (i + 1..a.len()).map(move |j| (i, j))).map(|(i, j)| [a[i], a[j]]).collect()
        } else if all {
            a.iter().flat_map(|x| b.iter().map(move |y| [*x, *y])).collect()
        } else if a.len() == b.len() {
            a.iter().zip(&b).map(|(x, y)| [*x, *y]).collect()
        } else if a.len() == 1 || b.len() == 1 {
            (0..a.len().max(b.len())).map(|i| [a[i.min(a.len() - 1)], b[i.min(b.len() - 1)]]).collect()
        } else {
            let d = Diag::error("E018", format!("`{name}`: {} ends on one side, {} on the other", a.len(), b.len()));
            let d = d.at(e.span, "do not pair").help("give equal numbers, one against many, or `pairs = \"all\"`");
            self.diags.push(d);
            return;
        };
        if self.net.lias.len() + pairs.len() > super::resolve::LARGEST {
            self.diags.push(
                Diag::error("E027", format!("`{name}` makes too many links: {}", pairs.len())).at(e.span, "here"),
            );
            return;
        }
        let values: Arc<[Source]> = (0..kind.params.len() as u32).map(Source::Slot).collect();
        let l0 = arg("l0");
        let many = pairs.len() > 1;
        let mut made = Vec::with_capacity(pairs.len());
        for (i, ends) in pairs.into_iter().enumerate() {
            if ends[0] == ends[1] {
                let d = Diag::error("E022", format!("`{name}` joins `{}` to itself", self.net.end_name(ends[0])));
                self.diags.push(d.at(e.span, "the same at both ends"));
                return;
            }
            made.push(self.net.lias.len() as u32);
            let name = if many { format!("{name}[{i}]") } else { name.clone() };
            self.net.lias.push(LiaNode { name, kind, law, values: values.clone(), ends, l0, item: id });
        }
        self.net.families.entry(name).or_default().links = made;
    }

    fn push(&mut self, id: u32) {
        let name = self.net.items[id as usize].name.clone();
        let Some(e) = self.entry(id, "to") else { return };
        let Some(ends) = self.side(&e, &name) else { return };
        let Some(input) = self.net.inputs.iter().position(|i| i.name == name) else { return };
        self.net.pushes.extend(ends.into_iter().map(|end| (input as u32, end)));
    }

    fn ears(&mut self, e: &Entry, name: &str, force: bool) -> Vec<Ear> {
        let Value::Text(text) = &e.value else {
            let d = Diag::error("E006", format!("`from` of `{name}` must be the name of a module")).at(e.span, "here");
            self.diags.push(d);
            return Vec::new();
        };
        match self.select(text, e.span, name, !force) {
            Some(Meaning::Links(l)) => l.into_iter().map(Ear::ForceOf).collect(),
            Some(Meaning::Ends(v)) if force => v.into_iter().map(Ear::ForceOn).collect(),
            Some(Meaning::Ends(v)) => v.into_iter().map(Ear::Position).collect(),
            None => Vec::new(),
        }
    }

    fn output(&mut self, id: u32, force: bool) {
        let item = &self.net.items[id as usize];
        let (name, kind) = (item.name.clone(), item.kind);
        let index = |key: &str| kind.param(key).unwrap_or(0);
        let channel = item.args[index("channel")].num();
        let Some(e) = self.entry(id, "from") else { return };
        let ears = self.ears(&e, &name, force);
        let many = ears.len() > 1 && channel.is_none();
        for (i, ear) in ears.into_iter().enumerate() {
            let own = if many { format!("{name}[{i}]") } else { name.clone() };
            let channel = channel.map_or(self.net.channels.len() as u32, |c| c as u32);
            while self.net.channels.len() <= channel as usize {
                self.net.channels.push(own.clone());
            }
            if channel > 255 {
                let d = Diag::error("E027", format!("`{name}` would make more than 256 channels")).at(e.span, "here");
                self.diags.push(d.help("give several outputs the same `channel`"));
                return;
            }
            let gain = Source::Slot(index("gain") as u32);
            self.net.outs.push(OutNode { name: own, ear, channel, gain, item: Some(id) });
        }
    }

    fn probe(&mut self, text: &str) {
        // an output's name means what it hears
        if let Some(o) = self.net.outs.iter().find(|o| o.name == text && o.item.is_some()) {
            let (ear, channel) = (o.ear, self.net.channels.len() + self.probes());
            let out = OutNode { name: text.into(), ear, channel: channel as u32, gain: Source::Const(1.0), item: None };
            self.net.outs.push(out);
            return;
        }
        let ears = match self.select(text, Span::NONE, "probe", false) {
            Some(Meaning::Links(l)) => l.into_iter().map(Ear::ForceOf).collect::<Vec<_>>(),
            Some(Meaning::Ends(v)) => v.into_iter().map(Ear::Position).collect(),
            None => return,
        };
        let many = ears.len() > 1;
        for (i, ear) in ears.into_iter().enumerate() {
            let channel = (self.net.channels.len() + self.probes()) as u32;
            let name = if many { format!("{text}#{i}") } else { text.into() };
            self.net.outs.push(OutNode { name, ear, channel, gain: Source::Const(1.0), item: None });
        }
    }

    fn probes(&self) -> usize {
        self.net.outs.iter().filter(|o| o.item.is_none()).count()
    }
}

enum Pick {
    Needs,
    Outside,
}

fn pick(list: &[u32], index: Index, size: [u32; 2]) -> Result<Vec<u32>, Pick> {
    let wrap = |i: i64, n: usize| {
        let at = if i < 0 { i + n as i64 } else { i };
        usize::try_from(at).ok().filter(|k| *k < n).ok_or(Pick::Outside)
    };
    match index {
        Index::None if list.len() == 1 => Ok(list.to_vec()),
        Index::None => Err(Pick::Needs),
        Index::All => Ok(list.to_vec()),
        Index::One(i) => Ok(alloc::vec![list[wrap(i, list.len())?]]),
        Index::Two(i, j) => {
            let (i, j) = (wrap(i, size[0] as usize)?, wrap(j, size[1] as usize)?);
            list.get(i * size[1] as usize + j).map(|m| alloc::vec![*m]).ok_or(Pick::Outside)
        }
        Index::Range(a, b) => {
            let n = list.len();
            let a = wrap(a, n)?;
            let b = if b == n as i64 { n } else { wrap(b, n)? };
            if a < b { Ok(list[a..b].to_vec()) } else { Err(Pick::Outside) }
        }
    }
}
