//! Resolves selectors to modules of the network.
//!
//! A name that exists but could not be compiled is ignored silently: its error is reported at its own place, and one
//! mistake gives one finding.

use crate::connect::wiring::Wiring;
use crate::findings::inside;
use crate::net::families::Members;
use crate::net::{Coordinate, End, MatRole, PointNode};
use alloc::format;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use ca_model::LARGEST;
use ca_model::Span;
use ca_model::diag::Diag;
use ca_model::quantity::Plain;
use ca_model::select::{self, Coord, Index, Part, Selector};
use ca_model::suggest::nearest;

/// Modules that a selector refers to.
pub(super) enum Meaning {
    Ends(Vec<End>),
    Links(Vec<u32>),
}

/// A selector as written: its text, its span with the quotes, and the module that contains it.
#[derive(Clone, Copy)]
pub(super) struct Written<'t> {
    pub text: &'t str,
    pub span: Span,
    pub owner: &'t str,
}

impl Written<'_> {
    fn part(&self, from: usize, to: usize) -> Span {
        inside(self.span, self.text, from, to)
    }
    fn lead(&self) -> usize {
        self.text.len() - self.text.trim_start().len()
    }
    pub(super) fn name(&self, name: &str) -> Span {
        self.part(self.lead(), self.lead() + name.len())
    }
    /// Returns the span from the first `[` or `@` to the end, or of the whole text.
    fn index(&self) -> Span {
        let from = self.text.find(['[', '@']).unwrap_or(self.lead());
        self.part(from, self.text.trim_end().len())
    }
}

impl Wiring<'_> {
    /// Resolves a selector. `wants_mat` is the reason why it must refer to MATs, if it must.
    pub(super) fn select(&mut self, w: Written<'_>, wants_mat: Option<&str>) -> Option<Meaning> {
        let sel = match select::parse(w.text) {
            Ok(s) => s,
            Err(e) => {
                let name = w.text.split(['[', '@', '(']).next().unwrap_or("").trim();
                if self.is_reported(name) {
                    return None;
                }
                self.not_a_selector(w, &e);
                return None;
            }
        };
        let Some(family) = self.net.families.get(&sel.name) else {
            self.unknown(&sel.name, w, wants_mat);
            return None;
        };
        if let Some(at) = &sel.at {
            return self.moving(&sel, &at.0, w).map(|p| Meaning::Ends(alloc::vec![End::Point(p)]));
        }
        let plain_link = family.masses.is_empty() && !family.links.is_empty();
        let (list, links) = match sel.part {
            Part::Mass if plain_link => (family.links, true),
            Part::Mass => (family.masses, false),
            Part::Link => (family.links, true),
            Part::End => (family.anchors, false),
        };
        if let (true, Some(why)) = (links, wants_mat) {
            let d = Diag::error("E017", format!("`{}`: `{}` is a link, not a mass", w.owner, w.text.trim()));
            self.diags.push(d.at(w.span, "a LIA").help(why));
            return None;
        }
        match pick(list, sel.index, family.size) {
            Ok(ids) if links => Some(Meaning::Links(ids)),
            Ok(ids) => Some(Meaning::Ends(ids.into_iter().map(End::Mat).collect())),
            Err(why) => {
                let d = outside(w, &sel, list.len(), family, &why);
                self.diags.push(d);
                None
            }
        }
    }

    fn not_a_selector(&mut self, w: Written<'_>, e: &select::SelectError) {
        // Label the wrong character with the word that it begins.
        let rest = w.text.get(e.at..).unwrap_or("");
        let word = rest.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(rest.len());
        let len = word.max(rest.chars().next().map_or(0, char::len_utf8));
        // Something missing at the end is labelled at the last character.
        let last = w.text.get(..e.at).and_then(|t| t.chars().next_back()).map_or(0, char::len_utf8);
        let (from, to) = if len == 0 { (e.at - last, e.at) } else { (e.at, e.at + len) };
        let shown: String = w.text.chars().take(40).collect();
        let shown =
            if w.text.trim().is_empty() { "an empty text".into() } else { format!("`{}`", shown.escape_debug()) };
        let d = Diag::error("E015", format!("`{}`: {shown} is not a selector", w.owner));
        let d = d.at(w.part(from, to), e.message.clone());
        let meant = brackets(w.text).filter(|m| select::parse(m).is_ok());
        self.diags.push(match meant {
            Some(m) => d.help(format!("did you mean `{m}`?")).fix(w.span, format!("\"{m}\"")),
            None => d.help("write e.g. `hammer`, `low[8]`, `low[-1]`, `low[*]` or `low@0.31`"),
        });
    }

    /// Returns a moving point; equal texts share one.
    fn moving(&mut self, sel: &Selector, at: &[Coord], w: Written<'_>) -> Option<u32> {
        let text = sel.to_string();
        if let Some(p) = self.points.get(&text) {
            return Some(*p);
        }
        let family = self.net.families.of(&sel.name);
        let wants = if family.size[1] > 1 { 2 } else { 1 };
        let (owner, name, nodes) = (w.owner, &sel.name, family.nodes.len());
        if nodes < 2 || sel.part != Part::Mass || sel.index != Index::None {
            let d = Diag::error("E017", format!("`{owner}`: a point cannot move along `{name}`"))
                .at(w.index(), "a single module");
            let one = if family.masses.len() > 1 { format!("{name}[0]") } else { name.clone() };
            self.diags.push(d.help(format!(
                "a moving point needs a row or a grid of masses, e.g. a STRING or a MESH; for a single module, write \
                 `{one}`"
            )));
            return None;
        }
        if self.net.mats[family.nodes[0] as usize].in_space() {
            let d = Diag::error("E029", format!("`{owner}`: a point cannot move along `{name}`, which is in space"));
            let help = format!("name a node of `{name}`, or link a mesh or string on a line to it with `along`");
            self.diags.push(d.at(w.index(), "in space").help(help));
            return None;
        }
        if at.len() != wants {
            let (help, is) = if wants == 2 {
                (format!("write `{name}@0.3,0.4`: one coordinate for each side"), "a mesh has two coordinates")
            } else {
                (format!("write `{name}@0.3`: a coordinate along its length"), "a string has one coordinate")
            };
            let d = Diag::error(
                "E015",
                format!(
                    "`{owner}`: `{name}` takes {wants} coordinate{}, not {}",
                    if wants == 1 { "" } else { "s" },
                    at.len()
                ),
            );
            let d = d.at(w.index(), is);
            // A decimal comma, e.g. 0,3 for 0.3.
            let comma = w.text.trim().replace(',', ".");
            let decimal = wants == 1 && select::parse(&comma).is_ok_and(|s| s.at.is_some_and(|a| a.0.len() == 1));
            self.diags.push(if decimal {
                d.help("the decimal sign is a dot").fix(w.span, format!("\"{comma}\""))
            } else {
                d.help(help)
            });
            return None;
        }
        let mut coordinates = Vec::new();
        for c in at {
            coordinates.push(match c {
                Coord::Num(v) if (0.0..=1.0).contains(v) => Coordinate::At(*v),
                Coord::Num(v) => {
                    let d = Diag::error(
                        "E009",
                        format!("`{owner}`: coordinate {} on `{name}` is not between 0 and 1", Plain(*v)),
                    );
                    let d = d.at(w.index(), "beyond the end");
                    self.diags.push(d.help(format!(
                        "use a value from 0 (one end) to 1 (the other end); a single mass is `{name}[{}]`",
                        libm::trunc(*v)
                    )));
                    return None;
                }
                Coord::Name(n) => self.coordinate(n, w)?,
            });
        }
        self.under += nodes;
        if self.under > 4 * LARGEST {
            // Reported once.
            if self.under - nodes <= 4 * LARGEST {
                let title = format!("`{owner}`: too many moving points on long strings");
                let d = Diag::error("E027", title).at(w.span, "one too many");
                let help = "use fewer moving points or shorter strings: each point counts all masses of its string";
                self.diags.push(d.help(help));
            }
            return None;
        }
        let id = self.net.points.len() as u32;
        self.net.points.push(PointNode { name: text.clone(), family: sel.name.clone(), at: coordinates, shape: None });
        self.points.insert(text, id);
        Some(id)
    }

    fn coordinate(&mut self, name: &str, w: Written<'_>) -> Option<Coordinate> {
        self.net.unused.retain(|u| u.0 != name);
        if let Some(i) = self.net.params.iter().position(|p| p.name == name) {
            let p = &mut self.net.params[i];
            // A coordinate limits the parameter to 0..1, within the limits of the author.
            p.min = p.min.max(0.0);
            p.max = p.max.min(1.0);
            if !(p.min..=p.max).contains(&p.value) {
                let v = p.value;
                return self.off_the_end(name, v, w);
            }
            return Some(Coordinate::Live(i as u32));
        }
        if let Some(v) = self.net.constants.get(name).copied() {
            if !(0.0..=1.0).contains(&v) {
                return self.off_the_end(name, v, w);
            }
            return Some(Coordinate::At(v));
        }
        let mat = self.net.families.get(name).and_then(|f| f.masses.first().copied());
        if let Some(m) = mat.filter(|m| matches!(self.net.mats[*m as usize].role, MatRole::Port(..))) {
            return Some(Coordinate::Port(m));
        }
        if self.is_reported(name) || self.model.params.iter().any(|p| p.key == name) {
            return None;
        }
        let ports = self.net.mats.iter().filter(|m| matches!(m.role, MatRole::Port(..))).map(|m| &*m.name.of);
        let params = self.model.params.iter().map(|p| p.key.as_str());
        let near = nearest(name, params.chain(ports));
        let from = w.text.find('@').map_or(0, |i| i + 1);
        let from = w.text.get(from..).and_then(|t| t.find(name)).map_or(from, |i| from + i);
        let span = w.part(from, from + name.len());
        let d =
            Diag::error("E013", format!("`{}`: no parameter or port `{name}`", w.owner)).at(span, "unknown coordinate");
        self.diags.push(match near {
            Some(near) if span != w.span => d.help(format!("did you mean `{near}`?")).fix(span, near),
            _ => d.help("a coordinate is a number, a `[param]`, or an ENX or TGR port"),
        });
        None
    }

    fn off_the_end(&mut self, name: &str, v: f64, w: Written<'_>) -> Option<Coordinate> {
        let d = Diag::error("E009", format!("`{}`: coordinate `{name}` is not between 0 and 1: {}", w.owner, Plain(v)));
        self.diags.push(d.at(w.index(), "beyond the end").help("use a value from 0 (one end) to 1 (the other end)"));
        None
    }
}

/// Rewrites `low(3)`, `low{3}`, `low 3` and `low.3` as `low[3]`.
fn brackets(text: &str) -> Option<String> {
    let text = text.trim();
    let name = text.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_'))?;
    let index = text[name..].trim_matches(|c: char| " .(){}[]<>".contains(c));
    (!index.is_empty()).then(|| format!("{}[{index}]", &text[..name]))
}

/// Reason why an index selects nothing.
enum Pick {
    Needs,
    Outside,
    Empty,
    /// Two indices on something other than a mesh.
    Row,
}

fn pick(list: &[u32], index: Index, size: [u32; 2]) -> Result<Vec<u32>, Pick> {
    let wrap = |i: i64, n: usize| {
        let at = if i < 0 { i + n as i64 } else { i };
        usize::try_from(at).ok().filter(|k| *k < n).ok_or(Pick::Outside)
    };
    match index {
        _ if list.is_empty() => Err(Pick::Outside),
        Index::None if list.len() == 1 => Ok(list.to_vec()),
        Index::None => Err(Pick::Needs),
        Index::All => Ok(list.to_vec()),
        Index::One(i) => Ok(alloc::vec![list[wrap(i, list.len())?]]),
        Index::Two(..) if size[1] < 2 => Err(Pick::Row),
        Index::Two(i, j) => {
            let (i, j) = (wrap(i, size[0] as usize)?, wrap(j, size[1] as usize)?);
            list.get(i * size[1] as usize + j).map(|m| alloc::vec![*m]).ok_or(Pick::Outside)
        }
        Index::Range(a, b) => {
            let n = list.len();
            let a = wrap(a, n)?;
            let b = if b == n as i64 { n } else { wrap(b, n)? };
            if a < b { Ok(list[a..b].to_vec()) } else { Err(Pick::Empty) }
        }
    }
}

fn outside(w: Written<'_>, sel: &Selector, n: usize, family: Members<'_>, why: &Pick) -> Diag {
    let name = match sel.part {
        Part::Mass => sel.name.clone(),
        Part::Link => format!("{}.link", sel.name),
        Part::End => format!("{}.end", sel.name),
    };
    let title = |what: String| Diag::error("E016", format!("`{}`: {what}", w.owner));
    let mesh = family.size[1] > 1 && sel.part == Part::Mass;
    let one = if mesh { format!("`{name}[3,4]`") } else { format!("`{name}[0]`") };
    match why {
        Pick::Needs => {
            let d = title(format!("`{name}` has {n} modules and needs an index")).at(w.span, "without an index");
            d.help(format!("write {one} for one of them, `{name}[*]` for all"))
        }
        Pick::Row => {
            let d = title(format!("no module `{}`", w.text.trim())).at(w.index(), "two indices");
            d.help(format!("`{name}` is not a mesh: write one index, e.g. {one}"))
        }
        Pick::Empty => {
            let d = title(format!("`{}` selects nothing", w.text.trim())).at(w.index(), "an empty range");
            d.help("the second index is excluded: `[2..5]` selects 2, 3 and 4")
        }
        Pick::Outside if n == 0 => {
            title(format!("`{name}` does not exist")).at(w.index(), "nothing to select").help(match sel.part {
                Part::End => "only a string whose ends are fixed or hinged has `.end`",
                _ => "name the module itself, without an index or `.link`",
            })
        }
        Pick::Outside => {
            let d = title(format!("no module `{}`", w.text.trim())).at(w.index(), "beyond the end");
            d.help(if mesh {
                format!("`{name}` has the indices [0,0] to [{},{}]", family.size[0] - 1, family.size[1] - 1)
            } else if n == 1 {
                format!("`{name}` is one module: write `{name}`, or `{name}[0]`")
            } else {
                format!("`{name}` has {n} modules: [0] to [{}], or [-{n}] to [-1] from the end", n - 1)
            })
        }
    }
}
